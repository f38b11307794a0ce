"""CRC-32 of a whole from the CRC-32 of its parts.

The data section of a recording carries one checksum over everything in it, and each chunk carries
its own.  Joining the second into the first costs microseconds a frame; reading 2 MB of picture
again would cost a millisecond.
"""

from functools import lru_cache

_POLYNOMIAL = 0xEDB88320  # CRC-32 of zlib, bits reversed
_ONE = 1 << 31  # the polynomial 1: the lowest power is the highest bit


def joined_crc(first: int, second: int, second_length: int) -> int:
    """Return the CRC-32 of two byte strings one after the other.

    Parameters
    ----------
    first, second
        CRC-32 of each, as `zlib.crc32` returns it.
    second_length
        Length of the second, bytes.

    Notes
    -----
    A CRC is linear over GF(2): appending n bytes multiplies the first remainder by
    x^(8n) mod P, and the second's is added.

    Examples
    --------
    >>> import zlib
    >>> joined_crc(zlib.crc32(b"light "), zlib.crc32(b"plane"), 5) == zlib.crc32(b"light plane")
    True
    """
    return _multiply(_power_of_x(8 * second_length), first) ^ second


def _multiply(a: int, b: int) -> int:
    """Multiply two polynomials modulo P, bits reversed."""
    product = 0
    while a:
        if a & _ONE:
            product ^= b
        a = (a << 1) & 0xFFFFFFFF
        b = (b >> 1) ^ (_POLYNOMIAL if b & 1 else 0)
    return product


@lru_cache(maxsize=256)  # frames of one camera have one length, give or take a varint
def _power_of_x(exponent: int) -> int:
    """Return x^exponent mod P by squaring."""
    result, square = _ONE, _ONE >> 1
    while exponent:
        if exponent & 1:
            result = _multiply(result, square)
        square = _multiply(square, square)
        exponent >>= 1
    return result
