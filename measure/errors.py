"""Everything measuring can refuse.

MeasureError
├── ReferenceUnknown       a reference profile that is not known
├── ReferenceInvalid       points that do not make a reference profile
├── ProfileTextInvalid     a profile text that does not parse
└── PieceInvalid           corners that do not make a reference piece

A wheel that cannot be measured is no error: it is a result with a reason.
"""


class MeasureError(Exception):
    """Base of all refusals of measuring."""


class ReferenceUnknown(MeasureError):
    """No reference profile of that name."""


class ReferenceInvalid(MeasureError):
    """The points do not make a reference profile."""


class ProfileTextInvalid(MeasureError):
    """The text holds no wheel profile."""


class PieceInvalid(MeasureError):
    """The corners or figures do not describe a reference piece."""
