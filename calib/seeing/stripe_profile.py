"""The brightness across a stripe: its height, width and ground, fitted where it is not clipped."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.seeing.noise import SATURATED_FROM
from calib.seeing.resample import Float32Array, sampled

_MOST_STEPS = 3
_STEPS_IF_CLIPPED = 11  # of a clipped stripe the flanks alone tell the height
_SETTLED_PX = 0.05  # the next step changes centre and width by a hundredth of that
_DAMPING = 1e-3
_RESAMPLING_VARIANCE = 1.0 / 6.0  # px^2: what going between pixels adds to a profile's width
_NARROWEST_PX, _WIDEST_PX = 0.4, 14.0
_HIGHEST = 5000.0  # counts: of a clipped bell
_FARTHEST_OFF_PX = 7.0  # from the middle: seeds are nearer to their stripe


@dataclass(frozen=True, slots=True, eq=False)
class Profiles:
    """Fits of ``height * exp(-(c - centre)² / 2 width²) + ground + slope * c``.

    Attributes
    ----------
    height, ground
        Shape (N,), counts; the height may exceed 255 where the sensor clips.
    centre_px, width_px
        Shape (N,), along the normal, from the place asked for.
    slope
        Shape (N,), of the ground, counts / px.
    misfit
        Shape (N,), rms of what the fit leaves, counts.
    saturated
        Shape (N,), the profile touches the sensor's limit.
    """

    height: FloatArray
    centre_px: FloatArray
    width_px: FloatArray
    ground: FloatArray
    slope: FloatArray
    misfit: FloatArray
    saturated: BoolArray

    @property
    def reach_px(self) -> FloatArray:
        """How far from the middle the fits look, shape (N,)."""
        return np.asarray(_reach_px(self.width_px))

    def picked(self, index: IntArray) -> "Profiles":
        """Return the fits an index array picks."""
        return Profiles(*(getattr(self, name)[index] for name in self.__slots__))


def sample_across(
    picture: Picture, place_px: FloatArray, normal: FloatArray, reach: int
) -> Float32Array:
    """Return the mean brightness across a stripe, shape (G, 2 * reach + 1), one sample a pixel.

    Parameters
    ----------
    picture
        Shape (H, W).
    place_px
        Shape (G, S, 2), G groups of places side by side along the stripe; G < 32767.
    normal
        Shape (G, 2).
    reach
        Farthest sample, px.
    """
    offset = np.arange(-reach, reach + 1)
    across_u, across_v = (offset * normal[:, axis, None] for axis in (0, 1))
    total = np.zeros(across_u.shape, dtype=np.float32)
    for member in np.moveaxis(place_px, 1, 0):
        total += sampled(picture, member[:, :1] + across_u, member[:, 1:] + across_v)
    return total / np.float32(place_px.shape[1])


def stands_out(samples: Float32Array, height: float) -> BoolArray:
    """Return which rows of samples, shape (N, K), are darker on both sides than in the middle.

    The rim of a clipped reflection bends down as a stripe does, but on one side only.
    """
    reach = samples.shape[1] // 2
    middle = samples[:, reach - 1 : reach + 2].mean(axis=1)
    darkest = np.maximum(samples[:, :reach].min(axis=1), samples[:, reach + 1 :].min(axis=1))
    return np.asarray(middle - darkest >= height)


def fit_profiles(samples: Float32Array) -> Profiles:
    """Fit a Gaussian on a sloping ground to each row of samples.

    Parameters
    ----------
    samples
        Shape (N, K), counts, K odd; the middle is near the stripe's centre.

    Returns
    -------
    Profiles
        A fit that did not find a bright stripe has height 0.

    Notes
    -----
    Damped Gauss-Newton steps on all rows at once. Where a sample touches the sensor's limit the
    model is clipped as the sensor clips: the flanks alone then tell the height.
    """
    reach = samples.shape[1] // 2
    c = np.arange(-reach, reach + 1, dtype=np.float32)
    parameters = _first_guess(samples)
    weight = _window(c, parameters[:, 2])
    used = np.flatnonzero(weight.any(axis=0))
    c, samples, weight = c[used], samples[:, used], weight[:, used]
    clipped = samples >= SATURATED_FROM
    any_clipped = np.asarray(clipped.any(axis=1))
    jacobian = np.empty((len(samples), 6, c.size), dtype=np.float32)
    moving = np.arange(len(samples))
    for step in range(1, _STEPS_IF_CLIPPED + 1):
        of_moving = samples[moving], weight[moving], clipped[moving]
        before = parameters[moving]
        parameters[moving] = _stepped(before, *of_moving, c, jacobian[: len(moving)])
        moves = _still_moves(before, parameters[moving]) & (step < _MOST_STEPS)
        moving = moving[moves | any_clipped[moving]]
        if moving.size == 0:
            break
    model = _model(parameters, c, jacobian)
    left = (samples - np.where(clipped, np.minimum(model, samples), model)) * weight
    misfit = np.sqrt((left**2).sum(axis=1) / weight.sum(axis=1))
    height, centre, raw_width, ground, slope = parameters.T.astype(np.float64)
    width = np.sqrt(np.maximum(raw_width**2 - _RESAMPLING_VARIANCE, _NARROWEST_PX**2))
    # Resampling keeps the area of the profile.
    height *= raw_width / width
    middle = np.abs(c) <= 1.0 + np.minimum(width, 3.0)[:, None]
    saturated = (clipped & middle).any(axis=1)
    return Profiles(height, centre, width, ground, slope, misfit.astype(np.float64), saturated)


def _still_moves(before: Float32Array, now: Float32Array) -> BoolArray:
    """Return which rows the last step still changed in centre or width."""
    return np.asarray(np.abs(now - before)[:, 1:3].max(axis=1) > _SETTLED_PX)


def _window(c: Float32Array, width_px: Float32Array) -> Float32Array:
    """Look no farther than the stripe's foot, so that neighbours do not pull."""
    inside = np.abs(c) <= np.asarray(_reach_px(width_px))[:, None]
    return np.asarray(inside, dtype=np.float32)


