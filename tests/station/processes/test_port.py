"""A port for later is none that somebody else may be given meanwhile."""

import socket

import pytest

from station.processes import port
from station.processes.port import port_for_later


def given_out():
    """Return a port as the kernel gives it to whoever asks for any."""
    with socket.socket() as anybody:
        anybody.bind(("127.0.0.1", 0))
        return anybody.getsockname()[1]


def test_port_for_later_is_below_all_that_the_kernel_gives_out():
    ports = [port_for_later() for _ in range(20)]
    assert max(ports) < min(given_out() for _ in range(20))
    assert len(set(ports)) > 15


def test_port_in_use_is_passed_over(monkeypatch):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", port_for_later()))
        taken.listen()
        free = port_for_later()
        draws = iter([taken.getsockname()[1] - 10_000, free - 10_000])
        monkeypatch.setattr(port.secrets, "randbelow", lambda _: next(draws))
        assert port_for_later() == free


def test_host_whose_ports_are_all_in_use_is_said(monkeypatch):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", port_for_later()))
        taken.listen()
        place = taken.getsockname()[1] - 10_000
        monkeypatch.setattr(port.secrets, "randbelow", lambda _: place)
        with pytest.raises(OSError, match="100 ports of 127.0.0.1 from 10000 to"):
            port_for_later()


@pytest.mark.parametrize("told", ["", "none", "1024 65535"])
def test_host_that_says_nothing_useful_gives_usual_ports(monkeypatch, tmp_path, told):
    (tmp_path / "range").write_text(told)
    monkeypatch.setattr(port, "_GIVEN_OUT", tmp_path / "range")
    assert 10_000 <= port_for_later() < 32_768
