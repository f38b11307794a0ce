"""The head of the report: passed or failed, by which gates; what it is of and what went in."""

import math

from calib import Method
from station.documents import CalibrationDocument, Gate
from station.report.markup import Markup, element, join, number, section, table
from station.report.wording import count, figures

_DEMANDS = {
    "views_used": ("Pictures used", ""),
    "dots_sigma_scale": ("Scatter of the target points, times the predicted", ""),
    "stripe_sigma_scale": ("Scatter of the stripe points, times the predicted", ""),
    "sheet_sigma_mm": ("σ of the sheet, RMS over the stripe points seen", "mm"),
}
"""What a gate asks, and its unit; another one is shown under its own name."""

_METHODS = {
    Method.PREPLANAR.value: "light plane fitted to stripe points placed by each picture alone",
    Method.DEVIATION.value: "every point corrected within nine sigma, then the light plane fitted",
    Method.JOINT.value: "poses, light plane and camera most likely all together",
}


def verdict(document: CalibrationDocument) -> Markup:
    """Return whether the calibration may be used, and every gate with figure and limit."""
    failed = sum(not gate.passed for gate in document.quality.values())
    total = len(document.quality)
    if failed:
        said = f"Failed: {failed} of {count(total, 'gate')} not passed. Do not measure with it."
    else:
        said = f"Passed: {'all ' if total > 1 else ''}{count(total, 'gate')}."
    heads = ("", "Demand", "Figure", "Limit", "Against the limit")
    return element(
        "section",
        element("p", said, class_="verdict fail" if failed else "verdict pass"),
        table(heads, (_gate_row(name, gate) for name, gate in document.quality.items())),
    )


def _gate_row(name: str, gate: Gate) -> tuple[Markup, ...]:
    words, unit = _DEMANDS.get(name, (name.replace("_", " "), ""))
    space = " " if unit else ""
    bound = "at least" if _is_lower_limit(name, gate) else "at most"
    state = "passed" if gate.passed else "FAILED"
    mark = element("td", state, class_="state pass" if gate.passed else "state fail")
    demand = element("td", words, element("code", name, class_="key"))
    figure = number(f"{_plain(gate.value)}{space}{unit}")
    limit = number(f"{bound} {_plain(gate.limit)}{space}{unit}")
    return mark, demand, figure, limit, element("td", _bar(gate))


def _plain(value: float) -> str:
    """Return a whole number as it is, another one with three digits."""
    return f"{value:.0f}" if value == round(value, 0) else figures(value)


def _is_lower_limit(name: str, gate: Gate) -> bool:
    """Tell which side of its limit a gate passes on: its own figure does, save at the limit."""
    if math.isnan(gate.value) or gate.value == gate.limit:
        return name == "views_used"
    return gate.passed == (gate.value > gate.limit)


def _bar(gate: Gate) -> Markup:
    """Draw the figure as a bar, with a line at the limit in the middle of the scale."""
    share = gate.value / gate.limit if gate.limit else float("nan")
    # NaN, which fails every comparison, draws nothing.
    length = min(share, 2.0) * 50.0 if share >= 0.0 else 0.0
    return element(
        "svg",
        element("rect", x=0.0, y=3.0, width=100.0, height=8.0, class_="ground"),
        element("rect", x=0.0, y=3.0, width=length, height=8.0,
                class_="bar pass" if gate.passed else "bar fail"),
        element("path", d="M50 0v14", class_="limit"),
        viewBox="0 0 100 14",
        class_="gauge",
        role="img",
        aria_label=f"{figures(100.0 * share)} % of the limit",
    )  # fmt: skip


def identity(document: CalibrationDocument) -> Markup:
    """Return what was calibrated, when and how."""
    made = document.created.strftime("%d %B %Y, %H:%M UTC").lstrip("0")
    camera = "given" if document.options.get("camera_given") else "solved from the same pictures"
    how = _METHODS.get(document.method, "")
    facts = {
        "Sensor": document.sensor,
        "Calibrated": made,
        "Method": f"{document.method}: {how}" if how else document.method,
        "Target": str(document.options.get("target", "not named")),
        "Camera": f"{camera}, {document.camera.width} × {document.camera.height} px",
        "Pictures": f"{len(document.poses)} used, {len(document.left_out)} left out",
        "Residuals (RMS)": f"target points {figures(document.rms.dots_px)} px, "
        f"stripe {figures(document.rms.stripe_px)} px across itself",
        "Software": document.software,
    }
    pairs = ((element("dt", name), element("dd", text)) for name, text in facts.items())
    fingerprint = element("dd", element("code", document.fingerprint))
    return element("dl", pairs, element("dt", "Fingerprint (SHA-256)"), fingerprint)


def inputs(document: CalibrationDocument) -> Markup:
    """Return every file that went in, folded."""
    rows = (
        (element("td", each.name, class_="name"), element("td", element("code", each.sha256)))
        for each in document.inputs
    )
    title = f"{count(len(document.inputs), 'file')} went in"
    return element(
        "details", element("summary", title), table(("File", "SHA-256"), rows), class_="inputs"
    )


def warnings(document: CalibrationDocument) -> Markup:
    """Return what the reader should know before signing."""
    if not document.warnings:
        return join(())
    items = (element("li", text) for text in document.warnings)
    return section("Warnings", element("ul", items, class_="warnings"))


def signature() -> Markup:
    """Return the lines on which somebody signs on paper."""
    fields = (
        element("div", element("span", label)) for label in ("Checked by", "Date", "Signature")
    )
    return element("div", fields, class_="signature")
