"""A pose in several exposures shows more than any one of them.

Rendered light; how real cameras round exposures is left to `Exposure.differs_by_laser`.
"""

from dataclasses import replace

import numpy as np
import pytest

from calib import Cause, Target, TargetNotFound, observe_target
from station.errors import InputUnusable
from station.pipeline import observe_sources
from station.pipeline.exposures import Exposure
from station.pipeline.frames import Frame
from station.pipeline.observe import poses_of
from station.pipeline.observe_group import PoseShot, observe_group
from station.recording import Event, EventKind, RecordingWriter
from station.scenes import Light, paper_sensor, target_scenes

TARGET = Target.parse("dots:7x8:12:d=6")
ALL = TARGET.rows * TARGET.cols
STEPS = ((0.15, False), (0.6, False), (0.15, True), (0.6, True))


@pytest.fixture(scope="module")
def scene():
    """A pose under four times the light that the dots want."""
    rng = np.random.default_rng(3)
    (scene,) = target_scenes(rng, paper_sensor(), TARGET, [Light.OVER_EXPOSED])
    return scene


@pytest.fixture(scope="module")
def shots(scene):
    rng = np.random.default_rng(4)
    detector = scene.physics.detector
    light = {True: scene.light_counts(), False: replace(scene, laser_on=False).light_counts()}
    return [
        PoseShot(f"shot{place}", detector.expose(light[on], rng, exposure), how(1e4 * exposure, on))
        for place, (exposure, on) in enumerate(STEPS)
    ]


def how(exposure_us, laser, group=1):
    return Exposure(exposure_us, 0.0, laser, group)


def off_sheet_mm(scene, view):
    """Root mean square distance of the stripe's points from the true sheet, mm."""
    sensor = scene.sensor
    board = scene.cam_from_board
    rays = sensor.camera.rays(view.stripe.centre_px)
    normal, origin = board.rotation[:, 2], board.translation_mm
    on_board_mm = rays * ((normal @ origin) / (rays @ normal))[:, None]
    return float(np.sqrt(np.mean(sensor.plane.distance_mm(on_board_mm) ** 2)))


def test_group_shows_every_dot_and_a_better_stripe_than_the_overexposed_frame(scene, shots):
    view = observe_group(shots, TARGET)
    bright = observe_target(shots[3].picture, TARGET, name="bright")
    assert len(view.points) >= ALL - 1  # one dot lies in glare that clips in every exposure
    assert view.name == "shot2"  # the stripe of the short exposure, which does not clip
    assert not view.stripe.saturated.any()
    assert off_sheet_mm(scene, view) < 0.5 * off_sheet_mm(scene, bright)


def test_dots_come_from_where_they_do_not_clip(shots):
    view = observe_group(shots, TARGET)
    bright = observe_target(shots[3].picture, TARGET, name="bright")
    assert bright.points.cause.count(Cause.SATURATED) > ALL / 2
    assert view.points.cause.count(Cause.SATURATED) <= 2


def test_dots_are_the_means_of_all_shots_that_show_them_well():
    """In dim light what the shots err in is their own: two tell more than one."""
    rng = np.random.default_rng(7)
    (scene,) = target_scenes(rng, paper_sensor(), TARGET, [Light.DIM])
    on, off = scene.render(rng), replace(scene, laser_on=False).render(rng)
    dark = PoseShot("off", off, how(1e4, False))
    alone = observe_group([dark], TARGET)
    both = observe_group([dark, PoseShot("on", on, how(1e4, True))], TARGET)
    # Independent of each other, two of one light would come to 0.71; a crossed one stays alone.
    assert np.median(both.points.sigma_px) < 0.85 * np.median(alone.points.sigma_px)
    assert set(both.points.cause) == {Cause.NONE}  # crossed with the laser on, whole without
    assert both.name == "on"


