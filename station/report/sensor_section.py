"""The answer itself: light plane and camera, with what is not known of them."""

import math
from collections.abc import Iterator

import numpy as np

from calib import PARAMETERS
from station.documents import CalibrationDocument
from station.report.markup import Markup, element, number, section, table
from station.report.wording import UNKNOWN, figures, to_digit_of

_U95 = 1.96
_CAMERA_UNITS = dict.fromkeys(("fx", "fy", "cx", "cy"), "px")


def sensor_section(document: CalibrationDocument) -> Markup:
    """Return the light plane and the camera as tables."""
    return section(
        "Light plane and camera",
        element("p", _plane_in_words(document)),
        element("div", _plane_table(document), _camera_table(document), class_="side-by-side"),
    )


def _plane_in_words(document: CalibrationDocument) -> str:
    covariance = np.array(document.plane_covariance)
    worst_rad = math.sqrt(max(float(np.linalg.eigvalsh(covariance[:3, :3])[-1]), 0.0))
    to_axis_deg = math.degrees(math.asin(min(1.0, abs(document.plane.c))))
    return (
        "a x + b y + c z + d = 0 in the camera frame, mm. The sheet stands at "
        f"{figures(to_axis_deg, 4)}° to the optical axis, {figures(document.plane.d, 5)} mm from "
        f"the camera; its direction is known to {figures(1e3 * worst_rad, 2)} mrad (σ, along the "
        "worst axis). a to d vary together: what they mean on a wheel is the map below."
    )


def _plane_table(document: CalibrationDocument) -> Markup:
    plane = document.plane
    sigmas = np.sqrt(np.diag(np.array(document.plane_covariance)).clip(min=0.0)).tolist()
    values = (("a", plane.a, ""), ("b", plane.b, ""), ("c", plane.c, ""), ("d", plane.d, "mm"))
    rows = (
        _row(name, value, sigma, unit)
        for (name, value, unit), sigma in zip(values, sigmas, strict=True)
    )
    return table(("", "Value", "σ", "95 % (±)", ""), rows, caption="Light plane")


def _camera_table(document: CalibrationDocument) -> Markup:
    return table(("", "Value", "σ", "95 % (±)", ""), _camera_rows(document), caption="Camera")


def _camera_rows(document: CalibrationDocument) -> Iterator[tuple[Markup, ...]]:
    camera = document.camera.model()
    sigmas = np.sqrt(np.diag(camera.covariance).clip(min=0.0))
    for name, sigma in zip(PARAMETERS, sigmas.tolist(), strict=True):
        yield _row(name, getattr(camera, name), sigma, _CAMERA_UNITS.get(name, ""))


def _row(name: str, value: float, sigma: float, unit: str) -> tuple[Markup, ...]:
    known = sigma > 0.0
    return (
        element("th", name, scope="row"),
        number(to_digit_of(value, sigma)),
        number(figures(sigma, 2) if known else "held"),
        number(figures(_U95 * sigma, 2) if known else UNKNOWN),
        element("td", unit),
    )
