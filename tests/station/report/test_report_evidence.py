"""Points come back from points.csv as they went in; the residuals drawn are right."""

import numpy as np
import pytest
from report_samples import by_hand

from station.report.evidence import evidence_of, whitened_dots, whitened_stripe

HEAD = "image,kind,row,col,u,v,sigma_u,sigma_v,u_corrected,v_corrected,used,reason\n"


def test_pictures_keep_their_points_and_figures(kept):
    _, points = by_hand(kept, [0.1, 0.4])
    first, second = evidence_of(points)
    assert (first.name, len(first.dots), len(first.stripe)) == ("pose0.png", 56, 40)
    assert first.dots.rms_px == pytest.approx(0.1)
    assert second.stripe.rms_px == pytest.approx(0.4)


def test_figures_of_all_pictures_are_those_of_the_document(kept):
    pictures = evidence_of(kept.points_csv)
    for kind, whole_px in (
        ("dots", kept.document.rms.dots_px),
        ("stripe", kept.document.rms.stripe_px),
    ):
        sets = [getattr(picture, kind) for picture in pictures]
        deviations = np.vstack([points.deviation_px[points.used] for points in sets])
        # points.csv has six decimals.
        assert np.sqrt((deviations**2).sum(axis=1).mean()) == pytest.approx(whole_px, abs=2e-6)


def test_dot_after_a_stripe_begins_another_picture_of_the_same_name():
    dot, stripe = "a.png,dot,0,0,1,1,1,1,1,1,1,\n", "a.png,stripe,,,1,1,1,1,1,1,1,\n"
    assert len(evidence_of(HEAD + dot + stripe + dot + stripe)) == 2


def test_picture_that_was_left_out_has_no_corrected_points():
    (picture,) = evidence_of(HEAD + "a.png,dot,0,0,1,2,1,1,,,0,does not fit\n")
    assert not picture.solved
    assert np.isnan(picture.dots.corrected_px).all()
    assert picture.dots.unused_by_reason == {"does not fit": 1}


def test_points_not_used_do_not_enter_the_residuals():
    used, unused = "a.png,dot,0,0,3,1,2,1,1,1,1,\n", "a.png,dot,0,1,90,1,1,1,1,1,0,glare\n"
    pictures = evidence_of(HEAD + used + unused)
    np.testing.assert_allclose(whitened_dots(pictures), [1.0, 0.0])


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_stripe_residual_is_its_deviation_along_the_normal_with_its_side(side):
    """A stripe with normal (0.6, 0.8) and sigma 0.5, moved by 2 along its normal."""
    u, v = 10.0 + side * 1.2, 10.0 + side * 1.6
    pictures = evidence_of(HEAD + f"a.png,stripe,,,{u},{v},0.3,0.4,10,10,1,\n")
    np.testing.assert_allclose(whitened_stripe(pictures), [side * 4.0])


def test_nothing_seen_gives_no_residual():
    assert evidence_of(HEAD) == ()
    assert not whitened_dots(()).size
    assert not whitened_stripe(()).size
