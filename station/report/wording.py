"""Numbers as people write them: with their unit, and no more digits than are known."""

import math

UNKNOWN = "–"


def figures(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits, never in powers of ten.

    Examples
    --------
    >>> figures(0.0123456), figures(1234.5), figures(float("nan"))
    ('0.0123', '1234', '–')
    """
    if not math.isfinite(value):
        return UNKNOWN
    if value == 0.0:
        return "0"
    places = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return minus(f"{value:.{places}f}")


def to_digit_of(value: float, sigma: float) -> str:
    """Return a number to the second digit of its sigma, where it has one.

    Examples
    --------
    >>> to_digit_of(279.06171, 0.0123), to_digit_of(-0.5, 0.0)
    ('279.062', '−0.5')
    """
    if not math.isfinite(value):
        return UNKNOWN
    if not (math.isfinite(sigma) and sigma > 0.0):
        return minus(f"{value:.8g}")
    places = max(0, 1 - math.floor(math.log10(sigma)))
    return minus(f"{value:.{places}f}")


def minus(text: str) -> str:
    """Return a number's text with a minus sign in place of the hyphen."""
    return text.replace("-", "\N{MINUS SIGN}")


def count(number: int, one: str, many: str | None = None) -> str:
    """Return a number with its noun.

    Examples
    --------
    >>> count(1, "picture"), count(0, "picture"), count(2, "pass", "passes")
    ('1 picture', '0 pictures', '2 passes')
    """
    return f"{number} {one if number == 1 else many or one + 's'}"


def magnification(length: float, largest: float) -> float:
    """Return the round number (1, 2, 5 times a power of ten) that brings `length` to `largest`.

    Examples
    --------
    >>> magnification(0.013, 40.0), magnification(0.0, 40.0)
    (2000.0, 1.0)
    """
    if not (math.isfinite(length) and length > 0.0):
        return 1.0
    wanted = largest / length
    decade = 10.0 ** math.floor(math.log10(wanted))
    return max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= wanted)
