"""The pictures of a disc and of a corner: their derivatives, and what least squares makes of them.

The models are fitted to themselves here; pictures that were made in another way are in
test_observe_target.
"""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from calib import PixelNoise
from calib.seeing import disc, saddle
from calib.seeing.coherence import in_squares
from calib.seeing.dots_alike import alike, even_dots
from calib.seeing.ellipse import Ellipses, fit_ellipses
from calib.seeing.patch_fit import Prior, fit_patches
from calib.seeing.patches import Patches

SIDE = np.arange(-16, 17)
OFFSET = in_squares(np.stack(np.meshgrid(SIDE, SIDE), axis=-1).reshape(-1, 2))

DISC = np.array([
    [0.3, -0.4, 1 / 90.0, 0.002, 1 / 60.0, 1.1, 20.0, 0.3, -0.2, 120.0, 0.5, 0.4, -0.03]
])
CORNER = np.array([[0.3, -0.4, 0.2, 1.9, 1.0, 80.0, 0.4, -0.3, 50.0, 0.4]])
MODELS = [(disc, DISC), (saddle, CORNER)]


@pytest.mark.parametrize(("model", "parameters"), MODELS, ids=["disc", "corner"])
def test_derivatives_are_those_of_central_differences(model, parameters):
    _, jacobian = model.evaluate(parameters, OFFSET.astype(float))
    edge = np.ones(len(OFFSET), dtype=bool)
    if model is disc:
        # Those by centre and form are first order in the distance from the outline.
        edge = np.abs(disc.inward_px(parameters, OFFSET.astype(float))[0]) < 1.0
    for i in range(parameters.shape[1]):
        step = np.zeros_like(parameters)
        step[0, i] = 1e-6 * max(1.0, abs(parameters[0, i])) if i not in {2, 3, 4} else 1e-8
        above, below = (
            model.evaluate(parameters + s, OFFSET.astype(float))[0] for s in (step, -step)
        )
        numeric = (above - below)[0] / (2.0 * step[0, i])
        scale = np.abs(numeric).max()
        np.testing.assert_allclose(jacobian[0, i, edge], numeric[edge], atol=0.12 * scale)
        if model is saddle or i >= disc.BLUR:
            np.testing.assert_allclose(jacobian[0, i], numeric, atol=1e-5 * scale)


def noisy_patches(model, parameters, rng, count, sigma, *, limit=255.0):
    light = np.minimum(model.evaluate(parameters, OFFSET.astype(float))[0], limit)
    samples = np.rint(light + sigma * rng.normal(size=(count, len(OFFSET))))
    samples = np.clip(samples, 0, 255).astype(np.float32)
    return Patches(
        origin=np.zeros((count, 2), dtype=np.int64),
        offset=OFFSET,
        samples=samples,
        weight=np.full(samples.shape, 1.0 / (sigma**2 + 1.0 / 12.0), dtype=np.float32),
        clipped=samples >= 250,
    )


@pytest.mark.parametrize(("model", "parameters"), MODELS, ids=["disc", "corner"])
def test_a_fit_finds_the_centre_and_knows_its_scatter(rng, model, parameters):
    patches = noisy_patches(model, parameters, rng, 400, 3.0)
    off = np.zeros_like(parameters)
    off[0, :2] = 0.6, -0.5
    start = np.repeat(parameters + off, 400, axis=0)
    fit = fit_patches(patches, start, model.evaluate, model.sound)
    error = (fit.parameters - parameters)[:, :2]
    assert fit.converged.mean() > 0.99
    # 400 draws in two coordinates pin a standard deviation to 2.5 %, a mean to 0.05 sigma.
    assert (error / fit.sigma_px).std() == pytest.approx(1.0, abs=0.1)
    assert np.abs(error.mean(axis=0)).max() < 0.2 * fit.sigma_px.mean()


def test_a_clipped_disc_has_its_centre_where_it_was(rng):
    bright = DISC.copy()
    bright[0, disc.HEIGHT :] = 700.0, 12.0, 9.0, 0.0  # brighter on one side: the clipped edge moves
    patches = noisy_patches(disc, bright, rng, 100, 2.0)
    start = np.repeat(DISC, 100, axis=0)
    flat = even_dots(start, np.full(100, 8.5), np.ones(100, dtype=bool))
    flat.precision[:, disc.HEIGHT_U : disc.DOME] = 0.0
    fit = fit_patches(patches, start, disc.evaluate, disc.sound, flat)
    error = (fit.parameters - bright)[:, :2]
    assert np.abs(error.mean(axis=0)).max() < 0.02
    # 4 for 200 normal deviates, half as much again for sigma's own error.
    assert np.abs(error / fit.sigma_px).max() < 6.0


