"""Which points nine sigma can set right, and how large a sigma is."""

from dataclasses import dataclass, replace

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.lines import fit_line
from calib.solving.deviation.state import Frame
from calib.solving.joint.parameters import Estimate, Layout
from calib.solving.joint.residuals import linearise_dots
from calib.solving.observations import DotTable, StripeTable
from calib.solving.prepared import Prepared

SIGMAS_ALLOWED = 9.0
"""n of the paper: a deviation is held within +-n sigma."""

# A normal variable has the median size 0.6745 sigma.
_MEDIAN_SIZE = 0.6745


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """The points that take part.

    Attributes
    ----------
    dots, stripe
        Shapes (N,) and (S,).
    widened_dots, widened_stripe
        How many times their sigma the points scatter about a first answer; 1 where less.
    """

    dots: BoolArray
    stripe: BoolArray
    widened_dots: float
    widened_stripe: float

    @classmethod
    def of(cls, prepared: Prepared) -> "Reach":
        """Compare dots with their robust poses, stripe points with the line of their stripe."""
        estimate = Estimate.start(prepared.camera, prepared.plane, list(prepared.poses))
        seen = prepared.observations
        off_dots = np.abs(linearise_dots(seen, estimate, Layout((), plane=False)).residual)
        off_stripe = _off_lines(prepared)
        believed = prepared.on_line & prepared.stripe_in[seen.stripe.view]
        dots, stripe = _widened(off_dots), _widened(off_stripe[believed])
        return cls(
            np.asarray(off_dots.max(axis=1) <= SIGMAS_ALLOWED * dots),
            np.asarray(off_stripe <= SIGMAS_ALLOWED * stripe),
            dots,
            stripe,
        )

    def frame(self, prepared: Prepared) -> Frame:
        """Return what is seen of the points that take part, their sigmas widened."""
        dots, stripe = prepared.observations.dots, prepared.observations.stripe
        turned = np.array([
            np.abs(pose.rotation.T @ prepared.plane.normal_in_cam) for pose in prepared.poses
        ])
        observations = replace(
            prepared.observations,
            dots=DotTable(
                view=dots.view[self.dots],
                board_mm=dots.board_mm[self.dots],
                seen_px=dots.seen_px[self.dots],
                sigma_px=self.widened_dots * dots.sigma_px[self.dots],
            ),
            stripe=StripeTable(
                view=stripe.view[self.stripe],
                seen_px=stripe.seen_px[self.stripe],
                normal=stripe.normal[self.stripe],
                sigma_px=self.widened_stripe * stripe.sigma_px[self.stripe],
                along_px=stripe.along_px[self.stripe],
            ),
            radius_mm=0.0,
        )
        return Frame(observations, prepared.camera, along_rows=turned[:, 1] >= turned[:, 0])


def _off_lines(prepared: Prepared) -> FloatArray:
    """Return distances of stripe points from their stripe's line over sigma; inf for false ones."""
    table = prepared.observations.stripe
    rays = prepared.camera.rays(table.seen_px)[:, :2]
    off = np.full(len(table), np.inf)
    for view in np.flatnonzero(prepared.stripe_in):
        own = table.view == view
        line = fit_line(rays[own & prepared.on_line])
        off_px = prepared.camera.fx * np.abs(rays[own] @ line[:2] + line[2])
        off[own] = off_px / table.sigma_px[own]
    return off


def _widened(off_sigma: FloatArray) -> float:
    return max(1.0, float(np.median(off_sigma)) / _MEDIAN_SIZE)
