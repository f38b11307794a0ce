"""Finding the stripe in whole frames: time and error beside peers, sigma beside the bound."""

from collections.abc import Sequence

import numpy as np

from calib import FloatArray, Picture, kernel_of, locate_stripe
from station.bench.peers import NOT_INSTALLED
from station.bench.peers_stripe import Extract, extractors
from station.bench.stripe_frames import (
    HEIGHT_PX,
    WIDTH_PX,
    Glare,
    StripeFrame,
    off_stripe_px,
)
from station.bench.timing import CoreTime
from station.progress import Progress
from station.tables import Table, Value

_NEAR_PX = 3.0
_TIMED_RUNS = 5
_FIGURES = (
    "ms",
    "spread, ms",
    "RMS, px",
    "RMS weighted, px",
    "error over sigma, RMS",
    "columns found",
    "false points",
)
# Widths at and between the kernels, heights and noise from strong to weak.
_STRIPES = ((1.5, 150.0, 2.0), (2.0, 150.0, 2.0), (2.5, 150.0, 2.0), (3.0, 60.0, 3.0))
_PIXEL_VARIANCE = 1.0 / 12.0


def bench_stripe(progress: Progress, *, runs: int = _TIMED_RUNS, seed: int = 1) -> Table:
    """Find the stripe in a clean frame and in one with glare, by ours and by the peers.

    Parameters
    ----------
    progress
        Told where the bench is.
    runs
        Timed runs of each.
    seed
        Of the noise.
    """
    rows: list[dict[str, Value]] = []
    found = extractors()
    for place, glare in enumerate(Glare):
        picture = StripeFrame(glare=glare).taken(np.random.default_rng([seed, place]))
        for step, (name, extract) in enumerate(found.items()):
            progress((place + step / len(found)) / len(Glare), f"{name}, {glare}")
            row: dict[str, Value] = {"frame": glare.value, "by": name}
            rows.append(row | _figures(extract, picture, runs))
    notes = (
        f"{WIDTH_PX} x {HEIGHT_PX} px, one stripe from side to side, sigma 2 px, 150 counts. Time "
        f"of one core: median of {runs} runs and the distance between their quartiles. Error "
        f"across the stripe of points within {_NEAR_PX:g} px of it; the others are false "
        "points. Weighted: by 1 / sigma squared, as a solve does.",
        "Treadline finds width and noise by itself and gives each point a sigma; the peers are "
        "told the width, and give none. scikit-image's Hessian is completed with Steger's offset.",
    )
    return Table("Stripe in a whole frame", rows, notes)


def _figures(extract: Extract | None, picture: Picture, runs: int) -> dict[str, Value]:
    if extract is None:
        return dict.fromkeys(_FIGURES, NOT_INSTALLED)
    ridges = extract(picture)
    off = off_stripe_px(ridges.centre_px)
    near = np.abs(off) <= _NEAR_PX
    if not near.any():
        return dict.fromkeys(_FIGURES, "none found")
    taken = CoreTime.of(lambda: extract(picture), runs=runs)
    weighted: Value = "no sigma"
    scaled: Value = "no sigma"
    if ridges.sigma_px is not None:
        sigma = ridges.sigma_px[near]
        weighted = float(np.sqrt(np.average(off[near] ** 2, weights=sigma**-2)))
        scaled = _rms([off[near] / sigma])
    columns = len(np.unique(np.rint(ridges.centre_px[near, 0])))
    figures: tuple[Value, ...] = (
        1e3 * taken.median_s,
        1e3 * taken.spread_s,
        _rms([off[near]]),
        weighted,
        scaled,
        f"{columns / WIDTH_PX:.1%}",
        int((~near).sum()),
    )
    return dict(zip(_FIGURES, figures, strict=True))


def bench_stripe_sigma(progress: Progress, *, pictures: int = 20, seed: int = 1) -> Table:
    """Compare the sigma of stripe points with their scatter and with the bound, in white noise.

    Parameters
    ----------
    progress
        Told where the bench is.
    pictures
        Frames a row.
    seed
        Of the noise.
    """
    rows = []
    for place, stripe in enumerate(_STRIPES):
        progress(place / len(_STRIPES), f"width {stripe[0]:g} px")
        rows.append(_sigma_row(*stripe, pictures, np.random.default_rng([seed, 7, place])))
    note = (
        f"{pictures} frames of {WIDTH_PX} x {HEIGHT_PX} px a row, the noise told from the picture. "
        "Bound: Cramér-Rao for as much of a straight stripe, of known width and height on a known "
        "ground, as the kernel averages along it (2 sqrt(pi) of its sigma)."
    )
    return Table("Sigma of a stripe point, px, in white noise", rows, (note,))


def _sigma_row(
    width_px: float, height: float, noise: float, pictures: int, rng: np.random.Generator
) -> dict[str, Value]:
    frame = StripeFrame(width_px, height)
    found = [locate_stripe(frame.taken(rng, white_noise=noise)) for _ in range(pictures)]
    scatter = _rms([off_stripe_px(points.centre_px) for points in found])
    sigma = _rms([points.sigma_px for points in found])
    # Rounding to whole counts is noise as well.
    sigma_noise = np.sqrt(noise**2 + 1.0 / 12.0)
    kernels = [kernel_of(points.width_px) for points in found]
    bound = _rms([stripe_bound_px(width_px, height, sigma_noise, kernel) for kernel in kernels])
    return {
        "width, px": width_px,
        "height": height,
        "noise": noise,
        "sigma told": sigma,
        "scatter": scatter,
        "bound": bound,
        "told over scatter": sigma / scatter,
        "told over bound": sigma / bound,
        "scatter over bound": scatter / bound,
    }


def _rms(parts: Sequence[FloatArray]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


def stripe_bound_px(
    width_px: float, height: float, noise: float, kernel_px: FloatArray
) -> FloatArray:
    r"""Return the least standard deviation of stripe points in white noise, px.

    Parameters
    ----------
    width_px, height
        :math:`\sigma_w` and M of the stripe's Gaussian profile before the pixels average it, px
        and counts.
    noise
        Standard deviation of a pixel, counts.
    kernel_px
        Shape (N,), :math:`\sigma_g` of each point's kernel: how much of the stripe it averages.

    Returns
    -------
    sigma_px
        Shape (N,), across the stripe.

    Notes
    -----
    A length L of stripe tells its place with Fisher's information

    .. math:: L \int (\partial I / \partial c)^2 dc / \sigma_N^2
              = L \sqrt{\pi} M^2 / (2 \sigma_w \sigma_N^2)

    A Gaussian kernel averages over :math:`L = 2 \sqrt{\pi} \sigma_g`, the inverse of the integral
    of its square. Where :math:`\sigma_g = \sigma_w` this is Eq. 9 of the paper. The pixels' area
    widens the profile to :math:`\sigma_w^2 + 1/12` and leaves the light in it the same.
    """
    seen_px = np.sqrt(width_px**2 + _PIXEL_VARIANCE)
    seen_height = height * width_px / seen_px
    length = 2.0 * np.sqrt(np.pi) * kernel_px
    information = length * np.sqrt(np.pi) * seen_height**2 / (2.0 * seen_px * noise**2)
    return np.asarray(1.0 / np.sqrt(information))
