"""Shows which addresses the service refuses to listen at, and with which line."""

import socket

import pytest

from station.errors import InputUnusable
from station.serve.listening import listen, url_of


def test_port_zero_takes_a_free_one_and_the_url_names_it():
    with listen("127.0.0.1", 0) as listening:
        port = listening.getsockname()[1]
        assert url_of(listening) == f"http://127.0.0.1:{port}"
        socket.create_connection(("127.0.0.1", port)).close()


def test_a_port_in_use_is_refused_with_what_to_do():
    with listen("127.0.0.1", 0) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(InputUnusable, match=f"port {port} of 127.0.0.1 is in use; stop"):
            listen("127.0.0.1", port)


@pytest.mark.parametrize("host", ["192.0.2.1", "no such host"])
def test_an_address_of_another_host_is_refused(host):
    with pytest.raises(InputUnusable, match="give an address of this host"):
        listen(host, 0)
