"""A pass with an unexplained frame is never complete: every way a frame can go, in one table.

Ids are fed as a driver gives them; that a real stream gives such ids is shown elsewhere.
"""

from dataclasses import dataclass
from pathlib import Path

import pytest

from station.capture import CaptureReport
from station.capture.accounting import FrameAccount
from station.recording import Event, EventKind

GO_ON = None
"""In a list of arrivals: the camera was opened again."""


@dataclass(frozen=True)
class Case:
    """What arrives, what the controller counted, and how that adds up."""

    name: str
    arrivals: list
    triggered: int | None
    recorded: int
    lost: int = 0
    refused: int = 0
    repeated: int = 0
    complete: bool = False


def whole(*ids):
    return [(frame_id, None) for frame_id in ids]


CASES = [
    Case("all came", whole(1, 2, 3), 3, 3, complete=True),
    Case("all came and nobody counted", whole(1, 2, 3), None, 3, complete=True),
    Case("none was triggered and none came", [], 0, 0, complete=True),
    Case("none came of three", [], 3, 0, lost=3),
    Case("the first is lost", whole(2, 3), 3, 2, lost=1),
    Case("one in the middle is lost", whole(1, 3), 3, 2, lost=1),
    Case("one in the middle is lost and nobody counted", whole(1, 3), None, 2, lost=1),
    Case("the last is lost and the controller counted", whole(1, 2), 3, 2, lost=1),
    Case("one in the middle and the last are lost", whole(1, 3), 4, 2, lost=2),
    Case("one is incomplete", [*whole(1), (2, "missing packets"), *whole(3)], 3, 2, refused=1),
    Case("the last is incomplete", [*whole(1), (2, "timeout")], 2, 1, refused=1),
    Case("one without its id", [*whole(1), (None, "timeout"), *whole(3)], 3, 2, lost=1),
    Case("the last without its id", [*whole(1), (None, "timeout")], 2, 1, lost=1),
    Case("the last without its id, nobody counted", [*whole(1), (None, "timeout")], None, 1),
    Case("one came twice", whole(1, 2, 2, 3), 3, 3, repeated=1, complete=True),
    Case("one came late", whole(1, 3, 2, 4), 4, 3, lost=1, repeated=1),
    Case("more came than were triggered", whole(1, 2, 3), 2, 3),
    Case("16-bit ids wrap", whole(65534, 65535, 1, 2), 4, 4, complete=True),
    Case("one is lost at the wrap", whole(65534, 1), 3, 2, lost=1),
    Case("the last before the wrap and the first after", whole(65534, 2), 4, 2, lost=2),
    Case("64-bit ids go on beyond 65535", whole(65534, 65535, 65536, 65537), 4, 4, complete=True),
    Case("one is lost at the edge of 16 bits", whole(65535, 65537), 3, 2, lost=1),
    Case("64-bit ids far on", whole(2**33, 2**33 + 1), 2, 2, complete=True),
    Case("one is lost far on", whole(2**33, 2**33 + 2), 3, 2, lost=1),
    Case("ids begin late and nobody counted", whole(40000, 40001), None, 2),
    Case("ids begin late and the count is right", whole(40000, 40001), 2, 2, complete=True),
    Case("ids begin late and the controller counted more", whole(40000, 40001), 3, 2, lost=1),
    Case("opened again, nothing missed", [*whole(1, 2), GO_ON, *whole(1, 2)], 4, 4),
    Case("opened again, one missed", [*whole(1, 2), GO_ON, *whole(1, 2)], 5, 4, lost=1),
    Case("opened again, its first lost", [*whole(1), GO_ON, *whole(2)], 3, 2, lost=1),
]


def account_for(case):
    events = []
    account = FrameAccount(lambda: 1, events.append)
    for arrival in case.arrivals:
        if arrival is GO_ON:
            events.append(Event(EventKind.CAMERA_LOST, 1))
            account.begin_again()
            events.append(Event(EventKind.CAMERA_BACK, 1))
        elif account.arrive(*arrival):
            account.confirm()
    account.close(case.triggered)
    return CaptureReport(
        path=Path("/a.mcap"),
        triggered=case.triggered,
        recorded=account.recorded,
        lost=account.lost,
        refused=account.refused,
        repeated=account.repeated,
        resent_packets=0,
        first_time_ns=None,
        last_time_ns=None,
        events=tuple(events),
    )


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_frames_add_up(case):
    report = account_for(case)
    found = (report.recorded, report.lost, report.refused, report.repeated)
    assert found == (case.recorded, case.lost, case.refused, case.repeated)
    assert report.complete is case.complete


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_complete_means_that_every_trigger_is_a_recorded_frame_without_a_word_against_it(case):
    report = account_for(case)
    accounted = report.recorded + report.lost + report.refused
    if report.complete:
        assert report.triggered in {None, report.recorded}
        assert accounted == report.recorded
    elif case.triggered is not None and case.triggered >= accounted:
        assert accounted == case.triggered
    if accounted != case.recorded or report.triggered not in {None, report.recorded}:
        assert report.events, "a difference that nothing says"


@pytest.mark.parametrize("kind", EventKind)
def test_a_kind_of_event_is_against_completeness_or_is_known_to_be_harmless(kind):
    harmless = {
        EventKind.STARTED,
        EventKind.FINISHED,
        EventKind.FRAME_REPEATED,
        EventKind.PACKETS_RESENT,
        EventKind.RING_FULL,
        EventKind.CAMERA_BACK,
        EventKind.CLOCK_MISSING,
        EventKind.CLOCK_SET,
        EventKind.PACKET_SIZE,
        EventKind.RECEIVE_BUFFER,
        EventKind.EXPOSED,
        EventKind.RECORDER_RESTARTED,
    }
    report = CaptureReport(Path("/a"), None, 1, 0, 0, 0, 0, None, None, (Event(kind, 1),))
    assert report.complete is (kind in harmless or _tells_of_no_loss(kind))


def _tells_of_no_loss(kind):
    """Kinds that others add say by their place outside LOSSES that they are harmless."""
    return str(kind).startswith("continued")
