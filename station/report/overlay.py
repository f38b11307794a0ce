"""One picture with what was seen in it and where it belongs, and its deviations magnified."""

import numpy as np

from calib import FloatArray
from station.report.crops import Box, Crop
from station.report.drawing import line_through, needles, specks
from station.report.evidence import PictureEvidence, PointSet
from station.report.markup import Markup, element, figure, join
from station.report.residuals import needle_factor
from station.report.wording import figures

_MARKS_ACROSS = 480.0
"""Units of marks across a picture: marks look alike in pictures of all sizes."""


def overlay(picture: PictureEvidence, box: Box, crop: Crop | None) -> Markup:
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
    drawn = [
        _points_drawn(points, kind, box)
        for kind, points in (("dot", picture.dots), ("line", picture.stripe))
    ]
    drawing = element(
        "svg", ground, drawn, viewBox=box.view_box, role="img",
        # The unit of marks; the style divides it where the picture is enlarged.
        style=f"--mark:{box.width / _MARKS_ACROSS:.4g}px",
        aria_label=f"{picture.name}: points seen and corrected",
    )  # fmt: skip
    return figure(element("div", drawing, class_="window"), words)


def _points_drawn(points: PointSet, kind: str, box: Box) -> Markup:
    """Draw seen points, corrected ones over them, and a ring about those that were not used."""
    width = box.width / _MARKS_ACROSS
    known = np.isfinite(points.corrected_px).all(axis=1)
    layers = [
        _marked(points.seen_px, f"seen-{kind}"),
        _marked(points.corrected_px[known], f"corrected-{kind}"),
    ]
    rings = [
        element(
            "circle", element("title", points.reason[i] or "not used"),
            cx=f"{points.seen_px[i, 0]:.1f}", cy=f"{points.seen_px[i, 1]:.1f}", r=9.0 * width,
        )
        for i in np.flatnonzero(~points.used)
    ]  # fmt: skip
    return join([*layers, element("g", rings, class_="unused")])


def _marked(points_px: FloatArray, mark: str) -> Markup:
    if not len(points_px):
        return join(())
    url = f"url(#{mark})"
    return element(
        "path", d=line_through(points_px), fill="none", stroke="none", class_="marked",
        marker_start=url, marker_mid=url, marker_end=url,
    )  # fmt: skip


def deviations(picture: PictureEvidence, box: Box) -> Markup:
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


def marks() -> Markup:
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


def legend() -> Markup:
    """Return what the marks mean."""
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
