"""Does each check tell a good host from a bad one, and say what to type?  The hosts are made up."""

import ctypes
import dataclasses
import errno
import os
import resource
import struct
import subprocess
import sys

import pytest

from station.capture import open_stream
from station.doctor import buffers, clock, disk, machine, route, software
from station.doctor.buffers import Rights
from station.doctor.cameras import judge_camera
from station.doctor.clock import ClockState
from station.doctor.demand import Stream
from station.doctor.finding import Finding, megabytes
from station.doctor.host import Host
from station.doctor.route import Route
from station.errors import InputUnusable
from station.settings import RegionSettings, SensorSettings, StorageSettings

STREAM = Stream("left", "192.0.2.1", packet_size=9000, frame_rate_hz=53.7, ring_slots=128)
NO_RIGHTS = Rights(net_admin=False, net_raw=False)
GOOD_ROUTE = Route("eth1", mtu=9000, speed_mbit=1000, carries=True)


@pytest.fixture
def host(tmp_path):
    """A host that is fine; a test spoils one of its files."""
    made = Host(tmp_path)
    for path, text in {
        "proc/sys/net/core/rmem_max": "67108864",
        "proc/sys/net/core/rmem_default": "212992",
        "proc/sys/net/core/netdev_max_backlog": "1000",
        "proc/self/status": "Name:\tpython\nCapEff:\t0000000000003000\n",
        "proc/meminfo": "MemTotal: 8000000 kB\nMemAvailable: 4000000 kB\n",
        "sys/fs/cgroup/memory.max": "max",
        "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor": "schedutil",
    }.items():
        spoil(made, path, text)
    return made


def spoil(host, path, text):
    (host.root / path).parent.mkdir(parents=True, exist_ok=True)
    (host.root / path).write_text(text + "\n")


def test_a_stream_is_counted_as_the_camera_sends_it():
    # 2048 x 1088 at 53.7: the 120 MB/s of the sensor; 8964 pixels a packet: 249, and two more.
    assert STREAM.bytes_per_s == pytest.approx(119.65e6, rel=1e-3)
    assert STREAM.packets_per_frame == 251


def test_a_stream_is_as_large_as_the_region_read_out():
    region = RegionSettings(width_px=2048, height_px=200)
    sensor = SensorSettings(id="left", address="192.0.2.1", region=region)
    assert Stream.of(sensor).picture_bytes == 2048 * 200
    assert Stream.of(sensor).on_network


def test_the_camera_that_aravis_brings_along_is_not_looked_for():
    assert not Stream.of(SensorSettings(id="left", address="Fake_1")).on_network


def test_the_doctor_asks_for_what_the_driver_asks_for():
    assert buffers.WANTED_BYTES == open_stream._WANTED_BYTES


@pytest.mark.parametrize(
    ("granted", "fine"),
    [(2 * buffers.WANTED_BYTES, True), (8 << 20, False), (212_992, False)],
)
def test_receive_buffer_below_what_the_driver_wants_is_named_with_the_sysctl(host, granted, fine):
    found = buffers.judge_receive_buffer(granted, NO_RIGHTS, host, [STREAM])
    assert found.fine is fine
    assert fine or "net.core.rmem_max = 67108864" in found.cure
    assert "rmem_default 212992" in found.seen


def test_receive_buffer_is_told_in_seconds_of_the_camera(host):
    # 128 MiB of 16 kB packets, 251 packets in each of 53.7 frames: 0.61 s.
    found = buffers.judge_receive_buffer(128 << 20, NO_RIGHTS, host, [STREAM])
    assert "0.61 s" in found.seen


def test_rights_are_read_from_the_effective_capabilities(host):
    assert Rights.of(host) == Rights(net_admin=True, net_raw=True)
    spoil(host, "proc/self/status", "CapEff:\t0000000000001000")
    assert Rights.of(host) == Rights(net_admin=True, net_raw=False)


def test_backlog_must_hold_a_frame_of_every_camera(host):
    assert buffers.judge_backlog(host, [STREAM] * 3).fine
    found = buffers.judge_backlog(host, [STREAM] * 4)
    assert not found.fine
    assert "net.core.netdev_max_backlog = 2008" in found.cure


def test_small_packets_fill_the_backlog_sooner(host):
    assert not buffers.judge_backlog(host, [dataclasses.replace(STREAM, packet_size=1500)]).fine


@pytest.mark.parametrize(
    ("changed", "cure"),
    [
        ({}, None),
        ({"carries": None}, None),
        ({"carries": False}, "jumbo frames in the switch"),
        ({"mtu": 1500}, "ip link set dev eth1 mtu 9000"),
    ],
)
def test_a_path_that_does_not_carry_the_packets_is_named(changed, cure):
    found = route.judge_packet_size(STREAM, dataclasses.replace(GOOD_ROUTE, **changed))
    assert found.fine is (cure is None)
    assert cure is None or cure in found.cure


