"""Slowing down who tries keys: by address, so that nobody else is slowed down with them."""

import ipaddress
import math
import time
from collections import OrderedDict
from collections.abc import Callable
from threading import Lock

_MOST_ADDRESSES = 4096
_IPV6_SITE_BITS = 64


class Throttle:
    """An allowance of bad keys for each address, which fills up again with time.

    Only the addresses that used some of theirs are remembered, the latest 4096 of them: who calls
    from more addresses than that is let try more often, and the memory stays small.

    Parameters
    ----------
    allowance
        Bad keys an address may send at once.
    refill_s
        Time after which it may send one more, s.
    """

    def __init__(
        self, *, allowance: int, refill_s: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._allowance = allowance
        self._refill_s = refill_s
        self._clock = clock
        self._full_at_s: OrderedDict[str, float] = OrderedDict()
        """When the allowance of an address will be whole again, by address."""
        self._lock = Lock()

    def wait_s(self, address: str) -> int:
        """Return after how many seconds the address may try a key again; 0 where it may now."""
        with self._lock:
            missing_s = self._missing_s(site_of(address))
        # One bad key costs `refill_s` of the time that a whole allowance takes to fill.
        return max(math.ceil(missing_s - (self._allowance - 1) * self._refill_s), 0)

    def note_bad_key(self, address: str) -> None:
        """Take one from the allowance of the address."""
        site = site_of(address)
        with self._lock:
            missing_s = self._missing_s(site) + self._refill_s
            self._full_at_s[site] = self._clock() + min(missing_s, self._allowance * self._refill_s)
            self._full_at_s.move_to_end(site)
            while len(self._full_at_s) > _MOST_ADDRESSES:
                self._full_at_s.popitem(last=False)

    def _missing_s(self, site: str) -> float:
        missing_s = self._full_at_s.get(site, 0.0) - self._clock()
        if missing_s <= 0.0:
            self._full_at_s.pop(site, None)
        return max(missing_s, 0.0)


def site_of(address: str) -> str:
    """Return what counts as one caller: an IPv4 address, or the network of an IPv6 one.

    A single host is given 2^64 addresses of IPv6.

    Examples
    --------
    >>> site_of("10.0.0.7"), site_of("2001:db8:1:2:3::4"), site_of("somebody")
    ('10.0.0.7', '2001:db8:1:2::/64', 'somebody')
    """
    try:
        parsed = ipaddress.ip_address(address)
    except ValueError:
        return address
    if parsed.version == 4:
        return str(parsed)
    mapped = parsed.ipv4_mapped
    network = ipaddress.ip_network((int(parsed), _IPV6_SITE_BITS), strict=False)
    return str(network if mapped is None else mapped)
