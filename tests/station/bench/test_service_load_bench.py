"""Shows that the bench of calls makes them when they are due, counts those that fail, and finds its
way through a station that records and measures.  A short and slow load: the times are no claims."""

import asyncio
import threading
import time

import pytest

from station.bench import BENCHES
from station.bench.service.load import _Findings, _table, _Window, bench_service, calls_of
from station.bench.service.open_loop import Answered, Call, Driven, Load, drive
from station.progress import silent

ANSWER = b"HTTP/1.1 200 OK\r\ncontent-length: 2\r\n\r\n{}"
REFUSAL = b"HTTP/1.1 503 Busy\r\ncontent-length: 0\r\n\r\n"
CALLS = (Call("get", "GET", "/a", 3.0), Call("put", "PUT", "/b", 1.0, body="{}"))
STALL_S = 0.4


class Server:
    """Answers each call as it is told to, from a thread of its own."""

    def __init__(self, answer):
        self._answer = answer
        self.heads = []
        self._loop = asyncio.new_event_loop()
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._loop.run_until_complete, args=(self._run(),))

    def __enter__(self):
        self._thread.start()
        assert self._ready.wait(10.0)
        return self

    def __exit__(self, *_):
        self._loop.call_soon_threadsafe(self._end.set)
        self._thread.join(10.0)
        self._loop.close()

    async def _run(self):
        self._end = asyncio.Event()
        server = await asyncio.start_server(self._serve, "127.0.0.1", 0)
        self.port = server.sockets[0].getsockname()[1]
        self._ready.set()
        await self._end.wait()
        server.close()

    async def _serve(self, reader, writer):
        try:
            while True:
                head = await reader.readuntil(b"\r\n\r\n")
                if b"Content-Length: 2" in head:
                    await reader.readexactly(2)
                self.heads.append(head)
                answer = await self._answer(len(self.heads))
                if answer is None:
                    break
                writer.write(answer)
        except (asyncio.IncompleteReadError, ConnectionError):
            pass
        finally:
            writer.close()

    def load(self, rate_hz, seconds):
        return Load(self.port, "the-key", CALLS, rate_hz, seconds)


async def at_once(_):
    return ANSWER


def test_every_call_is_made_with_its_key_and_answered():
    with Server(at_once) as server:
        driven = drive(server.load(200.0, 0.5))
    assert len(driven.answers) == len(server.heads) == 100
    assert {each.status for each in driven.answers} == {200}
    assert all(b"Authorization: Bearer the-key" in head for head in server.heads)
    puts = [each for each in driven.answers if each.name == "put"]
    # Of 98 draws with a chance of a quarter: five sigmas of 4.3 about 25; and the first of them.
    assert 4 <= len(puts) <= 48
    assert driven.took_s >= 0.25


def test_a_stall_counts_for_every_call_that_was_due_while_it_lasted():
    first_s = []

    async def stalled(_):
        first_s.append(time.monotonic())
        await asyncio.sleep(max(0.0, first_s[0] + STALL_S - time.monotonic()))
        return ANSWER

    with Server(stalled) as server:
        # 80 calls in 0.2 s: more than there are connections, so some wait to be sent.
        driven = drive(server.load(400.0, 0.2))
    assert len(driven.answers) == 80
    waited = [each for each in driven.answers if each.sent_late_ms > 50.0]
    assert waited
    assert all(each.took_ms >= each.sent_late_ms for each in waited)
    assert max(each.took_ms for each in driven.answers) >= 1e3 * STALL_S


def test_calls_that_are_refused_or_cut_off_are_told_apart_from_answered_ones():
    async def in_turn(number):
        return (ANSWER, REFUSAL, None)[min(number - 1, 2)]

    with Server(in_turn) as server:
        driven = drive(server.load(50.0, 0.2))
    assert [each.status for each in driven.answers] == [200, 503] + [0] * 8


def window(took_ms=5.0, status=200):
    answers = [
        Answered(call.name, status, took_ms, 0.0) for call in calls_of("", "") for _ in range(3)
    ]
    return _Window(Driven(tuple(answers), 0.1, 2.0), {"API": 0.5})


def table_of(busy, late_s=(0.4, 0.6)):
    calm, recording = window(), {"recorded": 107, "lost": 0, "refused": 0}
    found = _Findings(calm, busy, calm, calm, [20.0], late_s, [0.5], recording, trains=1)
    return _table(found, 2.0, 200.0)


def test_the_bench_is_found_by_its_name():
    assert BENCHES["service"] == (bench_service,)


def test_what_is_asked_holds_where_all_calls_and_readings_come_in_time():
    table = table_of(window())
    assert [row["holds"] for row in table.rows] == [True] * 9
    kinds = [row["what"] for row in table.rows[1:-1]]
    assert kinds == [call.name for call in calls_of("", "")]
    gets = [row["count"] for row in table.rows[1:-1] if row["what"].startswith("GET")]
    assert (table.rows[0]["what"], table.rows[0]["count"]) == ("GET, all", sum(gets))
    assert table.rows[-1]["max"] == 600.0
    assert any("107 frames, lost 0" in note for note in table.notes)
    assert any("API 25" in note for note in table.notes)


def test_a_late_call_breaks_what_is_asked_of_its_kind():
    rows = {row["what"]: row["holds"] for row in table_of(window(took_ms=30.0)).rows}
    assert rows.pop("PUT pass, again")
    assert rows.pop("a wheel's last frame to its reading")
    assert not any(rows.values())


def test_a_call_that_fails_breaks_what_is_asked_however_soon_it_was_refused():
    rows = table_of(window(took_ms=1.0, status=503)).rows
    assert [row["holds"] for row in rows] == [False] * 8 + [True]
    assert [row["failed"] for row in rows] == [18, *[3] * 7, 0]


@pytest.mark.parametrize("late_s", [[0.4, 1.1], []], ids=["one late", "none at all"])
def test_a_reading_that_is_late_or_never_comes_breaks_what_is_asked(late_s):
    assert not table_of(window(), late_s).rows[-1]["holds"]


@pytest.mark.slow  # some 15 s of two quiet cores: all processes of a station start
def test_the_bench_calls_a_station_that_records_and_measures_and_nothing_fails():
    table = bench_service(silent, seconds=2.0, rate_hz=20.0, wheels=2)
    calls, (reading,) = table.rows[:-1], table.rows[-1:]
    assert [row["what"] for row in calls] == [call.name for call in calls_of("", "")]
    assert sum(row["count"] for row in calls) == 40
    assert [row["failed"] for row in table.rows] == [0] * 8
    assert reading["asked"] == "max <= 1000"
    recorded = next(note for note in table.notes if note.startswith("Recorded: "))
    assert int(recorded.split()[1]) > 0
    processors = next(note for note in table.notes if note.startswith("Processors"))
    for part in ("camera", "capture", "recorder", "API", "worker and its pool", "who calls"):
        assert f"{part} " in processors
    assert all(0.0 < row["p50"] <= row["p99"] <= row["max"] for row in calls)
