"""Shows when the client makes a call again, with what and how long; the answers are played."""

import json

import httpx
import pytest

from station.client import CallRefused, Connection, Patience, StationUnreachable
from station.client.following import follow

PROBLEM = "urn:treadline:problem:"


class Played:
    """A station that answers as it is told, and a clock that moves only while somebody sleeps."""

    def __init__(self, *answers):
        self.answers = list(answers)
        self.asked = []
        self.slept = []
        self.now_s = 0.0

    def handle(self, request):
        self.asked.append(request)
        answer = self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]
        if isinstance(answer, Exception):
            raise answer
        return answer

    def sleep(self, seconds):
        self.slept.append(seconds)
        self.now_s += seconds

    def connection(self, patience=None):
        http = httpx.Client(base_url="http://station", transport=httpx.MockTransport(self.handle))
        return Connection(
            http,
            patience or Patience(),
            clock=lambda: self.now_s,
            sleep=self.sleep,
            chance=lambda: 1.0,
        )


def refusal(status, name, detail="no", **headers):
    body = {"type": PROBLEM + name, "detail": detail, "status": status}
    return httpx.Response(status, json=body, headers=headers)


DONE = httpx.Response(200, json={"state": "done"})
CUT = httpx.ReadError("cut off")


@pytest.mark.parametrize(
    "first",
    [
        CUT,
        httpx.ConnectError("refused"),
        httpx.ReadTimeout("silent"),
        refusal(503, "StoreUnusable"),
        refusal(503, "CameraUnreachable"),  # the same PUT arms again
        refusal(429, "TooManyBadKeys"),
        refusal(409, "CallInProgress"),
        httpx.Response(503, text="<html>a proxy's own</html>"),
    ],
    ids=lambda each: type(each).__name__,
)
def test_a_call_that_may_yet_be_taken_is_made_again(first):
    played = Played(first, first, DONE)
    assert played.connection().call("GET", "/x") == {"state": "done"}
    assert played.slept == [0.1, 0.2]


@pytest.mark.parametrize(
    "answer",
    [
        refusal(409, "StateConflict"),
        refusal(422, "InputUnusable"),
        refusal(401, "KeyRefused"),
        refusal(500, "InternalError"),
    ],
    ids=lambda each: each.json()["type"].removeprefix(PROBLEM),
)
def test_a_refusal_that_stays_one_is_raised_at_once_with_its_problem(answer):
    played = Played(answer)
    with pytest.raises(CallRefused, match="no") as refused:
        played.connection().call("PUT", "/x", {})
    assert refused.value.status == answer.status_code
    assert refused.value.problem == answer.json()
    assert played.slept == []


def test_every_try_of_a_post_has_the_same_key_and_every_post_its_own():
    played = Played(CUT, DONE, DONE)
    connection = played.connection()
    connection.call("POST", "/x", {"axles": 4})
    connection.call("POST", "/x", {"axles": 4})
    first, again, other = (request.headers["Idempotency-Key"] for request in played.asked)
    assert first == again
    assert other != first
    assert [json.loads(request.content) for request in played.asked] == [{"axles": 4}] * 3


def test_a_put_and_a_get_carry_no_key():
    played = Played(DONE)
    for method in ("GET", "PUT"):
        played.connection().call(method, "/x")
    assert all("Idempotency-Key" not in request.headers for request in played.asked)


def test_the_pause_is_the_one_that_the_station_asks_for():
    played = Played(refusal(503, "StoreUnusable", **{"Retry-After": "7"}), DONE)
    played.connection().call("GET", "/x")
    assert played.slept == [7.0]


def test_pauses_grow_to_the_longest_and_end_with_the_patience():
    played = Played(httpx.ConnectError("refused"))
    with pytest.raises(StationUnreachable, match="http://station: refused; is the station running"):
        played.connection(Patience(within_s=10.0, longest_s=2.0)).call("GET", "/x")
    assert played.slept == [0.1, 0.2, 0.4, 0.8, 1.6, 2.0, 2.0, 2.0]
    assert len(played.asked) == len(played.slept) + 1


def test_what_the_station_refused_last_is_said_when_the_patience_is_over():
    played = Played(refusal(503, "StoreUnusable", "busy for too long"))
    with pytest.raises(CallRefused, match="busy for too long"):
        played.connection(Patience(within_s=0.0)).call("GET", "/x")
    assert len(played.asked) == 1


def test_a_body_in_pieces_is_sent_whole_each_time():
    played = Played(CUT, DONE)
    seen = []

    def handle(request):
        seen.append(request.read())
        return Played.handle(played, request)

    played_handle = httpx.MockTransport(handle)
    http = httpx.Client(base_url="http://station", transport=played_handle)
    connection = Connection(http, Patience(), sleep=played.sleep)
    connection.send("POST", "/x", content=lambda: iter([b"ab", b"c"]))
    assert seen == [b"abc", b"abc"]


def events(*jobs, cut=False):
    lines = [b": hello\n"] + [f"event: job\ndata: {json.dumps(job)}\n\n".encode() for job in jobs]

    def stream():
        yield from lines
        if cut:
            raise CUT

    return httpx.Response(200, content=stream())


def test_a_job_is_followed_over_lost_connections_and_nothing_is_told_twice():
    begun, half = {"state": "running", "progress": 0.1}, {"state": "running", "progress": 0.5}
    done = {"state": "done", "progress": 1.0}
    played = Played(
        events(begun, half, cut=True), httpx.ConnectError("down"), events(half), events(done)
    )
    assert list(follow(played.connection(), "/x")) == [begun, half, done]
    assert len(played.asked) == 4


def test_following_what_there_is_not_is_refused():
    with pytest.raises(CallRefused, match="HTTP 404: no such job"):
        list(follow(Played(refusal(404, "NotFound", "no such job")).connection(), "/x"))


@pytest.mark.parametrize("wrong", [{"within_s": -1.0}, {"first_s": 0.0}, {"longest_s": 0.01}])
def test_a_patience_that_never_ends_or_begins_is_refused(wrong):
    with pytest.raises(ValueError, match="within_s >= 0"):
        Patience(**wrong)