def test_stripe_is_found_where_its_own_exposure_shows_no_dot():
    """A laser thirteen times as bright as the dots: at a fiftieth they have three counts."""
    rng = np.random.default_rng(5)
    (scene,) = target_scenes(rng, paper_sensor(), TARGET, [Light.STRAY])
    detector, dark = scene.physics.detector, replace(scene, laser_on=False).light_counts()
    dots, off = detector.expose(dark, rng, 1.0), detector.expose(dark, rng, 0.015)
    on = detector.expose(scene.light_counts(), rng, 0.015)
    with pytest.raises(TargetNotFound):
        observe_target(off, TARGET, name="dark")
    short = [PoseShot("off", off, how(150.0, False)), PoseShot("on", on, how(150.0, True))]
    view = observe_group([PoseShot("dots", dots, how(1e4, False)), *short], TARGET)
    assert view.name == "on"
    assert len(view.points) >= 0.9 * ALL  # spots of stray light hide some
    assert len(view.stripe) > 10


def test_exposures_without_a_laser_switch_are_merged_too(shots):
    with_laser = [shot for shot in shots if shot.exposure.laser]
    view = observe_group(with_laser, TARGET)
    assert view.stripe is not None
    assert len(view.points) >= 0.9 * ALL


def test_pose_with_the_laser_always_off_serves_the_camera(shots):
    view = observe_group(shots[:2], TARGET)
    assert view.stripe is None
    assert len(view.points) >= ALL - 1


def test_pose_that_shows_no_target_says_so():
    black = np.zeros((200, 300), dtype=np.uint8)
    with pytest.raises(TargetNotFound, match="dark: no pattern"):
        observe_group([PoseShot("dark", black, how(10.0, True))], TARGET)


@pytest.mark.parametrize(
    ("other", "alike"),
    [
        (how(1005.0, False), True),
        (how(1020.0, False), False),
        (how(1000.0, True), False),
        (Exposure(1000.0, 6.0, False, 1), False),
    ],
)
def test_laser_off_partner_is_the_frame_that_differs_by_the_laser_alone(other, alike):
    assert how(1000.0, True).differs_by_laser(other) is alike


def test_frames_of_a_group_are_one_pose_and_others_one_each():
    blank = np.zeros((4, 4), np.uint8)

    def frame(name, group, source="a"):
        exposure = None if group is None else how(1.0, True, group)
        return Frame(name, source, 1, blank, exposure=exposure)

    frames = [frame("1", 1), frame("2", 1), frame("3", 2), frame("4", 2, "b")]
    frames += [frame("5", None), frame("6", None)]
    names = [[one.name for one in pose] for pose in poses_of(frames)]
    assert names == [["1", "2"], ["3"], ["4"], ["5"], ["6"]]


@pytest.fixture
def recorded(tmp_path, shots):
    """The pose in a recording, as the driver writes it."""
    path = tmp_path / "a.mcap"
    with RecordingWriter(path) as writer:
        for number, shot in enumerate(shots, start=1):
            height, width = shot.picture.shape
            picture = memoryview(np.ascontiguousarray(shot.picture)).cast("B")
            writer.write_frame("left", number, number, number, picture, width, height)
            values = {
                "exposure_us": shot.exposure.exposure_us,
                "gain_db": 0.0,
                "laser": shot.exposure.laser,
                "group": 1,
                "step": number - 1,
            }
            event = Event(EventKind.EXPOSED, number, "", number, 1, values)
            writer.write_event("left", event)
    return path


def test_recording_of_one_pose_in_four_exposures_gives_one_view(recorded, shots):
    seen = observe_sources([recorded], TARGET)
    (view,) = seen.views
    assert view.name == "a.mcap#3"
    expected = observe_group(shots, TARGET)
    np.testing.assert_array_equal(view.points.centre_px, expected.points.centre_px)
    np.testing.assert_array_equal(view.stripe.centre_px, expected.stripe.centre_px)


def test_laser_off_pictures_beside_a_sequence_are_refused(recorded):
    with pytest.raises(InputUnusable, match="leave --laser-off out"):
        observe_sources([recorded], TARGET, laser_off=[recorded])
