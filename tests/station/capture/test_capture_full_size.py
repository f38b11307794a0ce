"""The issue's own figure: 200 frames at 53 frames/s with 1 % of packets dropped, all identical."""

from capture_rig import assert_served, capture_of, full_size_source, is_idle, plan_for, wait_for

from station.capture import CaptureState
from station.recording import verify
from station.settings import SensorSettings
from station.simulated import Faults, SimulatedCameraProcess


def test_two_hundred_full_size_frames_survive_one_percent_packet_loss(tmp_path):
    address, path = "127.20.2.1", tmp_path / "a.mcap"
    faults = Faults(packet_loss=0.01, seed=3)
    settings = SensorSettings(id="left", address=address)
    with (
        SimulatedCameraProcess(address, full_size_source, faults=faults) as camera,
        capture_of(settings, tmp_path) as (client, _),
    ):
        wait_for(client, is_idle)
        client.arm(plan_for(path, "free", frames=200))
        wait_for(client, lambda status: status.state is CaptureState.RECORDED)
        report = client.finish()
        dropped = camera.statistics().dropped_packets
    assert (report.recorded, report.lost, report.refused, report.repeated) == (200, 0, 0, 0)
    assert report.complete
    # 200 frames of 251 packets: 502 dropped are expected, sigma 22.
    assert dropped > 390
    assert report.resent_packets > 390
    assert_served(path, 0, range(1, 201), 2048, 1088)
    assert verify(path).ok
