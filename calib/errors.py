"""Everything the calibration can refuse.

CalibError
├── TargetSpecInvalid      a TARGET text that does not parse
├── TargetNotFound         a picture in which the target is not seen
├── StripeNotFound         a picture in which no laser stripe is seen
├── CameraMismatch         a camera of another picture size than the pictures
├── TooFewViews            not enough usable pictures for what is asked
├── Degenerate             pictures from which the answer cannot be told apart from others
└── NotConverged           a solve that ended without an answer

Each message says what was seen, what is allowed and what to do, in one line.
"""


class CalibError(Exception):
    """Base of all refusals of the calibration."""


class TargetSpecInvalid(CalibError):
    """The text does not describe a target."""


class TargetNotFound(CalibError):
    """The target is not seen in a picture."""


class StripeNotFound(CalibError):
    """No laser stripe is seen in a picture."""


class CameraMismatch(CalibError):
    """The camera given is of another picture size than the pictures."""


class TooFewViews(CalibError):
    """Not enough usable pictures for what is asked."""


class Degenerate(CalibError):
    """The geometry of the pictures leaves the answer undetermined."""


class NotConverged(CalibError):
    """A solve ended without an answer."""
