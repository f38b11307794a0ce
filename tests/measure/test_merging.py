"""Two sensors' sections of one wheel made one: what both see puts them together, and no further."""

from dataclasses import replace

import numpy as np
import pytest
import rig_stripes as rs
import wheel_stripes as ws

from calib import Rig, moved_by
from measure import (
    Quantity,
    Shot,
    Status,
    WheelFrame,
    measure_wheel,
    measure_wheel_on_rig,
    reference_profile,
)
from measure.gauging.estimate import Estimate
from measure.gauging.uncertainty import Motions
from measure.laying.by_axle import lay_by_axle
from measure.laying.section import AxleMap, Section, SheetPoints
from measure.merging.align import displacement, learn
from measure.merging.causes import motion_by_rig
from measure.merging.overlap import Overlap
from measure.placing.template import template_of

S1002 = reference_profile("S1002")
THICKNESS = Quantity.FLANGE_THICKNESS_10
WORN = ws.Wheel(tread_wear_mm=2.0, flange_wear_mm=1.5, axle_x_mm=12.0, lateral_mm=1.0)
# Across an axle, by how much 0.3 mm of vibration may part two sensors.
PARTED = {"inner": (0.1, 0.2, -0.1), "outer": (-0.1, -0.2, 0.15)}


def measured(shots, *, rig=None, survey=rs.SURVEY, **options):
    return measure_wheel_on_rig(shots, rig or rs.rig(), survey, S1002, **options)


def error_mm(answer, wheel=WORN, quantity=THICKNESS):
    return answer.readings[quantity].value - wheel.truth()[quantity.value]


def test_thickness_comes_from_the_back_of_one_and_the_face_of_the_other(rng):
    answer = measured([rs.shot(WORN, rng)])
    # Noise of 0.05 px lets the strands be joined to 0.01 mm; one reading's own sigma is 0.02.
    assert abs(error_mm(answer)) < 0.05
    assert answer.readings[THICKNESS].status is Status.OK


def test_profile_says_which_sensor_gave_which_part(rng):
    profile = measured([rs.shot(WORN, rng)]).profile
    back, face = np.abs(profile.d_mm) < 0.5, (profile.d_mm > 32.0) & (profile.d_mm < 44.0)
    assert (profile.seen_by[back & (profile.h_mm < 10.0)] == 0b01).all()
    assert (profile.seen_by[face] == 0b10).all()
    tread = profile.d_mm > 60.0
    assert np.mean(profile.seen_by[tread] == 0b11) > 0.9


@pytest.mark.parametrize("name", ["inner", "outer"])
def test_one_sensor_dark_invents_no_thickness(rng, name):
    answer = measured([rs.shot(WORN, rng, names=(name,))])
    # The outer one sees no back: which place is the tape circle it takes from the flange's form.
    said = {"inner": Status.OK, "outer": Status.REFERENCE_ASSUMED}[name]
    assert answer.readings[Quantity.FLANGE_HEIGHT].status is said
    for quantity in (THICKNESS, Quantity.FLANGE_THICKNESS_12, Quantity.FLANGE_GRADIENT_QR):
        assert answer.readings[quantity].status is Status.MISSING
    (other,) = {"inner", "outer"} - {name}
    assert answer.quality.by_sensor[other].reason == "no frame"


def test_a_blind_sensor_is_named_and_the_other_speaks(rng):
    shot = rs.shot(WORN, rng)
    inner, outer = shot.frames
    blind = replace(shot, frames=(replace(inner, stripe=inner.stripe.select(np.arange(30))), outer))
    answer = measured([blind])
    assert "30 of 30 points hang together" in answer.quality.by_sensor["inner"].reason
    assert abs(error_mm(answer, quantity=Quantity.FLANGE_HEIGHT)) < 0.1
    assert answer.readings[THICKNESS].status is Status.MISSING


def test_vibration_between_the_sensors_is_taken_out(rng):
    still = [error_mm(measured([rs.shot(WORN, rng)])) for _ in range(8)]
    parted = [measured([rs.shot(WORN, rng, moved=PARTED)]) for _ in range(8)]
    added = np.sqrt(np.mean(np.square([error_mm(each) for each in parted])))
    # Asked is no more than 0.02 mm; 8 drawings tell an RMS to a quarter.
    assert added - np.sqrt(np.mean(np.square(still))) < 0.02
    aside, _ = parted[0].quality.by_sensor["outer"].aside_mm
    assert aside == pytest.approx(0.4, abs=0.08)


