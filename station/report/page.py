"""The page as a whole."""

from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

from station.documents import CalibrationDocument
from station.report.crops import Box, crops_of
from station.report.evidence import evidence_of
from station.report.left_out import left_out_section
from station.report.markup import Markup, element, join
from station.report.poses import poses_section
from station.report.ranking import worst_first
from station.report.residuals import residuals_section
from station.report.sensor_section import sensor_section
from station.report.sheet_map import sheet_map
from station.report.verdict import identity, inputs, signature, verdict, warnings

MOST_PICTURES = 40
"""Pictures drawn at most: of 1000 the worst are looked at, and the page still opens."""

MOST_THUMBNAILS = 12


def calibration_report(
    document: CalibrationDocument, points_csv: str, sources: Sequence[Path] = ()
) -> str:
    """Draw the report of a calibration as one self-contained HTML page.

    Parameters
    ----------
    document
        calibration.json.
    points_csv
        The text of points.csv that belongs to it.
    sources
        The pictures or recordings it was calibrated from; they are read again, one picture at a
        time. Without them the page has no pictures.

    Raises
    ------
    InputUnusable
        If a source cannot be used.
    RecordingUnreadable
        If a recording is damaged.
    """
    pictures = evidence_of(points_csv)
    ranked = worst_first(document, pictures)
    drawn = [each.evidence for each in ranked[:MOST_PICTURES]]
    size = document.camera.width, document.camera.height
    boxes = [Box.around(picture, *size) for picture in drawn]
    by_name = dict(zip((picture.name for picture in drawn), boxes, strict=True))
    never_solved = [name for name in document.left_out if name not in by_name]
    crops = crops_of(sources, by_name, frozenset(never_solved[:MOST_THUMBNAILS]))
    return _page(
        document.sensor,
        element("header", element("p", "Calibration report", class_="kind"),
                element("h1", document.sensor)),
        verdict(document),
        element("section", identity(document), signature(), inputs(document)),
        warnings(document),
        left_out_section(document, pictures, crops),
        sensor_section(document),
        sheet_map(document, pictures),
        residuals_section(document, pictures),
        poses_section(ranked, boxes, crops),
    )  # fmt: skip


def _page(title: str, *parts: Markup) -> str:
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("meta", name="color-scheme", content="light dark"),
        element("title", f"Calibration of {title}"),
        # Our own file, not input: the one text besides elements that is not escaped.
        element("style", Markup(files("station.report").joinpath("page.css").read_text("utf-8"))),
    )
    body = element("body", element("main", parts))
    return join([Markup("<!doctype html>\n"), element("html", head, body, lang="en")]) + "\n"