def _reach_px(width_px: FloatArray | Float32Array) -> FloatArray | Float32Array:
    return np.maximum(4.0 * width_px + 2.0, 6.0)


def _first_guess(samples: Float32Array) -> Float32Array:
    """Width from where the samples fall to half the height, ground from the feet."""
    reach = samples.shape[1] // 2
    row = np.arange(len(samples))
    middle = samples[:, reach - 1 : reach + 2]
    peak, low = middle.max(axis=1), samples.min(axis=1)
    left, right = _run(samples, low + 0.5 * (peak - low))
    width = np.clip((left + right) / 2.355, 1.0, 0.4 * reach)
    centre = np.clip(0.5 * (right - left), -0.3 * reach, 0.3 * reach)
    foot = np.minimum(np.rint(3.0 * width + 1.0), reach).astype(np.intp)
    start, end = samples[row, reach - foot], samples[row, reach + foot]
    slope = (end - start) / (2.0 * foot)
    ground = 0.5 * (start + end)
    height = np.maximum(peak - ground, 1.0)
    guess = np.column_stack([height, centre, width, ground, slope])
    clipped = np.flatnonzero(middle.mean(axis=1) >= SATURATED_FROM)
    if clipped.size > 0:
        guess[clipped] = _first_guess_clipped(samples[clipped], guess[clipped])
    return guess.astype(np.float32)


def _run(samples: Float32Array, level: Float32Array) -> tuple[FloatArray, FloatArray]:
    """Return how far to the left and right of the middle samples stay above a level, px."""
    reach = samples.shape[1] // 2
    return _falls_to(samples[:, reach::-1], level), _falls_to(samples[:, reach:], level)