def test_of_a_clipped_dot_evenness_tells_the_centre_better(rng):
    bright = DISC.copy()
    bright[0, disc.HEIGHT :] = 600.0, 0.0, 0.0, 0.0
    patches = noisy_patches(disc, bright, rng, 100, 2.0)
    start = np.repeat(DISC, 100, axis=0)
    even = even_dots(start, np.full(100, 8.5), np.ones(100, dtype=bool))
    free, held = (
        fit_patches(patches, start, disc.evaluate, disc.sound, prior) for prior in (None, even)
    )
    scatter = [(fit.parameters - bright)[:, :2].std() for fit in (free, held)]
    assert scatter[1] < 0.8 * scatter[0]
    assert held.sigma_px.mean() < free.sigma_px.mean()


def test_pixels_that_are_not_used_do_not_pull(rng):
    patches = noisy_patches(disc, DISC, rng, 50, 2.0)
    hidden = np.abs(patches.places_px()[:, :, 1] - 3.0) < 4.0
    patches.samples[hidden] = 255.0
    fit = fit_patches(
        patches.without(hidden), np.repeat(DISC, 50, axis=0), disc.evaluate, disc.sound
    )
    error = (fit.parameters - DISC)[:, :2]
    assert (error / fit.sigma_px).std() == pytest.approx(1.0, abs=0.3)


def test_a_foreign_edge_pulls_little(rng):
    patches = noisy_patches(disc, DISC, rng, 50, 2.0)
    corner = (patches.places_px() > 8.0).all(axis=2)
    patches.samples[corner] += 60.0
    fit = fit_patches(patches, np.repeat(DISC, 50, axis=0), disc.evaluate, disc.sound)
    assert np.abs((fit.parameters - DISC)[:, :2]).max() < 0.06


def test_an_ellipse_is_fitted_exactly_to_points_on_it(rng):
    angle = np.linspace(0.0, 6.0, 20)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    shape = np.array([[9.0, 2.0], [1.0, 6.0]])
    points = circle @ shape.T + [1.5, -0.7]
    fit = fit_ellipses(points[None], np.ones((1, 20)))
    np.testing.assert_allclose(fit.centre_px[0], [1.5, -0.7], atol=1e-4)
    np.testing.assert_allclose(fit.level(points[None] - fit.centre_px[:, None]), 1.0, atol=1e-4)
    expected = np.linalg.svd(shape, compute_uv=False)[::-1]
    np.testing.assert_allclose(fit.axes_px[0], expected, rtol=1e-4)


def test_what_is_no_ellipse_has_no_axes():
    saddle_form = Ellipses(np.zeros((1, 2)), np.array([[1.0, 0.0, -1.0]]))
    assert np.isnan(saddle_form.axes_px).any()


def test_noise_that_hangs_together_makes_sigma_larger(rng):
    patches = noisy_patches(disc, DISC, rng, 300, 1e-3)
    white = rng.normal(size=(300, 33, 33))
    grain = np.array([cv2.GaussianBlur(each, (0, 0), 1.2) for each in white])
    grain = grain[:, OFFSET[:, 1] + 16, OFFSET[:, 0] + 16]
    samples = patches.samples + 5.0 * grain / grain.std()
    patches = replace(
        patches, samples=samples.astype(np.float32), weight=np.full_like(samples, 0.04)
    )
    fit = fit_patches(patches, np.repeat(DISC, 300, axis=0), disc.evaluate, disc.sound)
    error = (fit.parameters - DISC)[:, :2]
    # A covariance of independent pixels is more than twice too small (the second line); squares
    # of 6 px miss what hangs together across their borders: measured 1.34, 600 draws tell 3 %.
    assert (error / fit.sigma_px).std() == pytest.approx(1.2, abs=0.3)
    assert np.median(fit.coherence) > 4.0


def test_coherence_is_one_in_white_noise(rng):
    for model, parameters in MODELS:
        patches = noisy_patches(model, parameters, rng, 200, 3.0)
        start = np.repeat(parameters, 200, axis=0)
        fit = fit_patches(patches, start, model.evaluate, model.sound)
        # A window's coherence is a mean of some 40 squares of normal deviates: 200 pin the mean
        # to 0.02; robust weights take off up to 3 % of the variance.
        assert fit.coherence.mean() == pytest.approx(1.0, abs=0.08)


