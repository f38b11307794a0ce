"""Shows that a read that brings a body is held to the same limits as a change, and that one without
is not made to wait for it.  What a body may be is shown elsewhere."""

import pytest

TOO_MUCH = b"x" * 2_000_000


@pytest.mark.parametrize(
    "body", [TOO_MUCH, iter([TOO_MUCH])], ids=["of said length", "in pieces of unsaid length"]
)
def test_a_read_with_a_body_that_is_too_large_is_refused(call, body):
    reply = call.request("GET", "/v1/recordings", content=body)
    assert reply.status_code == 413
    assert "bytes at most" in reply.json()["detail"]


def test_a_read_with_a_small_body_is_answered_as_one_without(call):
    with_body = call.request("GET", "/v1/recordings", content=b"{}")
    assert with_body.status_code == 200
    assert with_body.json() == call.get("/v1/recordings").json()
