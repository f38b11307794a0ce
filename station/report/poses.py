"""Every picture, worst first: its figures, and itself with what was seen in it."""

from collections.abc import Mapping, Sequence

import numpy as np

from calib import FloatArray
from station.report.crops import Box, Crop
from station.report.drawing import line_through, needles, specks
from station.report.evidence import PictureEvidence, PointSet
from station.report.markup import Markup, element, figure, join, number, section, table
from station.report.ranking import RankedPicture
from station.report.residuals import needle_factor
from station.report.wording import figures

_OPEN = 3


def poses_section(
    ranked: Sequence[RankedPicture], boxes: Mapping[str, Box], crops: Mapping[str, Crop]
) -> Markup:
    """Return the table of all pictures, and a part for each one that has a box."""
    shown = [each for each in ranked if each.evidence.name in boxes]
    parts = [
        _pose(place, each, boxes[each.evidence.name], crops.get(each.evidence.name))
        for place, each in enumerate(shown)
    ]
    fewer = f" The {len(shown)} worst are drawn below it." if len(shown) < len(ranked) else ""
    words = (
        "First those left out, then those whose stripe was seen and not used, then by their RMS "
        "relative to that of all pictures: of target or stripe points, whichever is larger."
        f"{fewer}"
    )
    return section(
        "Pictures, worst first", _marks(), element("p", words), _table(ranked), _legend(), parts
    )


def _table(ranked: Sequence[RankedPicture]) -> Markup:
    heads = (
        "Picture", "Target points used", "RMS, px", "Stripe points used", "RMS, px",
        "Distance, mm", "Tilt, °", "Relative", "Not used, by cause",
    )  # fmt: skip
    return table(heads, (_row(each) for each in ranked))


def _row(ranked: RankedPicture) -> tuple[Markup, ...]:
    picture = ranked.evidence
    return (
        element("td", picture.name, class_="name"),
        number(_used_of(picture.dots)),
        number(figures(picture.dots.rms_px)),
        number(_used_of(picture.stripe)),
        number(figures(picture.stripe.rms_px)),
        number(figures(ranked.distance_mm, 4)),
        number(figures(ranked.tilt_deg, 3)),
        number(f"× {figures(ranked.disagreement, 2)}" if not ranked.left_out else "left out"),
        element("td", ranked.left_out or _causes(picture) or "–"),
    )


def _used_of(points: PointSet) -> str:
    return f"{int(points.used.sum())} of {len(points)}" if len(points) else "none seen"


def _causes(picture: PictureEvidence) -> str:
    parts = [
        f"{each} {kind}: {reason}"
        for kind, points in (("target", picture.dots), ("stripe", picture.stripe))
        for reason, each in points.unused_by_reason.most_common()
    ]
    return ", ".join(parts)


def _doubts(picture: PictureEvidence) -> str:
    """Name the causes for which points were doubted and used all the same."""
    parts = []
    for kind, points in (("target", picture.dots), ("stripe", picture.stripe)):
        doubted = [reason for reason, used in zip(points.reason, points.used, strict=True) if used]
        parts += [
            f"{doubted.count(reason)} {kind}: {reason}" for reason in sorted({*doubted} - {""})
        ]
    return ", ".join(parts)


def _pose(place: int, ranked: RankedPicture, box: Box, crop: Crop | None) -> Markup:
    picture = ranked.evidence
    kinds = (("target", picture.dots), ("stripe", picture.stripe))
    parts = (
        f"{kind} {figures(points.rms_px)} px RMS" if points.used.any() else f"{kind} not used"
        for kind, points in kinds
    )
    brief = f"left out: {ranked.left_out}" if ranked.left_out else ", ".join(parts)
    summary = element(
        "summary", element("span", picture.name, class_="name"), element("span", brief)
    )
    lines = [f"Warning: {words}." for words in ranked.warnings]
    lines += [
        f"{title}: {words}."
        for title, words in (
            ("Not used", _causes(picture)),
            ("Doubtful but used", _doubts(picture)),
        )
        if words
    ]
    panels = element(
        "div", _overlay(picture, box, crop), _deviations(picture, box), class_="panels"
    )
    enlarge = element("label", element("input", type="checkbox"), "enlarge × 3", class_="enlarge")
    return element(
        "details", summary, [element("p", line) for line in lines], enlarge, panels,
        class_="pose", open="" if place < _OPEN else None,
    )  # fmt: skip


