"""Shows that trying keys is slow, for who tries and for nobody else.  Time is a double."""

import pytest

from station.api.throttle import _MOST_ADDRESSES, Throttle, site_of


class Clock:
    now_s = 1000.0

    def __call__(self):
        return self.now_s


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def throttle(clock):
    return Throttle(allowance=3, refill_s=10.0, clock=clock)


def use_up(throttle, address, times=3):
    for _ in range(times):
        assert throttle.wait_s(address) == 0
        throttle.note_bad_key(address)


def test_an_address_may_send_its_allowance_and_then_one_in_a_while(throttle, clock):
    use_up(throttle, "10.0.0.1")
    assert throttle.wait_s("10.0.0.1") == 10
    clock.now_s += 9.0
    assert throttle.wait_s("10.0.0.1") == 1
    clock.now_s += 1.0
    use_up(throttle, "10.0.0.1", times=1)
    assert throttle.wait_s("10.0.0.1") == 10
    clock.now_s += 30.0
    use_up(throttle, "10.0.0.1")


def test_another_address_is_not_slowed(throttle):
    use_up(throttle, "10.0.0.1")
    assert throttle.wait_s("10.0.0.2") == 0


def test_who_goes_on_trying_is_not_shut_out_for_ever(throttle):
    for _ in range(100):
        throttle.note_bad_key("10.0.0.1")
    assert throttle.wait_s("10.0.0.1") == 10


def test_addresses_of_one_ipv6_network_are_one_caller(throttle):
    use_up(throttle, "2001:db8::1")
    assert throttle.wait_s("2001:db8::ffff") > 0
    assert throttle.wait_s("2001:db8:0:1::1") == 0
    assert site_of("::ffff:10.0.0.1") == "10.0.0.1"


def test_the_memory_of_addresses_is_bounded(throttle):
    for number in range(_MOST_ADDRESSES + 100):
        throttle.note_bad_key(f"10.{number // 65536}.{number // 256 % 256}.{number % 256}")
    assert len(throttle._full_at_s) == _MOST_ADDRESSES


def test_an_address_that_is_clean_again_is_forgotten(throttle, clock):
    throttle.note_bad_key("10.0.0.1")
    clock.now_s += 10.0
    assert throttle.wait_s("10.0.0.1") == 0
    assert not throttle._full_at_s
