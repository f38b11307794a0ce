"""A capture process records a real GigE Vision stream through Aravis, every frame accounted for.

What these tests do not show: a network card, a switch, a camera of another maker.
"""

import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from capture_rig import (
    assert_served,
    capture_of,
    is_idle,
    plan_for,
    sensor_at,
    small_camera,
    wait_for,
    wait_until,
)

from station.capture import CaptureState
from station.errors import CameraError, CameraRefused, InputUnusable, StateConflict
from station.recording import EventKind, active_path, events, frames, info, verify
from station.simulated import DeviceOptions, Faults

ADDRESS = "127.20.1.1"


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    """A camera within this process and a capture process that stays for all tests."""
    folder = tmp_path_factory.mktemp("capture")
    settings = sensor_at(ADDRESS, exposure_us=500.0, frame_rate_hz=100.0)
    with small_camera(ADDRESS) as camera, capture_of(settings, folder) as (client, _):
        wait_for(client, is_idle)
        yield camera, client


@pytest.fixture
def camera(rig):
    return rig[0]


@pytest.fixture
def client(rig):
    yield rig[1]
    if rig[1].status().state is not CaptureState.IDLE:
        rig[1].finish()


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


def fire(camera, count, first_ns=None):
    times = [(first_ns or time.time_ns()) + n * 5_000_000 for n in range(count)]
    for time_ns in times:
        assert camera.trigger_line1(time_ns)
        time.sleep(0.01)
    return times


def lose(camera, count):
    """Have so many pictures taken that are never sent."""
    before = camera.statistics().lost_frames
    camera.freeze()
    fire(camera, count)
    wait_until(lambda: camera.statistics().lost_frames == before + count)
    camera.thaw()


def kinds(recorded):
    return [event.kind for event in recorded]


def test_every_line1_trigger_is_in_the_file_with_its_exact_time(camera, client, path):
    exposed = camera.statistics().exposed
    client.arm(plan_for(path, metadata={"train": "G 4711"}, attachments={"note.txt": b"x"}))
    times = fire(camera, 12)
    report = client.finish(expected_frames=12)
    assert report.complete
    assert (report.triggered, report.recorded, report.lost, report.refused) == (12, 12, 0, 0)
    assert (report.first_time_ns, report.last_time_ns) == (times[0], times[-1])
    assert [frame.camera_time_ns for frame in frames(path)] == times
    assert_served(path, exposed, range(1, 13))
    assert verify(path).ok
    assert kinds(events(path)) == [EventKind.STARTED, EventKind.FINISHED]


def test_recording_tells_station_session_camera_and_account(camera, client, path):
    client.arm(plan_for(path, metadata={"train": "G 4711"}, attachments={"note.txt": b"xyz"}))
    fire(camera, 2)
    client.finish(expected_frames=2)
    found = info(path)
    assert found.metadata["session"] == {
        "id": "pass-7",
        "sensor": "left",
        "trigger": "Line1",
        "train": "G 4711",
    }
    assert found.metadata["camera"]["exposure_us"] == "500.0"
    assert found.metadata["camera"]["frame_rate_hz"] == "100.0"
    assert found.metadata["camera"]["serial"] == camera.serial
    assert found.metadata["accounting"]["recorded"] == "2"
    assert found.metadata["accounting"]["complete"] == "True"
    assert found.attachments == {"note.txt": 3}
    assert next(frames(path)).exposure_us == 500.0


def test_software_trigger_returns_the_id_of_the_frame_in_the_file(client, path):
    client.arm(plan_for(path, "software"))
    assert [client.trigger() for _ in range(3)] == [1, 2, 3]
    assert client.status().recorded == 3
    report = client.finish()
    assert (report.triggered, report.recorded, report.complete) == (3, 3, True)
    assert [frame.frame_id for frame in frames(path)] == [1, 2, 3]


def test_free_run_stops_by_itself_after_so_many_frames(camera, client, path):
    exposed = camera.statistics().exposed
    client.arm(plan_for(path, "free", frames=20))
    wait_for(client, lambda status: status.state is CaptureState.RECORDED)
    assert path.exists()
    report = client.finish()
    assert (report.triggered, report.recorded, report.complete) == (None, 20, True)
    assert_served(path, exposed, range(1, 21))


def test_free_run_stops_by_itself_after_so_many_seconds(client, path):
    client.arm(plan_for(path, "free", seconds=0.3))
    wait_for(client, lambda status: status.state is CaptureState.RECORDED)
    # 30 frames at 100 Hz; on a loaded host the camera may be late, or who tells it to stop.
    assert client.finish().recorded >= 5


def test_frame_lost_in_the_middle_is_an_event_and_a_figure(camera, client, path):
    client.arm(plan_for(path))
    fire(camera, 2)
    wait_for(client, lambda status: status.recorded == 2)
    lose(camera, 2)
    fire(camera, 1)
    report = client.finish(expected_frames=5)
    assert (report.recorded, report.lost, report.complete) == (3, 2, False)
    assert report.summary().endswith("2 lost; not complete")
    (lost,) = [event for event in events(path) if event.kind is EventKind.FRAMES_LOST]
    assert (lost.frame_id, lost.count) == (3, 2)
    assert verify(path).ok
    assert verify(path).lost == 2


def test_last_frame_lost_shows_against_the_controllers_count(camera, client, path):
    client.arm(plan_for(path))
    fire(camera, 3)
    wait_for(client, lambda status: status.recorded == 3)
    lose(camera, 1)
    report = client.finish(expected_frames=4)
    assert (report.recorded, report.lost, report.complete) == (3, 1, False)
    assert EventKind.FRAMES_MISCOUNTED in kinds(events(path))


