"""What was not used, and why."""

from collections import Counter
from collections.abc import Mapping, Sequence

from station.documents import CalibrationDocument
from station.report.crops import Crop
from station.report.evidence import PictureEvidence
from station.report.markup import Markup, element, figure, join, number, section, table
from station.report.ranking import reason_without_name
from station.report.wording import count


def left_out_section(
    document: CalibrationDocument,
    pictures: Sequence[PictureEvidence],
    crops: Mapping[str, Crop],
) -> Markup:
    """Return pictures left out with their reasons, and the causes of points not used."""
    return section("Left out", _pictures(document, crops), _points(pictures))


def _pictures(document: CalibrationDocument, crops: Mapping[str, Crop]) -> Markup:
    if not document.left_out:
        return element("p", "No picture was left out.")
    rows = (
        (element("td", name, class_="name"), reason_without_name(document, name))
        for name in document.left_out
    )
    shown = [
        figure(
            element("img", src=crops[name].url, alt=f"the picture {name}"),
            element("span", name, class_="name"),
        )
        for name in document.left_out
        if name in crops
    ]
    whole = element("div", shown, class_="thumbnails") if shown else join(())
    return join([table(("Picture", "Why"), rows), whole])


def _points(pictures: Sequence[PictureEvidence]) -> Markup:
    solved = [picture for picture in pictures if picture.solved]
    kinds = (
        ("target points", [picture.dots for picture in solved]),
        ("stripe points", [picture.stripe for picture in solved]),
    )
    rows = [
        (reason, kind, number(str(each)))
        for kind, sets in kinds
        for reason, each in sum((points.unused_by_reason for points in sets), Counter[str]())
        .most_common()
    ]  # fmt: skip
    seen = sum(len(points) for _, sets in kinds for points in sets)
    unused = sum(int((~points.used).sum()) for _, sets in kinds for points in sets)
    line = f"In the pictures used, {unused} of {count(seen, 'point')} took no part."
    causes = table(("Cause", "Of", "Points"), rows) if rows else join(())
    return join([element("p", line), causes])
