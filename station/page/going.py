"""Going on to another page after a button was pressed."""

from typing import Final

from fastapi import Response

REDIRECT: Final = "HX-Redirect"
"""Names the page to load as a whole: its scripts run then.

Of a page that is put in place of the body of another (`HX-Location`) they would not.
"""


def go_to(address: str) -> Response:
    """Return the answer that loads a page."""
    return Response(status_code=204, headers={REDIRECT: address})