def test_what_was_not_proved_of_the_path_is_said():
    found = route.judge_packet_size(STREAM, dataclasses.replace(GOOD_ROUTE, carries=None))
    assert "not proved" in found.seen


@pytest.mark.parametrize(("speed_mbit", "fine"), [(1000, True), (100, False)])
def test_a_link_slower_than_its_cameras_is_named(speed_mbit, fine):
    assert route.judge_link_speed("eth1", speed_mbit, STREAM.bytes_per_s).fine is fine


def test_a_loopback_camera_is_reached_by_a_route_that_carries_its_packets():
    here = dataclasses.replace(STREAM, address="127.0.0.1")
    found = route.probe_route(here, Host())
    assert found.interface == "lo"
    assert found.mtu >= 65535  # the interface's 65536, held to what an IP packet can be
    assert found.carries in {True, None}  # None where this user may not send echoes


_NARROW_PATH = """
from pathlib import Path
from station.doctor.demand import Stream
from station.doctor.host import Host
from station.doctor.route import judge_packet_size, probe_route
stream = Stream("left", "127.0.0.1", packet_size=9000, frame_rate_hz=53.7, ring_slots=128)
route = probe_route(stream, Host())
print(route.mtu, route.carries, judge_packet_size(stream, route).fine)
"""


def test_a_real_path_of_1500_bytes_is_found_too_narrow():
    """In a network of its own, whose loopback carries no more."""
    script = 'ip link set lo up mtu 1500 && exec "$0" -c "$1"'
    command = ["unshare", "-rn", "sh", "-c", script, sys.executable, _NARROW_PATH]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if "unshare" in done.stderr:
        pytest.skip("this user may not make a network of its own")
    mtu, carries, fine = done.stdout.split()
    assert (mtu, fine) == ("1500", "False")
    assert carries in {"False", "None"}


def test_the_checksum_is_that_of_rfc_1071():
    # The worked example of its section 3: the sum is ddf2.
    assert route._checksum(bytes.fromhex("0001f203f4f5f6f7")) == 0xFFFF - 0xDDF2


@pytest.mark.parametrize(("speed", "fine"), [(200e6, True), (130e6, False), (60e6, False)])
def test_a_disk_without_margin_is_named(tmp_path, speed, fine):
    found = disk.judge_speed(speed, tmp_path, [STREAM])
    assert found.fine is fine
    assert fine or "150 MB/s" in found.cure


def test_a_slow_disk_is_told_in_seconds_until_the_ring_is_full(tmp_path):
    # 285 MB of ring, 59.65 MB/s too many.
    assert "bridge 5 s" in disk.judge_speed(60e6, tmp_path, [STREAM]).seen


def test_the_trial_leaves_nothing_behind_and_a_slow_disk_does_not_hold_it_up(tmp_path):
    ticks = iter(range(100))  # every look at the clock is a second later
    speed = disk.write_speed(tmp_path, longest_s=3.0, now_s=lambda: next(ticks))
    assert speed == pytest.approx(2 * (8 << 20) / 4, rel=0.5)
    assert list(tmp_path.iterdir()) == []


def test_room_is_ten_minutes_of_all_cameras(tmp_path, monkeypatch):
    usage = disk.shutil._ntuple_diskusage(200e9, 100e9, 100e9)
    monkeypatch.setattr(disk.shutil, "disk_usage", lambda _: usage)
    assert disk.judge_space(tmp_path, [STREAM], StorageSettings()).fine
    found = disk.judge_space(tmp_path, [STREAM] * 2, StorageSettings(keep_free_gb=10.0))
    assert "free 53.6 GB" in found.cure


@pytest.mark.parametrize(("quota_gb", "fine"), [(None, True), (150.0, True), (199.5, False)])
def test_a_quota_beyond_the_disk_is_named(tmp_path, monkeypatch, quota_gb, fine):
    usage = disk.shutil._ntuple_diskusage(200e9, 100e9, 100e9)
    monkeypatch.setattr(disk.shutil, "disk_usage", lambda _: usage)
    found = disk.judge_quota(tmp_path, StorageSettings(quota_gb=quota_gb))
    assert found.fine is fine
    assert fine or "quota_gb = 179" in found.cure


def test_a_data_folder_to_be_made_is_judged_where_it_will_be(tmp_path):
    assert disk.existing_folder(tmp_path / "a" / "b") == tmp_path


def test_a_data_folder_that_is_a_file_is_unusable(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputUnusable, match="change data_dir"):
        disk.existing_folder(tmp_path / "file")