def test_what_is_known_besides_holds_a_parameter_and_takes_part_in_sigma(rng):
    patches = noisy_patches(disc, DISC, rng, 200, 3.0)
    start = np.repeat(DISC, 200, axis=0)
    known = Prior.nothing(start.shape)
    known.precision[:, disc.U, disc.U] = 1.0 / 0.005**2
    known.mean[:, disc.U] = DISC[0, disc.U] + 0.005 * rng.normal(size=200)
    fit = fit_patches(patches, start, disc.evaluate, disc.sound, known)
    error = (fit.parameters - DISC)[:, :2]
    assert fit.sigma_px[:, 0].mean() < 0.005
    # 200 draws pin a standard deviation to 5 %.
    assert (error / fit.sigma_px).std(axis=0) == pytest.approx([1.0, 1.0], abs=0.17)


def test_the_other_dots_tell_the_form_of_one_that_went_astray(rng):
    place = np.stack(np.meshgrid(np.arange(8.0), np.arange(7.0)), axis=-1).reshape(-1, 2) * 60.0
    true = np.repeat(DISC, 56, axis=0)
    true[:, disc.Q11] *= 1.0 + 0.001 * place[:, 0]  # smaller to the right
    measured = true.copy()
    measured[:, disc.Q11 : disc.Q22 + 1] *= 1.0 + 0.003 * rng.normal(size=(56, 3))
    measured[20, disc.Q11 : disc.Q22 + 1] = 1 / 200.0, 0.003, 1 / 40.0
    everyone, nobody = np.ones(56, dtype=bool), np.zeros(56, dtype=bool)
    prior = alike(measured, place, np.full(56, 8.5), everyone, nobody)
    # Six terms through 55 dots, each good to 0.3 % of an entry.
    assert prior.mean[20, [disc.Q11, disc.Q22]] == pytest.approx(
        true[20, [disc.Q11, disc.Q22]], rel=0.006
    )


def test_dots_swollen_by_clipping_still_tell_how_flat_they_are(rng):
    place = np.stack(np.meshgrid(np.arange(8.0), np.arange(7.0)), axis=-1).reshape(-1, 2) * 60.0
    swollen = np.repeat(DISC, 56, axis=0)
    swollen[:, [disc.Q11, disc.Q22]] += 0.001 * rng.normal(size=(56, 1))
    everyone, nobody = np.ones(56, dtype=bool), np.zeros(56, dtype=bool)
    prior = alike(swollen, place, np.full(56, 8.5), everyone, nobody)
    form = prior.precision[0, disc.Q11 : disc.Q22 + 1, disc.Q11 : disc.Q22 + 1]
    size, flatness = np.array([1.0, 0.0, 1.0]), np.array([1.0, 0.0, -1.0])
    assert flatness @ form @ flatness > 100.0 * size @ form @ size


def test_few_dots_tell_nothing_of_each_other():
    start = np.repeat(DISC, 6, axis=0)
    yes, no = np.ones(6, dtype=bool), np.zeros(6, dtype=bool)
    prior = alike(start, np.zeros((6, 2)), np.full(6, 8.5), yes, no)
    assert (prior.precision[:, disc.Q11, disc.Q11] == 0.0).all()


@pytest.mark.parametrize("shrink", [0.5, -0.5])
def test_ink_that_spreads_moves_no_corner(rng, shrink):
    inked = CORNER.copy()
    inked[0, saddle.SHRINK] = shrink
    patches = noisy_patches(saddle, inked, rng, 100, 2.0)
    fit = fit_patches(patches, np.repeat(CORNER, 100, axis=0), saddle.evaluate, saddle.sound)
    error = (fit.parameters - inked)[:, :2]
    assert np.abs(error.mean(axis=0)).max() < 0.3 * fit.sigma_px.mean()
    assert np.median(fit.parameters[:, saddle.SHRINK]) == pytest.approx(shrink, abs=0.05)


def test_windows_over_the_border_use_what_is_inside():
    picture = np.full((40, 50), 9, dtype=np.uint8)
    use = np.ones((1, len(OFFSET)), dtype=bool)
    patches = Patches.cut(picture, picture, PixelNoise(1.0), np.array([[0, 0]]), OFFSET, use)
    assert (patches.weight > 0.0).sum() == 17 * 17
