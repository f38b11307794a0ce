"""camera.json, and the camera part of a calibration."""

from typing import Self

import numpy as np
from pydantic import Field, model_validator

from calib import PARAMETERS, CameraModel
from station.documents.base import Document


class CameraDocument(Document):
    """OpenCV's camera model; pixel (0, 0) is the centre of the top-left pixel."""

    fx: float = Field(gt=0.0)
    fy: float = Field(gt=0.0)
    cx: float
    cy: float
    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0
    width: int = Field(gt=0)
    height: int = Field(gt=0)
    estimated: tuple[str, ...] = ()
    """The parameters that were estimated; the others were held."""
    covariance: tuple[tuple[float, ...], ...] = ()
    """Of the estimated parameters, in their order."""

    @model_validator(mode="after")
    def _check_covariance(self) -> Self:
        if unknown := set(self.estimated) - set(PARAMETERS):
            raise ValueError(f"estimated names {sorted(unknown)}; allowed: {', '.join(PARAMETERS)}")
        count = len(self.estimated)
        if not (len(self.covariance) == count and all(len(r) == count for r in self.covariance)):
            raise ValueError(
                f"covariance must be {count} x {count}, one row an estimated parameter"
            )
        return self

    @classmethod
    def from_model(cls, camera: CameraModel) -> Self:
        """Describe a camera; a parameter with zero variance counts as held."""
        estimated = np.flatnonzero(np.diag(camera.covariance) > 0.0)
        return cls(
            **dict(zip(PARAMETERS, camera.parameters.tolist(), strict=True)),
            width=camera.width,
            height=camera.height,
            estimated=tuple(PARAMETERS[i] for i in estimated),
            covariance=tuple(map(tuple, camera.covariance[np.ix_(estimated, estimated)].tolist())),
        )

    def model(self) -> CameraModel:
        """Return the camera, held parameters with zero variance."""
        covariance = np.zeros((len(PARAMETERS), len(PARAMETERS)))
        index = [PARAMETERS.index(name) for name in self.estimated]
        if index:
            covariance[np.ix_(index, index)] = self.covariance
        return CameraModel.from_parameters(
            np.array([getattr(self, name) for name in PARAMETERS]),
            width=self.width,
            height=self.height,
            covariance=covariance,
        )
