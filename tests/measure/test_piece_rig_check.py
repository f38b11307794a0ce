"""Does a piece that two sensors see at once tell a true rig from a drifted one?

Stripes are plain geometry with noise; blur, bleeding edges and the laser's shadows are not in them.
"""

import numpy as np
import pytest
from piece_rig_stripes import drawn_rig, drifted, held, rib, rig_of_two, shot_of
from piece_stripes import comb, stripe_on

from calib import Rig, RigidTransform
from measure import PieceVerdict, judge_piece, judge_piece_on_rig

# The direction of `held` where sheets are turned by 15 degrees, and it by half of that.
KEPT = (np.cos(np.radians(7.5)), 0.0, -np.sin(np.radians(7.5)))


def well_known(scale=0.2, **about):
    """The rig of two with smaller sigmas."""
    rig = rig_of_two(**about)
    return Rig(rig.sensors, scale**2 * rig.covariance)


def judged(rig, truth, rng, *, piece=None, noise_px=0.03, slant_rad=(0.0, 0.0), **about):
    piece = piece or rib()
    shot = shot_of(truth, held(piece, slant_rad=slant_rad), piece, rng, noise_px=noise_px)
    return judge_piece_on_rig([("a", shot)], rig, piece, temperature_c=20.0, **about)


def by_name(judgement):
    return {one.name: one for one in judgement.deviations}


def test_a_true_rig_tells_the_truth_of_a_thickness_that_no_sensor_sees_alone(rng):
    rig = rig_of_two()
    answer = judged(rig, rig, rng)
    assert answer.verdict is PieceVerdict.TRUE, answer.reason
    # The left wall faces the inner sensor alone, the right one the outer.
    assert by_name(answer)["width 2-6"].certified_mm == pytest.approx(26.0)
    assert [(one.sensor, one.reason) for one in answer.readings] == [("inner", ""), ("outer", "")]


def test_dimensions_without_noise_are_those_of_the_piece(rng):
    rig = rig_of_two(doubted=False)
    answer = judged(rig, rig, rng, noise_px=1e-4)
    for one in answer.deviations:
        # 1e-4 px is 2e-5 mm on a side, ten times that where a short side's angle is told.
        assert abs(one.off_mm) < 2e-4, one


def test_a_slanted_piece_in_sheets_that_stand_apart_is_read_true(rng):
    rig = rig_of_two(turned_rad=0.1, apart_mm=30.0, doubted=False)
    answer = judged(rig, rig, rng, noise_px=1e-4, slant_rad=(0.003, -0.004))
    for one in answer.deviations:
        if not one.name.startswith("shift"):
            assert abs(one.off_mm) < 5e-4, one
        # By a slant that is told to some of its 1e-3 rad at 30 mm.
        assert abs(one.off_mm) <= one.u95_mm


@pytest.mark.parametrize("shift_mm", [(0.0, 0.1, 0.0), (0.0, 0.0, -0.1)])
def test_a_sensor_moved_by_a_tenth_in_the_section_is_drift(rng, shift_mm):
    rig = well_known()
    answer = judged(rig, drifted(rig, "outer", shift_mm=shift_mm), rng)
    assert answer.verdict is PieceVerdict.DRIFTED
    name = "shift x outer" if shift_mm[1] else "shift z outer"
    # A sensor that has moved on by 0.1 takes the piece for 0.1 on the other side.
    assert by_name(answer)[name].off_mm == pytest.approx(-(shift_mm[1] + shift_mm[2]), abs=0.03)


def test_a_sensor_turned_by_a_third_of_a_milliradian_is_drift(rng):
    rig = well_known()
    # On its foot, half a metre from the piece, it aims 0.15 mm beside.
    foot = rig["outer"].rig_from_camera.translation_mm
    turned = drifted(rig, "outer", about_mm=foot, turn_rad=(3e-4, 0.0, 0.0))
    assert judged(rig, turned, rng).verdict is PieceVerdict.DRIFTED


