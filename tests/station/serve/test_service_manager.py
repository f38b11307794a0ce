"""What the service manager is told; not that systemd hears it, which the package's test shows."""

import os
import socket
from contextlib import contextmanager

import pytest

from station.processes.stop_signal import StopSignal
from station.serve import readiness
from station.serve.children import Child
from station.serve.service_manager import ServiceManager
from station.serve.supervisor import _run


@pytest.fixture
def manager_socket(tmp_path):
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(str(tmp_path / "notify"))
        listening.settimeout(60.0)
        yield listening


def told(listening):
    return listening.recv(4096).decode().splitlines()


def manager_of(listening, **more):
    return ServiceManager.of({"NOTIFY_SOCKET": listening.getsockname(), **more})


def test_without_a_service_manager_nothing_is_told_and_nothing_fails():
    manager = ServiceManager.of({})
    manager.tell_ready()
    manager.tell_alive()
    assert manager.sign_every_s is None


def test_a_service_manager_that_has_gone_does_no_harm(tmp_path):
    ServiceManager.of({"NOTIFY_SOCKET": str(tmp_path / "nobody")}).tell_ready()


def test_an_abstract_address_is_understood():
    name = f"\0treadline-test-{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(name)
        listening.settimeout(60.0)
        ServiceManager.of({"NOTIFY_SOCKET": f"@{name[1:]}"}).tell_ready()
        assert told(listening) == ["READY=1"]


def test_signs_of_life_come_three_times_a_period(manager_socket):
    assert manager_of(manager_socket, WATCHDOG_USEC="30000000").sign_every_s == 10.0


def test_a_watchdog_of_another_process_wants_no_signs(manager_socket):
    manager = manager_of(manager_socket, WATCHDOG_USEC="30000000", WATCHDOG_PID="1")
    assert manager.sign_every_s is None


def test_a_status_is_one_line_whatever_was_said(manager_socket):
    manager_of(manager_socket).tell_status("waiting\nREADY=1")
    assert told(manager_socket) == ["STATUS=waiting READY=1"]


def test_ready_is_told_when_the_api_answers_though_a_camera_is_away(manager_socket, monkeypatch):
    answers = [{"api": "does not answer yet"}, {"left": "unreachable"}, {}]
    monkeypatch.setattr(readiness, "missing_parts", lambda _url: answers.pop(0))
    announced = []
    with StopSignal(()) as stop:
        readiness._watch(
            "http://x", lambda *of: announced.append(of), stop, manager_of(manager_socket)
        )
    assert told(manager_socket) == ["READY=1"]
    assert told(manager_socket) == ["STATUS=serving at http://x; waiting for left (unreachable)"]
    assert len(announced) == 1


class NeverEnding:
    """A process that does nothing, seen from outside."""

    pid = os.getpid()
    exitcode = None

    def terminate(self):
        self.exitcode = 0

    def join(self, timeout=None):
        pass


@contextmanager
def stop_after(signs, manager, stop):
    """Have the stop come once so many signs of life were given."""
    count = 0
    given = ServiceManager.tell_alive

    def counted(self):
        nonlocal count
        given(self)
        count += 1
        if count == signs:
            stop._note(15, None)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ServiceManager, "tell_alive", counted)
        yield


def test_the_supervisor_gives_signs_while_it_goes_round_and_says_when_it_stops(manager_socket):
    manager = manager_of(manager_socket, WATCHDOG_USEC="30000")
    with StopSignal(()) as stop, stop_after(3, manager, stop):
        _run([[Child("worker", NeverEnding, 1.0)]], stop, lambda _: None, manager)
    heard = [told(manager_socket)[0] for _ in range(4)]
    assert heard == ["WATCHDOG=1"] * 3 + ["STOPPING=1"]
