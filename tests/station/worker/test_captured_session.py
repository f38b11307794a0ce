"""Shows the session that a recalibration takes by itself: its pictures, and how it goes on after a
crash.  The camera is a double."""

from dataclasses import dataclass, replace

import pytest
from recalibration_ground import Shop

from station.capture import CaptureReport, CaptureState, CaptureStatus
from station.errors import CameraUnreachable
from station.settings import RecalibrationSettings
from station.store import CalibrationSession, Recalibration, the
from station.worker.capturing import capture_session
from station.worker.quiet import Quiet

SETTINGS = RecalibrationSettings(
    sensors={"left": {"capture": {"target": "chessboard:7x8:12", "pictures": 5, "pause_s": 2.0}}}
)


@dataclass
class Camera:
    """Counts triggers; is unplugged, or dies with its caller, at a picture."""

    plan: object = None
    pictures: int = 0
    killed_at: int | None = None
    unplugged: bool = False

    def status(self):
        return CaptureStatus(CaptureState.IDLE, "left", session_id=None)

    def arm(self, plan):
        if self.unplugged:
            raise CameraUnreachable("no camera answers at 127.0.0.2")
        self.plan = plan

    def trigger(self):
        if self.pictures == self.killed_at:
            self.killed_at = None
            raise KeyboardInterrupt
        self.pictures += 1
        return self.pictures

    def finish(self, _expected=None):
        if self.unplugged:
            raise CameraUnreachable("no camera answers at 127.0.0.2")
        return CaptureReport(
            path=self.plan.path, triggered=None, recorded=self.pictures, lost=0, refused=0,
            repeated=0, resent_packets=0, first_time_ns=None, last_time_ns=None, events=(),
        )  # fmt: skip


@pytest.fixture
def shop(ground, tmp_path, rng):
    return Shop(ground, tmp_path / "trace", rng, settings=SETTINGS)


def capture(shop, camera, naps):
    context = replace(shop.context, captures={} if camera is None else {"left": camera})
    with shop.store.look() as session:
        row = the(session, Recalibration, "r1")
    return capture_session(context, row, Quiet(context, row, first=0, last=1, sleep=naps.append))


def session_of(shop):
    with shop.store.look() as session:
        return session.get(CalibrationSession, "recalibration-r1")


def test_pictures_are_taken_with_time_for_the_mount_between(shop):
    shop.order()
    camera, naps = Camera(), []
    assert capture(shop, camera, naps) == []
    assert (camera.pictures, naps) == (5, [2.0] * 4)
    row = session_of(shop)
    assert (row.state, row.pictures, row.target) == ("recorded", 5, "chessboard:7x8:12")


def test_session_cut_by_a_crash_is_gone_on_with_and_no_picture_taken_twice(shop):
    shop.order()
    camera = Camera(killed_at=3)
    with pytest.raises(KeyboardInterrupt):
        capture(shop, camera, [])
    assert session_of(shop).state == "open"
    assert capture(shop, camera, []) == []
    assert (camera.pictures, session_of(shop).state) == (5, "recorded")
    # And once it is closed nothing more is taken.
    assert capture(shop, camera, []) == []
    assert camera.pictures == 5


def test_camera_that_does_not_answer_is_a_remark_not_an_error(shop):
    shop.order()
    (remark,) = capture(shop, Camera(unplugged=True), [])
    assert remark == "no pictures were taken: no camera answers at 127.0.0.2"
    assert session_of(shop).state == "failed"


def test_without_a_running_station_nobody_has_the_camera(shop):
    shop.order()
    (remark,) = capture(shop, None, [])
    assert "nobody has the camera" in remark
    assert session_of(shop) is None