def test_a_twist_about_the_piece_is_told_from_a_shift(rng):
    rig = well_known()
    about = held(rib()).translation_mm
    twisted = drifted(rig, "outer", about_mm=about, turn_rad=(2e-3, 0.0, 0.0))
    answer = judged(rig, twisted, rng)
    twist = by_name(answer)["twist outer"]
    assert twist.verdict is PieceVerdict.DRIFTED
    # 2 mrad at half the piece's 85 mm.
    assert abs(twist.off_mm) == pytest.approx(0.085, abs=0.02)


def test_drifts_are_found_from_the_size_that_is_stated_and_not_far_below(rng):
    rig = well_known()
    answer = judged(rig, rig, rng)
    power = {one.name: one for one in answer.powers}["shift x outer"]
    assert power.unit == "mm"
    for size, found in ((1.5, True), (0.3, False)):
        moved = drifted(rig, "outer", shift_mm=(0.0, size * power.found_from, 0.0))
        assert (judged(rig, moved, rng).verdict is PieceVerdict.DRIFTED) is found


def test_a_shift_along_the_piece_is_not_seen_and_that_is_said(rng):
    rig = well_known()
    answer = judged(rig, drifted(rig, "outer", shift_mm=(2.0, 0.0, 0.0)), rng)
    assert answer.verdict is PieceVerdict.TRUE
    assert any("along its length" in note for note in answer.notes)


def test_a_thickness_of_another_size_is_drift(rng):
    rig = well_known()
    made = rib()
    corners = made.corners_mm.copy()
    corners[5:, 0] += 0.15
    thicker = type(made).from_corners("rib", "9", [[tuple(corner)] for corner in corners])
    shot = shot_of(rig, held(thicker), thicker, rng, noise_px=0.03)
    answer = judge_piece_on_rig([("a", shot)], rig, made)
    assert answer.verdict is PieceVerdict.DRIFTED
    assert by_name(answer)["width 2-6"].off_mm == pytest.approx(0.15, abs=0.03)


def test_sheets_far_apart_leave_shifts_open_where_the_piece_may_slant(rng):
    rig = well_known(apart_mm=60.0)
    answer = judged(rig, rig, rng)
    assert answer.verdict is PieceVerdict.UNKNOWN
    assert "shift" in answer.reason
    # Half a degree of slant at 60 mm is half a millimetre.
    assert by_name(answer)["shift x outer"].u95_mm > 0.2
    steady = judged(rig, rig, rng, piece=rib(squareness_deg=0.05))
    assert steady.verdict is PieceVerdict.TRUE, steady.reason


def test_a_holder_that_keeps_the_length_makes_sheets_far_apart_tell(rng):
    turned = np.radians(15.0)
    rig = well_known(turned_rad=turned, apart_mm=110.0)
    about = {"sheet_turn_rad": 0.5 * turned, "slant_rad": (2e-4, -2e-4)}
    answers = [
        judge_piece_on_rig([("a", shot_of(rig, held(piece, **about), piece, rng))], rig, piece)
        for piece in (rib(squareness_deg=0.03), rib(squareness_deg=0.03, length_in_rig=KEPT))
    ]
    # Sheets turned against each other do not say to which of them a piece is square.
    assert [one.verdict for one in answers] == [PieceVerdict.UNKNOWN, PieceVerdict.TRUE]
    loose, kept = (by_name(one)["shift x outer"] for one in answers)
    assert kept.u95_mm < 0.2 * loose.u95_mm


def test_one_blind_sensor_is_no_evidence_of_a_rig(rng):
    rig = rig_of_two()
    shot = shot_of(rig, held(rib()), rib(), rng, only=("inner",))
    nothing = shot["inner"].select(np.zeros(0, dtype=np.int64))
    answer = judge_piece_on_rig([("a", {**shot, "outer": nothing})], rig, rib())
    assert answer.verdict is PieceVerdict.UNKNOWN
    assert "outer" in answer.reason
    assert "no stripe" in answer.reason
    assert judge_piece_on_rig([("a", shot)], rig, rib()).verdict is PieceVerdict.UNKNOWN
    assert judge_piece_on_rig([], rig, rib()).verdict is PieceVerdict.UNKNOWN