def test_no_more_is_taken_out_than_was_allowed_for(rng):
    stiff = replace(rs.SURVEY, sigma_vibration_mm=1e-4, sigma_vibration_rad=1e-7)
    answer = measured([rs.shot(WORN, rng, moved=PARTED)], survey=stiff)
    reasons = [share.reason for share in answer.quality.by_sensor.values() if share.reason]
    assert len(reasons) == 1
    assert "check the rig on its reference piece" in reasons[0]
    assert answer.readings[THICKNESS].status is Status.MISSING


def test_sections_of_two_wheels_are_not_joined(rng):
    moved = {"inner": (0.0, 9.0, 0.0)}
    answer = measured([rs.shot(WORN, rng, moved=moved)])
    assert answer.readings[THICKNESS].status is Status.MISSING
    assert any("check the rig" in (s.reason or "") for s in answer.quality.by_sensor.values())


def test_u95_of_thickness_is_what_calibration_vibration_and_noise_make_of_it(rng):
    covariance = rs.poses_covariance()
    survey = replace(rs.SURVEY, sigma_axle_direction_rad=1e-7, sigma_vibration_rad=1e-7)
    scores = []
    for _ in range(60):
        sigma = survey.sigma_vibration_mm / np.sqrt(2.0)
        moved = {name: rng.normal(0.0, sigma, 3) for name in rs.STANDS}
        rig = rs.drawn_rig(rng, covariance)
        answer = measured([rs.shot(WORN, rng, moved=moved)], rig=rig, survey=survey)
        scores.append(error_mm(answer) / (answer.readings[THICKNESS].u95 / 1.96))
    # The RMS of 60 normal scores is 1 within 0.18, two sigmas; the floor and the share of bends
    # that may be wrong, which these stripes do not draw, make it smaller.
    assert 0.5 < np.sqrt(np.mean(np.square(scores))) < 1.2


def with_false_piece(shot, name, offset_px):
    """The same with other light on a piece of one sensor's flange tip, over the laser's."""
    frames = []
    for frame in shot.frames:
        if frame.sensor == name:
            at_rest = AxleMap(rs.rig()[name].rig_from_camera, WORN.axle_x_mm, ws.RADIUS_MM)
            sensor = rs.rig()[name].sensor
            y = at_rest.section(sensor.locate(frame.stripe.centre_px))[:, 0] - WORN.lateral_mm
            false, hidden = np.abs(y + 56.0) < 4.0, np.abs(y + 56.0) < 6.5
            moved = frame.stripe.centre_px + offset_px * frame.stripe.normal
            centre = np.where(false[:, None], moved, frame.stripe.centre_px)
            stripe = replace(frame.stripe, centre_px=centre).select(false | ~hidden)
            frame = replace(frame, stripe=stripe)
        frames.append(frame)
    return Shot(tuple(frames))


@pytest.mark.parametrize("offset_px", [-2.0, 2.0])
def test_a_false_piece_on_one_sensor_s_tip_is_left_out(rng, offset_px):
    shot = with_false_piece(rs.shot(WORN, rng), "outer", offset_px)
    true, false = measured([rs.shot(WORN, rng)]), measured([shot])
    # 2 px are 0.4 mm: half of that would be in the tip's height, all of it in thickness.
    assert abs(error_mm(false, quantity=Quantity.FLANGE_HEIGHT)) < 0.05
    reading = false.readings[THICKNESS]
    assert abs(error_mm(false)) < reading.u95
    assert reading.u95 > true.readings[THICKNESS].u95
    lost = true.quality.by_sensor["outer"].points - false.quality.by_sensor["outer"].points
    assert lost > 40


def test_several_shots_are_joined_though_one_lacks_a_sensor(rng):
    shots = [rs.shot(WORN, rng, frame=1), rs.shot(WORN, rng, frame=2, names=("outer",))]
    answer = measured(shots)
    assert answer.quality.frames == (1, 2)
    assert abs(error_mm(answer)) < 0.05


