"""What must be true of a station at every moment, whatever was asked of it."""

from trackside import frames_of

from station.recording import active_path, left_behind
from station.store import JOB, PASS, SESSION, CalibrationSession, Job, Pass, Recording

_TABLES = ((Pass, PASS), (CalibrationSession, SESSION), (Job, JOB))


def ensure_files_and_rows_agree(served):
    """Every file is a row's and every row's frames are in its file; what was begun is there.

    The account of a recording that was closed while its sensor recorded on, unheard, is not held
    against its file.
    """
    unheard = _unheard(served)
    root = served.layout.root
    with served.store.look() as session:
        rows = {root / row.path: row for row in session.query(Recording)}
    files = {
        file.with_name(file.name.removesuffix(".active")): file
        for file in (root / "recordings").rglob("*.mcap*")
    }
    named = {part for path in rows for _, part in left_behind(path)}
    assert set(files) <= named, "a file that no row names"
    for capture in served.captures.values():
        assert set(capture.filled) <= set(files), "a recording whose file is lost"
        assert len(capture.filled) == len(set(capture.filled)), "a recording that was made twice"
    for path, row in rows.items():
        if row.closed_at is not None and path not in unheard:
            there = frames_of(path)
            assert row.recorded == there, (row.id, row.recorded, there)
            assert not any(active_path(part).exists() for _, part in left_behind(path)), (
                f"{row.id} is closed and still written"
            )


def ensure_one_at_a_time(served):
    """No sensor has two recordings that run, and no recording runs that no row has open."""
    with served.store.look() as session:
        running = [row for row in session.query(Recording) if row.closed_at is None]
        passes = [row for row in session.query(Pass) if row.state in PASS_IN_PROGRESS]
    assert len(passes) <= 1
    sensors = [row.sensor for row in running]
    assert len(sensors) == len(set(sensors)), "two recordings of a sensor run"


PASS_IN_PROGRESS = ("armed", "recording")


def _unheard(served):
    return set().union(*(capture.unheard for capture in served.captures.values()))


class History:
    """The states that everything went through; each must lead to the next by the tables."""

    def __init__(self):
        self._seen = {}
        self._ended = {}
        self._held = {}
        self._over = set()

    def note(self, served):
        """Hold what is there now against what was there before."""
        with served.store.look() as session:
            for table, transitions in _TABLES:
                for row in session.query(table):
                    self._note_state(transitions, row)
            for row in session.query(Recording):
                if served.layout.root / row.path not in _unheard(served):
                    self._note_account(row)

    def _note_state(self, transitions, row):
        key = (transitions.kind, row.id)
        before = self._seen.get(key, row.state)
        assert row.state in reachable(transitions, before), (key, before, row.state)
        self._seen[key] = row.state
        if row.state == "failed" and getattr(row, "ended_by", None) is not None:
            self._over.add(key)
        assert key not in self._over or row.state == "failed", f"{key} had ended"

    def _note_account(self, row):
        """What was once accounted for stays as it was; a count may be told later, once.

        A recording that has no frame may be made once more.
        """
        if not self._ended.get(row.id, (None, 0))[1] and row.id not in self._held:
            self._ended.pop(row.id, None)
        if row.closed_at is None:
            assert row.id not in self._ended, f"{row.id} was closed and runs again"
            return
        account = (row.closed_at, row.recorded, row.recovered, row.files)
        assert self._ended.setdefault(row.id, account) == account, row.id
        if row.expected is not None:
            held = (row.expected, row.lost)
            assert self._held.setdefault(row.id, held) == held, row.id


def reachable(transitions, state):
    """Every state that a state can lead to, itself among them."""
    found, todo = {state}, [state]
    while todo:
        new = transitions.allowed[todo.pop()] - found
        found |= new
        todo += new
    return found