@pytest.mark.parametrize(
    ("state", "fine"),
    [
        (ClockState(synchronised=True, largest_error_s=0.02), True),
        (ClockState(synchronised=True, largest_error_s=16.0), False),
        (ClockState(synchronised=False, largest_error_s=0.02), False),
    ],
)
def test_a_clock_nobody_keeps_is_named(state, fine):
    found = clock.judge_clock(state)
    assert found.fine is fine
    assert fine or "chrony" in found.cure


@pytest.mark.parametrize(("status", "synchronised"), [(0x2001, True), (0x2041, False)])
def test_the_kernels_answer_is_read_as_its_header_says(status, synchronised):
    """STA_UNSYNC is 0x40 of <linux/timex.h>; errors are microseconds."""

    def adjtimex(pointer):
        answer = struct.pack("@I4xqqqqi4x", 0, 5, 6, 250_000, 7, status)
        ctypes.memmove(pointer, answer, len(answer))
        return 0

    assert clock.clock_state(adjtimex) == ClockState(synchronised, pytest.approx(0.25))


def test_a_kernel_that_does_not_answer_is_an_error():
    with pytest.raises(OSError, match="Errno"):
        clock.clock_state(lambda _pointer: -1)


def test_the_kernel_tells_of_its_clock():
    state = clock.clock_state()
    assert 0.0 <= state.largest_error_s <= 16.0 + 1e-9  # where the kernel stops counting


@pytest.mark.parametrize(("cores", "cameras", "fine"), [(2, 2, True), (2, 3, False), (1, 1, False)])
def test_cores_must_do_for_the_cameras_and_the_rest(cores, cameras, fine):
    assert machine.judge_processors(cores, [STREAM] * cameras).fine is fine


@pytest.mark.parametrize(
    ("governor", "driver", "fine"),
    [
        ("performance", "acpi-cpufreq", True),
        ("powersave", "acpi-cpufreq", False),
        ("powersave", "intel_pstate", True),
    ],
)
def test_a_governor_that_holds_the_clock_down_is_named(host, governor, driver, fine):
    folder = "sys/devices/system/cpu/cpu0/cpufreq"
    spoil(host, f"{folder}/scaling_governor", governor)
    spoil(host, f"{folder}/scaling_driver", driver)
    assert machine.judge_governor(host).fine is fine


def test_a_machine_without_governor_is_fine(tmp_path):
    assert machine.judge_governor(Host(tmp_path)).fine


def test_rings_must_fit_into_the_memory_to_be_had(host):
    assert machine.judge_memory(host, [STREAM] * 2).fine
    found = machine.judge_memory(host, [dataclasses.replace(STREAM, ring_slots=1024)] * 2)
    assert not found.fine
    assert "ring_slots" in found.cure


def test_the_bound_of_the_control_group_counts(host):
    spoil(host, "sys/fs/cgroup/memory.max", "2000000000")
    spoil(host, "sys/fs/cgroup/memory.current", "1000000000")
    assert not machine.judge_memory(host, [STREAM]).fine


def test_a_kernel_that_forbids_memfd_is_named(host, monkeypatch):
    def refuse(_name):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    assert machine.judge_shared_memory(host).fine
    monkeypatch.setattr(os, "memfd_create", refuse)
    assert "vm.memfd_noexec = 1" in machine.judge_shared_memory(host).cure


@pytest.mark.parametrize(
    ("files", "size", "fine"),
    [
        (1024, resource.RLIM_INFINITY, True),
        (256, resource.RLIM_INFINITY, False),
        (4096, 2**31, False),
    ],
)
def test_limits_of_the_process_are_named(files, size, fine):
    assert machine.judge_limits(files, size).fine is fine


def test_a_silent_camera_is_named():
    assert "camera list --address 192.0.2.1" in judge_camera(STREAM, None).cure


def test_missing_and_wrong_packages_are_named():
    found = software.judge_packages(["numpy<1", "no-such-package>=3", "mcap>=1.2"])
    assert "no-such-package is not installed" in found.seen
    assert "allowed: numpy<1" in found.seen
    assert "mcap" not in found.seen
    assert "requirements.lock" in found.cure


def test_the_installed_packages_are_as_required():
    assert software.judge_packages().fine


def test_packages_of_extras_are_not_required():
    assert software.judge_packages(['no-such-package>=3; extra == "test"']).fine


def test_versions_compare_by_their_numbers():
    assert software._release("3.10") > software._release("3.9.1")
    assert software._release("3") == software._release("3.0.0+local1")


def test_an_aravis_that_does_not_load_is_named():
    found = software.judge_aravis(software.probe_aravis("raise ImportError"))
    assert "gir1.2-aravis-0.8" in found.cure


def test_bytes_are_told_as_people_read_them():
    assert (megabytes(134_217_728), megabytes(83.1e9)) == ("134 MB", "83.1 GB")


def test_a_finding_without_words_cannot_be():
    with pytest.raises(ValueError, match="a finding has a name"):
        Finding("disk", "slow", "")
