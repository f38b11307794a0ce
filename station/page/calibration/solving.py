"""How far a solve is, which a page asks for until it has ended."""

from fastapi import Request, Response

from station.page.calibration.report import Report
from station.page.shell import Shell


def solving_answer(request: Request, shell: Shell, report: Report) -> Response:
    """Return the part of the page; once the solve has ended, the whole page is loaded anew."""
    answer = shell.page(request, "calibration/solving.html", report=report)
    if not report.solving:
        answer.headers["HX-Refresh"] = "true"
    return answer