def _overlay(picture: PictureEvidence, box: Box, crop: Crop | None) -> Markup:
    """Draw the picture with every point where it was seen and where it belongs."""
    ground = element("rect", x=box.left - 0.5, y=box.top - 0.5, width=float(box.width),
                     height=float(box.height), class_="no-picture")  # fmt: skip
    words = "No picture: calibrated from points, or not to be told from another of its name."
    if crop is not None:
        ground = element(
            "image", x=box.left - 0.5, y=box.top - 0.5, width=float(box.width),
            height=float(box.height), preserveAspectRatio="none", href=crop.url,
        )  # fmt: skip
        brighter = f", shown {figures(crop.gain, 2)} × brighter" if crop.gain > 1.05 else ""
        words = f"As taken{brighter}."
    marks = [
        _points_drawn(points, kind, box)
        for kind, points in (("dot", picture.dots), ("line", picture.stripe))
    ]
    drawing = element(
        "svg", ground, marks, viewBox=box.view_box, role="img",
        aria_label=f"{picture.name}: points seen and corrected",
    )  # fmt: skip
    return figure(element("div", drawing, class_="window"), words)


def _points_drawn(points: PointSet, kind: str, box: Box) -> Markup:
    """Draw seen points, corrected ones over them, and a ring about those that were not used."""
    width = box.width / 480.0
    known = np.isfinite(points.corrected_px).all(axis=1)
    layers = [
        _marked(points.seen_px, f"seen-{kind}", width),
        _marked(points.corrected_px[known], f"corrected-{kind}", width),
    ]
    rings = [
        element(
            "circle", element("title", points.reason[i] or "not used"),
            cx=f"{points.seen_px[i, 0]:.1f}", cy=f"{points.seen_px[i, 1]:.1f}", r=9.0 * width,
            stroke_width=1.2 * width,
        )
        for i in np.flatnonzero(~points.used)
    ]  # fmt: skip
    return join([*layers, element("g", rings, class_="unused")])


def _marked(points_px: FloatArray, mark: str, width: float) -> Markup:
    if not len(points_px):
        return join(())
    url = f"url(#{mark})"
    return element(
        "path", d=line_through(points_px), fill="none", stroke="none", stroke_width=width,
        marker_start=url, marker_mid=url, marker_end=url,
    )  # fmt: skip


def _deviations(picture: PictureEvidence, box: Box) -> Markup:
    """Draw the deviations magnified, used ones and others apart."""
    parts, words = [], []
    for name, points in (("target points", picture.dots), ("stripe points", picture.stripe)):
        used = points.used
        factor = needle_factor(points.deviation_px[used], 0.05 * box.width)
        starts, lengths = points.corrected_px[used], points.deviation_px[used] * factor
        parts += [
            element("path", d=specks(starts), class_="feet", stroke_width=box.width / 160.0),
            element("path", d=needles(starts, lengths), class_="needles",
                    stroke_width=box.width / 400.0),
        ]  # fmt: skip
        words += [f"{name} × {factor:g}"] if used.any() else []
    ground = element("rect", x=box.left - 0.5, y=box.top - 0.5, width=float(box.width),
                     height=float(box.height), class_="no-picture")  # fmt: skip
    drawing = element(
        "svg", ground, parts, viewBox=box.view_box, role="img",
        aria_label=f"{picture.name}: deviations magnified",
    )  # fmt: skip
    caption = "Deviations of the points used, from the corrected point: " + ", ".join(words)
    if not words:
        caption = "No point of it was used"
    return figure(element("div", drawing, class_="window"), f"{caption}.")


def _marks() -> Markup:
    """Return the shapes of the marks, once for all drawings."""
    shapes = {
        "seen-dot": "M-6 0h12M0-6v12",
        "corrected-dot": "M-4-4l8 8M-4 4l8-8",
        "seen-line": "M-3 0h6M-1.5-2.6l3 5.2M-1.5 2.6l3-5.2",
        "corrected-line": "M-2 0h4M-1-1.7l2 3.4M-1 1.7l2-3.4",
    }
    markers = [
        element("marker", element("path", d=shape, class_=name.split("-")[0]), id=name,
                viewBox="-7 -7 14 14", markerWidth=14.0, markerHeight=14.0)
        for name, shape in shapes.items()
    ]  # fmt: skip
    return element("svg", element("defs", markers), width=0.0, height=0.0, class_="marks")


def _legend() -> Markup:
    entries = (
        ("seen", "M-6 0h12M0-6v12", "target point as seen"),
        ("corrected", "M-4-4l8 8M-4 4l8-8", "corrected"),
        ("seen", "M-5 0h10M-2.5-4.3l5 8.6M-2.5 4.3l5-8.6", "stripe point as seen"),
        ("corrected", "M-4 0h8M-2-3.4l4 6.8M-2 3.4l4-6.8", "corrected"),
    )
    items = [
        element("span", element("svg", element("path", d=shape, class_=class_),
                                viewBox="-8 -8 16 16", class_="key-mark"), words)
        for class_, shape, words in entries
    ]  # fmt: skip
    ring = element("svg", element("g", element("circle", cx=0.0, cy=0.0, r=6.0), class_="unused"),
                   viewBox="-8 -8 16 16", class_="key-mark")  # fmt: skip
    items.append(element("span", ring, "not used (the cause under the pointer)"))
    return element("p", items, class_="legend")