def test_a_sensor_that_the_rig_has_not_is_refused(rng):
    rig = rig_of_two()
    shot = shot_of(rig, held(rib()), rib(), rng)
    with pytest.raises(ValueError, match="no sensor other"):
        judge_piece_on_rig([("a", {"other": shot["inner"]})], rig, rib())


def test_more_placings_are_known_better_and_the_same_placing_is_not(rng):
    rig, piece = well_known(0.05), rib()
    places = [held(piece, at_mm=at) for at in ((0.0, 0.0), (6.0, 2.0), (-6.0, 3.0), (2.0, -5.0))]
    moved = [(str(k), shot_of(rig, place, piece, rng)) for k, place in enumerate(places)]
    still = [(str(k), shot_of(rig, places[0], piece, rng)) for k in range(4)]
    alone, four, same = (
        by_name(judge_piece_on_rig(shots, rig, piece))["twist outer"].u95_mm
        for shots in (moved[:1], moved, still)
    )
    # Four placings halve the noise, which each picture tells to a fifth only.
    assert four < 0.75 * alone
    assert same > 0.8 * alone


def test_a_rig_of_one_sensor_judges_as_the_sensor_alone(rng):
    sensor = rig_of_two().sensors[0].sensor
    stripe = stripe_on(comb(), rng)
    pose = RigidTransform.from_rotation_vector([0.1, 0.2, 0.3], [10.0, 20.0, 30.0])
    rig = Rig.of_one(sensor, pose, "only")
    alone = judge_piece([("a", stripe)], sensor, comb())
    on_rig = judge_piece_on_rig([("a", {"only": stripe})], rig, comb())
    assert on_rig.verdict is alone.verdict
    assert by_name(on_rig).keys() == by_name(alone).keys()
    for name, one in by_name(alone).items():
        # They settle on the same points to within a few at the ends of sides.
        assert by_name(on_rig)[name].off_mm == pytest.approx(one.off_mm, abs=0.2 * one.u95_mm)
        assert by_name(on_rig)[name].u95_mm == pytest.approx(one.u95_mm, rel=0.1)


def test_u95_covers_about_nineteen_of_twenty():
    # 10 draws of a score of dimensions that go together, about four of them free: the share
    # scatters by 3.5 %.
    within, _ = _over_drawn_rigs(runs=10)
    assert 0.85 <= within <= 1.0


@pytest.mark.slow
def test_u95_covers_nineteen_of_twenty_and_false_alarms_are_rare():
    within, drifts = _over_drawn_rigs(runs=300)
    assert 0.93 <= within <= 0.975
    # 1 % is meant; of 300, 8 or more come by chance in one case of a hundred.
    assert drifts <= 7


def _over_drawn_rigs(runs):
    """Return which share of deviations lies within u95, and how many rigs are called drifted."""
    rng = np.random.default_rng(4)
    within, drifts = [], 0
    piece = rib()
    for run in range(runs):
        rig = rig_of_two(apart_mm=(0.0, 20.0)[run % 2])
        pose = held(
            piece,
            at_mm=rng.uniform(-8.0, 8.0, 2),
            turn_rad=rng.uniform(-0.1, 0.1),
            slant_rad=rng.normal(size=2) * np.radians(piece.squareness_deg) / 1.96,
        )
        shot = shot_of(drawn_rig(rig, rng), pose, piece, rng)
        answer = judge_piece_on_rig([("a", shot)], rig, piece, temperature_c=20.0)
        within += [abs(one.off_mm) <= one.u95_mm for one in answer.deviations]
        drifts += answer.verdict is PieceVerdict.DRIFTED
    return np.mean(within), drifts


def test_stripes_and_rig_are_left_as_they_were(rng):
    rig = rig_of_two()
    shot = shot_of(rig, held(rib()), rib(), rng)
    before = shot["inner"].centre_px.copy()
    judge_piece_on_rig([("a", shot)], rig, rib())
    np.testing.assert_array_equal(shot["inner"].centre_px, before)
