"""reference.json: a new wheel that was measured, as the profile that wear is counted from."""

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import AwareDatetime, Field, StringConstraints, model_validator

from measure import NOMINAL, MeasuredReference, Quantity, ReferenceProfile
from station.documents.base import Document
from station.documents.calibration import InputFile

REFERENCE_NAME = r"[A-Za-z0-9][A-Za-z0-9 ._-]{0,63}"
"""What a reference may be called."""
ReferenceName = Annotated[str, StringConstraints(pattern=f"^{REFERENCE_NAME}$")]


class NominalDocument(Document):
    """What a gauge reads on the reference, mm; `spread` is from wheel to wheel, null of one."""

    value: float
    u95: float = Field(ge=0.0)
    spread: float | None = None


class ReferencePoints(Document):
    """The profile: lateral from the tape circle, height over it, one sigma across the profile."""

    y_mm: tuple[float, ...]
    z_mm: tuple[float, ...]
    sigma_mm: tuple[float, ...]

    @model_validator(mode="after")
    def _check_lengths(self) -> Self:
        if not len(self.y_mm) == len(self.z_mm) == len(self.sigma_mm):
            raise ValueError("y_mm, z_mm and sigma_mm must be equally long")
        return self


class MeasuredWheel(InputFile):
    """A measurement that went in: its file, and which wheel of it."""

    wheel: str
    calibration: str | None = None
    """Fingerprint of the calibration it rests on; null where a profile was given."""


class ReferenceDocument(Document):
    """A measured reference profile."""

    format: Literal["treadline-reference"] = "treadline-reference"
    version: Literal[1] = 1
    name: ReferenceName
    created: AwareDatetime
    software: str
    nominal: dict[Quantity, NominalDocument]
    profile: ReferencePoints
    made_of: tuple[MeasuredWheel, ...]
    options: dict[str, Any] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _check_nominal(self) -> Self:
        missing = [quantity.value for quantity in NOMINAL if quantity not in self.nominal]
        if missing:
            raise ValueError(f"nominal lacks {', '.join(missing)}")
        return self

    def measured(self) -> MeasuredReference:
        """Return it as values."""
        nominal = self.nominal.items()
        return MeasuredReference(
            points_mm=np.column_stack([self.profile.y_mm, self.profile.z_mm]),
            sigma_mm=np.array(self.profile.sigma_mm),
            nominal={quantity: each.value for quantity, each in nominal},
            u95={quantity: each.u95 for quantity, each in nominal},
            spread={q: each.spread for q, each in nominal if each.spread is not None},
        )

    def reference(self) -> ReferenceProfile:
        """Return it as what wear is counted from."""
        return self.measured().profile(self.name)


def reference_points(found: MeasuredReference) -> ReferencePoints:
    """Return the points of a reference as its file has them."""
    y, z = found.points_mm.T
    return ReferencePoints(
        y_mm=tuple(y.tolist()), z_mm=tuple(z.tolist()), sigma_mm=tuple(found.sigma_mm.tolist())
    )


def reference_nominal(found: MeasuredReference) -> dict[Quantity, NominalDocument]:
    """Return the readings of a reference as its file has them."""
    return {
        quantity: NominalDocument(
            value=value, u95=found.u95[quantity], spread=found.spread.get(quantity)
        )
        for quantity, value in found.nominal.items()
    }
