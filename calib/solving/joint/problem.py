"""What a solve is given and what it gives back."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.solving.joint.mixture import Mixture
from calib.solving.joint.normal_equations import ArrowCovariance
from calib.solving.joint.parameters import Estimate, Layout
from calib.solving.joint.residuals import Linear
from calib.solving.observations import Observations


@dataclass(frozen=True, slots=True, eq=False)
class Prior:
    """What is known of the global parameters beforehand.

    Attributes
    ----------
    camera
        Shape (9,), the expected intrinsics.
    information
        Inverse covariance of the free ones, in the order of the layout.
    """

    camera: FloatArray
    information: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """What is to be solved.

    Attributes
    ----------
    observations, layout, prior
        The points; the free parameters; what is known of the camera beforehand, if anything.
    stripe_in
        Shape (M,), the views whose stripe takes part.
    on_line
        Shape (N,), the stripe points that lie on the line of their own view's stripe.
    """

    observations: Observations
    layout: Layout
    prior: Prior | None
    stripe_in: BoolArray
    on_line: BoolArray

    @property
    def stripe_present(self) -> BoolArray:
        """The stripe points of the views whose stripe takes part, shape (N,)."""
        return np.asarray(self.stripe_in[self.observations.stripe.view])

    def prior_at(self, estimate: Estimate) -> tuple[FloatArray, FloatArray]:
        """Return the prior's information on the global block, (G, G), and its gap, (G,)."""
        size, free = self.layout.size, list(self.layout.camera)
        information, gap = np.zeros((size, size)), np.zeros(size)
        if self.prior is not None:
            information[: len(free), : len(free)] = self.prior.information
            gap[: len(free)] = (self.prior.camera - estimate.camera)[free]
        return information, gap


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """The end of a solve that converged.

    Attributes
    ----------
    estimate
        The answer.
    dots, stripe
        Residuals and Jacobian there.
    dots_mixture, stripe_mixture
        How the points scatter.
    covariance
        Of poses and global parameters, scaled by the scatter seen.
    cost
        Half the weighted sum of squares.
    iterations
        Steps taken.
    """

    estimate: Estimate
    dots: Linear
    stripe: Linear
    dots_mixture: Mixture
    stripe_mixture: Mixture
    covariance: ArrowCovariance
    cost: float
    iterations: int