def test_without_a_count_a_recording_is_what_came(camera, client, path):
    client.arm(plan_for(path))
    fire(camera, 3)
    report = client.finish()
    assert (report.triggered, report.recorded) == (None, 3)


def test_orders_that_the_state_forbids_name_the_state(camera, client, path):
    for order in (client.trigger, client.finish):
        with pytest.raises(StateConflict, match="is idle") as caught:
            order()
        assert caught.value.state == "idle"
    client.arm(plan_for(path))
    with pytest.raises(StateConflict, match="is recording"):
        client.arm(plan_for(path.with_name("b.mcap")))
    with pytest.raises(StateConflict, match="not `software`"):
        client.trigger()
    status = client.status()
    assert (status.state, status.session_id, status.path) == ("recording", "pass-7", path)


def test_recording_that_exists_is_refused_and_kept(client, path):
    path.write_bytes(b"precious")
    with pytest.raises(InputUnusable, match="exists"):
        client.arm(plan_for(path))
    assert path.read_bytes() == b"precious"
    assert is_idle(client.status())


def test_folder_that_is_not_there_is_refused(client, tmp_path):
    with pytest.raises(InputUnusable, match="cannot be created"):
        client.arm(plan_for(tmp_path / "none" / "a.mcap"))


def test_report_that_nobody_fetched_does_not_hold_up_the_next_recording(client, path):
    client.arm(plan_for(path, "free", frames=1))
    wait_for(client, lambda status: status.state is CaptureState.RECORDED)
    client.arm(plan_for(path.with_name("b.mcap"), "free", frames=1))
    assert client.finish().path == path.with_name("b.mcap")


def test_trigger_that_brings_no_frame_is_an_error_and_a_loss(tmp_path, path):
    faults = Faults(lost_frames=frozenset({1}))
    with (
        small_camera("127.20.1.3", faults=faults),
        capture_of(sensor_at("127.20.1.3"), tmp_path) as (client, _),
    ):
        client.arm(plan_for(path, "software"))
        assert client.trigger() == 1
        with pytest.raises(CameraError, match="no frame came of the trigger"):
            client.trigger()
        assert client.trigger() == 3
        report = client.finish()
    assert (report.triggered, report.recorded, report.lost) == (3, 2, 1)
    assert not report.complete


def test_who_waits_for_a_frame_is_told_that_the_recording_is_finished(tmp_path, path):
    faults = Faults(lost_frames=frozenset({0}))
    with (
        small_camera("127.40.1.2", faults=faults) as camera,
        capture_of(sensor_at("127.40.1.2"), tmp_path) as (client, _),
        ThreadPoolExecutor(1) as somebody_else,
    ):
        client.arm(plan_for(path, "software"))
        waiting = somebody_else.submit(client.trigger)
        wait_for(client, lambda _: camera.statistics().exposed == 1)
        client.finish(timeout_s=0.0)
        with pytest.raises(CameraError, match="finished before the frame came"):
            waiting.result()
        # Nor does the next recording take that trigger for one of its own.
        client.arm(plan_for(path.with_name("b.mcap"), "software"))
        assert client.trigger() == 1
        assert client.finish().complete


def test_packets_that_never_come_cost_frames_but_never_the_account(tmp_path, path):
    """A camera that keeps one picture only cannot send again what is asked for late."""
    faults = Faults(packet_loss=0.02, seed=5)
    options = DeviceOptions(resend_frames=1)
    settings = sensor_at("127.20.1.4", frame_rate_hz=150.0, exposure_us=500.0)
    with (
        small_camera("127.20.1.4", faults=faults, options=options),
        capture_of(settings, tmp_path) as (client, _),
    ):
        client.arm(plan_for(path, "free", frames=150))
        wait_for(client, lambda status: status.state is CaptureState.RECORDED)
        report = client.finish()
    assert report.recorded >= 5
    assert report.lost + report.refused >= 5
    assert report.repeated == 0
    assert not report.complete
    ids = [frame.frame_id for frame in frames(path)]
    assert len(ids) == report.recorded
    assert_served(path, 0, ids)
    assert verify(path).ok
    assert verify(path).lost == report.lost + report.refused


def test_camera_armed_while_another_streams_loses_no_frame_to_it(client, path, tmp_path):
    """A driver that takes the other's first packet for its own drops its first frames as late."""
    client.arm(plan_for(path, "free"))
    with (
        small_camera("127.20.1.5"),
        capture_of(sensor_at("127.20.1.5", frame_rate_hz=100.0), tmp_path) as (second, _),
    ):
        wait_for(second, is_idle)
        for number in range(5):
            second.arm(plan_for(tmp_path / f"second-{number}.mcap", "free", frames=10))
            wait_for(second, lambda status: status.state is CaptureState.RECORDED)
            report = second.finish()
            assert (report.recorded, report.lost) == (10, 0)
            # The first camera's ids must be close to those of the second one's next recording.
            client.finish()
            path.unlink()
            client.arm(plan_for(path, "free"))


def test_setting_out_of_range_is_refused_with_the_range(tmp_path):
    with (
        small_camera("127.20.1.2"),
        capture_of(sensor_at("127.20.1.2", exposure_us=1e9), tmp_path) as (client, _),
    ):
        with pytest.raises(CameraRefused, match=r"exposure 1e\+09 us .* takes .* to .* us"):
            client.arm(plan_for(tmp_path / "a.mcap"))
        assert "exposure" in wait_for(client, lambda status: status.problem).problem
    assert not active_path(tmp_path / "a.mcap").exists()


def test_camera_that_another_program_controls_is_refused(tmp_path, rig):
    with (
        capture_of(sensor_at(ADDRESS), tmp_path) as (second, _),
        pytest.raises(CameraRefused, match="controlled by another program"),
    ):
        second.arm(plan_for(tmp_path / "a.mcap"))
