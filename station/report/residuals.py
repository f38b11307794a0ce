"""Residuals of all pictures together: by direction, by place in the picture, by size."""

import math
from collections.abc import Sequence

import numpy as np

from calib import FloatArray
from station.documents import CalibrationDocument
from station.report.drawing import Axes, line_through, needles, specks
from station.report.evidence import PictureEvidence, rms, whitened_dots, whitened_stripe
from station.report.markup import Markup, element, figure, number, section, table
from station.report.wording import count, figures, magnification, to_digit_of

_WIDTH = 400.0
_MOST_NEEDLES = 2000
_LONGEST_NEEDLE = 18.0
"""In units of the drawing, of 19 needles out of 20."""
_REACH = 4.0
"""The histograms reach from −4 σ to 4 σ."""
_BINS = 32


def residuals_section(document: CalibrationDocument, pictures: Sequence[PictureEvidence]) -> Markup:
    """Return the residuals of all pictures: a table, two maps, a scatter and two histograms."""
    dots_px, dots_by_px = _used(pictures, stripe=False)
    stripe_px, stripe_by_px = _used(pictures, stripe=True)
    return section(
        "Residuals of all pictures",
        element("p", "Deviation = observed − corrected, of the points used."),
        element(
            "div",
            _by_place(document, "Target points", dots_px, dots_by_px),
            _by_place(document, "Stripe points", stripe_px, stripe_by_px),
            _histogram("Target points, along u and v", whitened_dots(pictures)),
            _histogram("Stripe points, across the stripe", whitened_stripe(pictures)),
            _scatter(dots_by_px),
            _by_direction(dots_by_px, pictures),
            class_="drawings",
        ),
    )


def _used(pictures: Sequence[PictureEvidence], *, stripe: bool) -> tuple[FloatArray, FloatArray]:
    """Return places and deviations of the points used, both shape (N, 2), px."""
    sets = [picture.stripe if stripe else picture.dots for picture in pictures]
    none = np.empty((0, 2))
    return (
        np.vstack([none, *(points.seen_px[points.used] for points in sets)]),
        np.vstack([none, *(points.deviation_px[points.used] for points in sets)]),
    )


def _by_direction(dots_by_px: FloatArray, pictures: Sequence[PictureEvidence]) -> Markup:
    whitened = whitened_dots(pictures).reshape(-1, 2)
    across = [_along_normal(picture) for picture in pictures]
    rows = (
        _direction("Target, along u (right)", dots_by_px[:, 0], whitened[:, 0]),
        _direction("Target, along v (down)", dots_by_px[:, 1], whitened[:, 1]),
        _direction(
            "Stripe, across itself",
            np.concatenate([np.empty(0), *across]),
            whitened_stripe(pictures),
        ),
    )
    return table(("Direction", "Points", "Mean, px", "RMS, px", "RMS / predicted σ"), rows)


def _along_normal(picture: PictureEvidence) -> FloatArray:
    """Deviations of the used stripe points along their normals, px."""
    sigma_px = np.linalg.norm(picture.stripe.sigma_px[picture.stripe.used], axis=1)
    return np.asarray(whitened_stripe([picture]) * sigma_px)


def _direction(name: str, deviation_px: FloatArray, whitened: FloatArray) -> tuple[Markup, ...]:
    mean_px = float(deviation_px.mean()) if deviation_px.size else math.nan
    mean_sigma_px = rms(deviation_px) / math.sqrt(max(deviation_px.size, 1))
    return (
        element("th", name, scope="row"),
        number(str(deviation_px.size)),
        number(to_digit_of(mean_px, mean_sigma_px)),
        number(figures(rms(deviation_px))),
        number(figures(rms(whitened))),
    )


def _by_place(
    document: CalibrationDocument, name: str, places_px: FloatArray, deviation_px: FloatArray
) -> Markup:
    size = (float(document.camera.width), float(document.camera.height))
    axes = Axes.same_scale((0.0, size[0]), (0.0, size[1]), _WIDTH, down=True)
    factor = needle_factor(deviation_px, _LONGEST_NEEDLE / axes.scale)
    every = max(1, math.ceil(len(places_px) / _MOST_NEEDLES))
    starts = axes.at(places_px[::every])
    lengths = deviation_px[::every] * factor * axes.scale
    drawing = axes.drawing(
        f"{name}: deviations over the picture", "u, px", "v, px",
        element("path", d=needles(starts, lengths), class_="needles", stroke_width=1.0),
        element("path", d=specks(starts), class_="feet", stroke_width=2.0),
    )  # fmt: skip
    part = f" Every {every}th point is drawn." if every > 1 else ""
    caption = f"{name}: deviations over the picture, magnified × {factor:g}.{part}"
    return figure(drawing, caption)


def needle_factor(deviation_px: FloatArray, longest_px: float) -> float:
    """Return the magnification under which 19 of 20 deviations stay below a length."""
    if not len(deviation_px):
        return 1.0
    return magnification(float(np.percentile(np.linalg.norm(deviation_px, axis=1), 95)), longest_px)


def _scatter(deviation_px: FloatArray) -> Markup:
    lengths = np.linalg.norm(deviation_px, axis=1)
    reach = 2.0 * float(np.percentile(lengths, 90)) if lengths.any() else 1.0
    axes = Axes.same_scale((-reach, reach), (-reach, reach), 0.7 * _WIDTH, down=True)
    inside = axes.holds(deviation_px)
    drawn = deviation_px[inside][:: max(1, math.ceil(len(deviation_px) / _MOST_NEEDLES))]
    centre = axes.at(np.zeros((1, 2)))[0]
    circle = element(
        "circle", cx=centre[0], cy=centre[1], r=rms(lengths) * axes.scale, class_="rms"
    ) if lengths.size else ()  # fmt: skip
    drawing = axes.drawing(
        "Deviations of the target points by direction", "deviation along u, px",
        "deviation along v, px",
        element("path", d=specks(axes.at(drawn)), class_="specks"), circle,
    )  # fmt: skip
    beyond = int((~inside).sum())
    more = f" {count(beyond, 'point')} beyond the edge." if beyond else ""
    caption = f"Target points by direction. Circle: RMS length {figures(rms(lengths))} px.{more}"
    return figure(drawing, caption)


def _histogram(name: str, whitened: FloatArray) -> Markup:
    counts, edges = np.histogram(whitened, bins=_BINS, range=(-_REACH, _REACH))
    step = edges[1] - edges[0]
    density = counts / max(whitened.size, 1) / step
    axes = Axes((-_REACH, _REACH), (0.0, max(0.45, 1.1 * float(density.max()))), _WIDTH, 190.0)
    corners = np.column_stack([np.repeat(edges, 2)[1:-1], np.repeat(density, 2)])
    outline = np.vstack([[-_REACH, 0.0], corners, [_REACH, 0.0]])
    x = np.linspace(-_REACH, _REACH, 81)
    normal = np.column_stack([x, np.exp(-0.5 * x**2) / math.sqrt(2.0 * math.pi)])
    drawing = axes.drawing(
        f"{name}: histogram over the predicted σ", "deviation / predicted σ", "share per σ",
        element("path", d=line_through(axes.at(outline)), class_="histogram"),
        element("path", d=line_through(axes.at(normal)), class_="normal"),
    )  # fmt: skip
    beyond = whitened.size - int(counts.sum())
    caption = (
        f"{name}: {count(whitened.size, 'deviation')} over predicted σ, RMS "
        f"{figures(rms(whitened))}, {beyond} beyond ±{_REACH:g} σ. Line: N(0, 1), as true σ give."
    )
    return figure(drawing, caption)
