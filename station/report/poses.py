"""Every picture, worst first: its figures, and itself with what was seen in it."""

from collections.abc import Mapping, Sequence

from station.report.crops import Box, Crop
from station.report.evidence import PictureEvidence, PointSet
from station.report.markup import Markup, element, number, section, table
from station.report.overlay import deviations, legend, marks, overlay
from station.report.ranking import RankedPicture
from station.report.wording import figures

_OPEN = 3
"""Pictures that are unfolded when the page opens."""


def poses_section(
    ranked: Sequence[RankedPicture], boxes: Sequence[Box], crops: Mapping[str, Crop]
) -> Markup:
    """Return the table of all pictures, and a drawing of the first ones: of each that has a box."""
    parts = [
        _pose(place, each, box, crops.get(each.evidence.name))
        for place, (each, box) in enumerate(zip(ranked, boxes, strict=False))
    ]
    fewer = f" The {len(boxes)} worst are drawn below it." if len(boxes) < len(ranked) else ""
    words = (
        "First those left out, then those whose stripe was seen and not used, then by their RMS "
        "relative to that of all pictures: of target or stripe points, whichever is larger."
        f"{fewer}"
    )
    return section(
        "Pictures, worst first", marks(), element("p", words), _table(ranked), legend(), parts
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
    notes = [("Warning", words) for words in ranked.warnings]
    if not ranked.left_out:
        notes += [("Not used", _causes(picture)), ("Doubtful but used", _doubts(picture))]
    lines = [element("p", f"{title}: {words}.") for title, words in notes if words]
    panels = element("div", overlay(picture, box, crop), deviations(picture, box), class_="panels")
    enlarge = element("label", element("input", type="checkbox"), "enlarge × 3", class_="enlarge")
    return element(
        "details", summary, lines, enlarge, panels,
        class_="pose", open="" if place < _OPEN else None,
    )  # fmt: skip