def test_motions_by_the_rig_are_its_derivatives(rng):
    shot = rs.shot(WORN, rng)
    sheets = {f.sensor: SheetPoints.of(f.stripe, rs.rig()[f.sensor].sensor) for f in shot.frames}
    laying = lay_by_axle(sheets, rs.rig(), rs.SURVEY, template_of(S1002))
    part = laying.parts[0]
    points = part.sheet.points_in_cam_mm
    pose = part.sensor.rig_from_camera
    axle = AxleMap(pose, 0.0, ws.RADIUS_MM)
    exact = Section.of(part.sheet, axle)
    by_rig = motion_by_rig(replace(part, section=exact))
    for parameter in range(6):
        step = np.zeros(6)
        step[parameter] = 1e-5 if parameter < 3 else 1e-3
        ways = [
            AxleMap(moved_by(pose, sign * step), 0.0, ws.RADIUS_MM).section(points)
            for sign in (1.0, -1.0)
        ]
        seen = (ways[0] - ways[1]) / (2.0 * step[parameter])
        # Central differences: their error is of the third order of 1e-5 rad or 1e-3 mm.
        np.testing.assert_allclose(by_rig[:, :, 13 + parameter], seen, rtol=1e-5, atol=1e-5)


def random_overlap(rng, causes, stretches=12):
    angle = np.linspace(-1.2, 1.2, stretches)
    return Overlap(
        apart_mm=np.zeros(stretches),
        sigma_mm=np.full(stretches, 0.02),
        by_cause=rng.normal(0.0, 0.1, (stretches, causes)),
        outward=np.column_stack([np.sin(angle), np.cos(angle)]),
        number=np.arange(stretches),
        of_one=np.arange(stretches),
        of_other=np.arange(stretches),
    )


def test_what_is_left_of_the_causes_scatters_as_is_said(rng):
    overlap = random_overlap(rng, 5)
    reading = rng.normal(0.0, 0.1, 5)
    left, said = [], None
    for _ in range(2000):
        causes = rng.normal(size=5)
        noise = rng.normal(0.0, 0.02, len(overlap))
        learnt = learn([replace(overlap, apart_mm=overlap.by_cause @ causes + noise)], None)
        left.append(reading @ (causes - learnt.causes))
        said = np.concatenate(learnt.rest(reading))
    # 2000 draws tell a standard deviation to 1.6 %; a lost weight now and then adds little.
    assert np.std(left) == pytest.approx(np.linalg.norm(said), rel=0.06)
    assert np.std(left) < 0.5 * np.linalg.norm(reading)


def test_dirt_that_one_sensor_sees_hardly_moves_what_is_learnt(rng):
    overlap = random_overlap(rng, 3)
    causes = rng.normal(size=3)
    clean = overlap.by_cause @ causes
    dirty = clean.copy()
    dirty[4] += 0.5
    found = [learn([replace(overlap, apart_mm=each)], None).causes for each in (clean, dirty)]
    moved = overlap.by_cause @ (found[1] - found[0])
    assert np.abs(moved).max() < 0.1


def test_nothing_is_learnt_where_nothing_overlaps(rng):
    empty = random_overlap(rng, 3, stretches=0)
    assert learn([empty], None) is None
    assert displacement(empty) is None


def test_budget_knows_what_was_learnt(rng):
    once, shared = rng.normal(size=(4, 2, 2)), rng.normal(size=(4, 2, 3))
    motions = Motions(np.zeros((4, 2)), once, shared)
    overlap = random_overlap(rng, 5)
    learnt = learn([overlap], None)
    gradient = rng.normal(size=(4, 2))
    estimate = Estimate(0.0, gradient)
    before = motions.budget(estimate, 0.0)
    after = replace(motions, learnt=learnt).budget(estimate, 0.0)
    by_cause = np.concatenate([estimate.moved_by(once), estimate.moved_by(shared)])
    covariance = learnt.left @ learnt.left.T + learnt.noise @ learnt.noise.T
    assert after.sigma_mm == pytest.approx(np.sqrt(by_cause @ covariance @ by_cause))
    assert after.sigma_mm < before.sigma_mm


def test_a_rig_of_one_measures_as_its_sensor_does(rng):
    sensor, pose = ws.trackside()
    frame = WheelFrame(ws.stripe_on(WORN, sensor, pose, rng), 1, "x")
    alone = measure_wheel([frame], sensor, S1002, mounting=ws.mounting_of(pose))
    on_rig = measure_wheel_on_rig(
        [Shot((frame,))], Rig.of_one(sensor, pose), ws.mounting_of(pose), S1002
    )
    assert alone.readings == on_rig.readings
    assert alone.profile.seen_by is None
