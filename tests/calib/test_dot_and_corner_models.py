"""The pictures of a disc and of a corner: their derivatives, and what least squares makes of them.

The models are fitted to themselves here; pictures that were made in another way are in
test_observe_target.
"""

import numpy as np
import pytest

from calib import PixelNoise
from calib.seeing import disc, saddle
from calib.seeing.ellipse import Ellipses, fit_ellipses
from calib.seeing.patch_fit import Patches, fit_patches

SIDE = np.arange(-16, 17)
OFFSET = np.stack(np.meshgrid(SIDE, SIDE), axis=-1).reshape(-1, 2)

DISC = np.array([[0.3, -0.4, 1 / 90.0, 0.002, 1 / 60.0, 1.1, 20.0, 0.3, -0.2, 120.0, 0.5, 0.4]])
CORNER = np.array([[0.3, -0.4, 0.2, 1.9, 1.0, 80.0, 0.4, -0.3, 50.0]])
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
    bright[0, disc.HEIGHT :] = 700.0, 12.0, 9.0  # brighter on one side: the clipped edge moves
    patches = noisy_patches(disc, bright, rng, 100, 2.0)
    start = np.repeat(DISC, 100, axis=0)
    fit = fit_patches(patches, start, disc.evaluate, disc.sound)
    error = (fit.parameters - bright)[:, :2]
    assert np.abs(error.mean(axis=0)).max() < 0.02
    assert np.abs(error).max() < 0.15


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


def test_windows_over_the_border_use_what_is_inside():
    picture = np.full((40, 50), 9, dtype=np.uint8)
    use = np.ones((1, len(OFFSET)), dtype=bool)
    patches = Patches.cut(picture, picture, PixelNoise(1.0), np.array([[0, 0]]), OFFSET, use)
    assert (patches.weight > 0.0).sum() == 17 * 17