def _falls_to(samples: Float32Array, level: Float32Array) -> FloatArray:
    """Return where rows of samples first fall to a level, between the samples; the end if none."""
    below = samples <= level[:, None]
    below[:, -1] = True
    first = np.maximum(below.argmax(axis=1), 1)
    row = np.arange(len(samples))
    before, after = samples[row, first - 1], samples[row, first]
    share = (before - level) / np.maximum(before - after, 1e-3)
    return np.asarray(first - 1 + np.clip(share, 0.0, 1.0))


def _first_guess_clipped(samples: Float32Array, guess: FloatArray) -> FloatArray:
    """Width and height of a clipped bell from its half-widths at two levels below the limit.

    A bell is x wide where it is exp(-x² / 2w²) of its height.
    """
    ground = samples.min(axis=1)
    low, high = (ground + share * (255.0 - ground) for share in (0.2, 0.85))
    outer, inner = (0.5 * np.add(*_run(samples, level)) for level in (low, high))
    square = (outer**2 - inner**2) / (2.0 * np.log(0.85 / 0.2))
    width = np.sqrt(np.clip(square, 1.0, (0.4 * samples.shape[1]) ** 2))
    height = 0.85 * (255.0 - ground) * np.exp(np.minimum(0.5 * (inner / width) ** 2, 3.0))
    zero = np.zeros(len(samples))
    return np.column_stack([height, guess[:, 1], width, ground, zero])


def _stepped(
    parameters: Float32Array,
    samples: Float32Array,
    weight: Float32Array,
    clipped: BoolArray,
    c: Float32Array,
    jacobian: Float32Array,
) -> Float32Array:
    """Take one damped Gauss-Newton step; `jacobian`, shape (N, 6, K), is overwritten."""
    model = _model(parameters, c, jacobian)
    # A clipped sample says only "at least this": no pull once the model is above it.
    pull = weight * ~(clipped & (model >= samples))
    jacobian[:, 5] = samples - model
    pulling = jacobian * pull[:, None, :]
    product = (pulling @ jacobian.transpose(0, 2, 1)).astype(np.float64)
    normal, gradient = product[:, :5, :5], product[:, :5, 5:]
    np.einsum("nii->ni", normal)[...] *= 1.0 + _DAMPING
    np.einsum("nii->ni", normal)[...] += 1e-6
    step = np.linalg.solve(normal, gradient)[:, :, 0]
    return _bounded(parameters + step.astype(np.float32), parameters)


def _model(parameters: Float32Array, c: Float32Array, jacobian: Float32Array) -> Float32Array:
    """Return the model, shape (N, K); put its derivatives into the first rows of `jacobian`."""
    height, centre, width, ground, slope = (p[:, None] for p in parameters.T)
    x = (c - centre) / width
    bell = np.exp(-0.5 * x * x)
    by_centre = height * bell * x / width
    jacobian[:, 0] = bell
    jacobian[:, 1] = by_centre
    jacobian[:, 2] = by_centre * x
    jacobian[:, 3] = 1.0
    jacobian[:, 4] = c
    return np.asarray(height * bell + ground + slope * c)


def _bounded(now: Float32Array, before: Float32Array) -> Float32Array:
    """Keep a step inside what a stripe can be."""
    height, centre, width = now.T[:3]
    largest = np.minimum(np.maximum(2.0 * before[:, 0], 50.0), _HIGHEST)
    np.minimum(np.maximum(height, 0.0), largest, out=height)
    np.minimum(np.maximum(centre, -_FARTHEST_OFF_PX), _FARTHEST_OFF_PX, out=centre)
    narrowest = np.maximum(0.6 * before[:, 2], _NARROWEST_PX)
    widest = np.minimum(1.6 * before[:, 2], _WIDEST_PX)
    np.minimum(np.maximum(width, narrowest), widest, out=width)
    return now
