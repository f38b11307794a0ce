"""Going on to another page after a button was pressed."""

from fastapi import Response


def go_to(address: str) -> Response:
    """Return the answer that loads a page as a whole.

    Its scripts run then; of a page that is put in place of the body of another they would not.
    """
    return Response(status_code=204, headers={"HX-Redirect": address})
