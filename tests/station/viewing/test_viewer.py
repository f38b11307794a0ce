"""Shows that the viewing process is there when it is needed, and not when it is not."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from viewing_samples import HEIGHT, NOON_NS, WIDTH, striped, write_striped

from station.errors import NotFound
from station.recording import RecordingWriter
from station.viewing import Form, SharedPicture, Viewer, ViewerLost, ViewOrder

FRAMES = 3
LONG_S = 30.0
MAKES_ONE_AND_WAITS = """
import sys
from pathlib import Path
from station.viewing import Form, Viewer, ViewOrder
viewer = Viewer("info", Path(sys.argv[2]))
viewer.view(ViewOrder(Form.JPEG, Path(sys.argv[1])))
print(viewer.pid, flush=True)
sys.stdin.read()
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "a.mcap"
    with RecordingWriter(path) as writer:
        write_striped(writer, range(1, FRAMES + 1), "left")
    return path


@pytest.fixture(scope="module")
def viewer(tmp_path_factory):
    made = Viewer("info", tmp_path_factory.mktemp("data") / "processes.lock")
    yield made
    made.close()


def wait_until(is_so):
    deadline = time.monotonic() + LONG_S
    while not is_so():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def files_of(pid):
    names = []
    for each in Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(FileNotFoundError):  # closed since it was listed
            names.append(os.readlink(each))
    return names


def is_gone(pid):
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return True
    return state == "Z"  # of a parent that is dead itself, whoever buries it


def test_pictures_are_made_behind_everything_that_measures_in_a_process_of_their_own(
    viewer, recording
):
    view = viewer.view(ViewOrder(Form.JPEG, recording, number=2))
    assert (view.frame.number, view.frame.frame_id) == (2, 102)
    assert view.content.startswith(b"\xff\xd8")
    assert viewer.pid != os.getpid()
    here = os.getpriority(os.PRIO_PROCESS, 0)
    assert os.getpriority(os.PRIO_PROCESS, viewer.pid) == min(here + 5, 19)


def test_a_frame_that_the_caller_has_is_not_given_again(viewer, recording):
    assert viewer.view(ViewOrder(Form.JPEG, recording, known=FRAMES)) is None
    assert viewer.view(ViewOrder(Form.JPEG, recording, known=FRAMES - 1)).frame.number == FRAMES


def test_a_picture_in_shared_memory_is_handed_on(viewer):
    descriptor = os.memfd_create("picture")
    os.write(descriptor, striped(1).tobytes())
    shared = SharedPicture(descriptor, WIDTH, HEIGHT, NOON_NS)
    for _ in range(3):
        assert viewer.view(ViewOrder(Form.STRIPE, shared=shared)).frame.received_ns == NOON_NS
    os.close(descriptor)
    wait_until(lambda: not [name for name in files_of(viewer.pid) if "picture" in name])


def test_what_cannot_be_shown_is_raised_here_and_the_next_is_shown(viewer, recording):
    with pytest.raises(NotFound, match="there is no frame 9"):
        viewer.view(ViewOrder(Form.JPEG, recording, number=9))
    with pytest.raises(NotFound, match="no frame on the disk"):
        viewer.view(ViewOrder(Form.JPEG, recording.with_name("none.mcap")))
    assert viewer.view(ViewOrder(Form.JPEG, recording, number=1)).frame.number == 1


def test_everybody_who_asks_at_the_same_time_gets_what_was_asked_for(viewer, recording):
    def shown(number):
        return viewer.view(ViewOrder(Form.STRIPE, recording, number=number)).frame.number

    wanted = [1 + turn % FRAMES for turn in range(24)]
    with ThreadPoolExecutor(6) as pool:
        assert list(pool.map(shown, wanted)) == wanted


def test_one_that_was_killed_is_followed_by_another(viewer, recording):
    viewer.view(ViewOrder(Form.JPEG, recording))
    first = viewer.pid
    os.kill(first, signal.SIGKILL)
    assert viewer.view(ViewOrder(Form.JPEG, recording, number=1)).frame.number == 1
    assert viewer.pid != first


def test_one_that_does_not_answer_is_ended_and_the_next_picture_comes(
    viewer, recording, monkeypatch
):
    viewer.view(ViewOrder(Form.JPEG, recording))
    with monkeypatch.context() as patched:
        patched.setattr(viewer, "_patience_s", 0.2)
        os.kill(viewer.pid, signal.SIGSTOP)
        with pytest.raises(ViewerLost, match=r"within 0\.2 s"):
            viewer.view(ViewOrder(Form.JPEG, recording, number=1))
    assert viewer.view(ViewOrder(Form.JPEG, recording, number=1)).frame.number == 1


def test_it_ends_when_nobody_asks(recording, tmp_path):
    viewer = Viewer("info", tmp_path / "lock", idle_s=0.3)
    viewer.view(ViewOrder(Form.JPEG, recording))
    wait_until(lambda: viewer.pid is None)
    viewer.close()


def test_it_ends_with_the_process_that_started_it_however_that_ends(recording, tmp_path):
    parent = subprocess.Popen(
        [sys.executable, "-c", MAKES_ONE_AND_WAITS, str(recording), str(tmp_path / "lock")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    pid = int(parent.stdout.readline())
    assert not is_gone(pid)
    parent.kill()
    parent.communicate()
    wait_until(lambda: is_gone(pid))
