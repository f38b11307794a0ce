"""Wheels as lines for people."""

from collections.abc import Iterator

from measure import Alarm, Placing, Quantity
from station.documents import AxleDocument, MeasurementDocument, ReadingDocument, WheelDocument

_SHOWN = (
    Quantity.FLANGE_HEIGHT,
    Quantity.FLANGE_THICKNESS_10,
    Quantity.FLANGE_THICKNESS_12,
    Quantity.FLANGE_GRADIENT_QR,
    Quantity.TREAD_WEAR,
)
_WHERE_TOLD = (Quantity.DIAMETER,)
_SHORT = {
    Quantity.FLANGE_HEIGHT: "Sh",
    Quantity.FLANGE_THICKNESS_10: "Sd",
    Quantity.FLANGE_GRADIENT_QR: "qR",
}
# Instruments and we read the same points to a few hundredths; a header that is farther off was
# left over from another wheel, or its instrument has other rules.
_BELONGS_MM = 0.05


def text_of(document: MeasurementDocument) -> str:
    """Return one line a wheel, readings with their 95 % uncertainty."""
    lines = [line for wheel in document.wheels for line in _lines(wheel)]
    lines += [_of_axle(axle) for axle in document.axles]
    if document.no_back_to_back is not None:
        lines.append(f"no back-to-back: {document.no_back_to_back}")
    return "\n".join([*lines, f"{document.measured} of {len(document.wheels)} wheels measured"])


def _of_axle(axle: AxleDocument) -> str:
    where = f"axle {axle.axle}" if axle.axle is not None else "axle unknown"
    found = axle.back_to_back
    if found.value is None:
        return f"{where}: no back-to-back: {found.reason}"
    raised = f", {found.alarm.value}" if found.alarm in {Alarm.WARNING, Alarm.ALARM} else ""
    return f"{where}: back_to_back {found.value:.2f} \u00b1 {found.u95:.2f}{raised}"


def _lines(wheel: WheelDocument) -> Iterator[str]:
    where = _where(wheel)
    if wheel.reason is not None:
        yield f"{where}: not measured: {wheel.reason}"
        return
    # The rule is a rig that tells no diameter: that it is missing is no news.
    told = [name for name in _WHERE_TOLD if wheel.readings[name].value is not None]
    shown = (f"{name.value} {_shown(wheel.readings[name])}" for name in (*_SHOWN, *told))
    yield f"{where}: {', '.join(shown)}"
    alarms = [
        f"{name.value} {reading.alarm.value}"
        for name, reading in wheel.readings.items()
        if reading.alarm in {Alarm.WARNING, Alarm.ALARM}
    ]
    if alarms:
        yield f"{where}: {', '.join(alarms)}"
    silent = _silent_sensors(wheel)
    if silent:
        yield f"{where}: without {'; '.join(silent)}"
    if wheel.header is not None and wheel.header.claimed:
        yield f"{where}: {_beside_header(wheel, wheel.header.claimed)}"


def _silent_sensors(wheel: WheelDocument) -> list[str]:
    """Return the sensors of a rig that gave no point, and why."""
    shares = wheel.quality.get("by_sensor", {})
    return [f"{name} ({share['reason']})" for name, share in shares.items() if share["reason"]]


def _where(wheel: WheelDocument) -> str:
    where = wheel.source if wheel.frame is None else f"{wheel.source} frame {wheel.frame}"
    if wheel.side is None:
        return where
    axle = f"axle {wheel.axle}" if wheel.axle is not None else "axle unknown"
    sure = "" if wheel.placing in {None, Placing.CERTAIN} else f" ({wheel.placing})"
    return ", ".join(part for part in (f"{axle} {wheel.side}{sure}", where) if part)


def _beside_header(wheel: WheelDocument, claimed: dict[Quantity, float]) -> str:
    differences = {
        quantity: reading.value - claimed[quantity]
        for quantity, reading in wheel.readings.items()
        if quantity in claimed and reading.value is not None
    }
    said = ", ".join(f"{_SHORT[name]} {value:.3f}" for name, value in claimed.items())
    off = [
        f"{_SHORT[name]} {difference:+.3f}"
        for name, difference in differences.items()
        if abs(difference) > _BELONGS_MM
    ]
    if off:
        return f"header says {said}; the points read {', '.join(off)} mm: it may be another wheel's"
    return f"header says {said}, as the points do within {_BELONGS_MM:g} mm"


def _shown(reading: ReadingDocument) -> str:
    if reading.value is None:
        return "missing"
    return f"{reading.value:.3f} \u00b1 {reading.u95:.3f}"
