"""Shows the session that a night takes by itself with a real capture process and a GigE camera on
the loopback network: what is on the disk afterwards.  How it is solved is shown elsewhere."""

import os
import shutil
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from recalibration_ground import Shop

from station.capture import CaptureClient, start_capture
from station.recording import frames, verify
from station.settings import RecalibrationSettings, SensorSettings
from station.simulated import ArraySource, SimulatedCamera
from station.simulated.registers import TEMPERATURE_C
from station.store import CalibrationSession, Recalibration, recordings_of, the
from station.worker.collecting import collect
from station.worker.quiet import Quiet

ADDRESS = "127.36.1.2"
PICTURES = 3
SETTINGS = RecalibrationSettings(
    sensors={"left": {"capture": {"target": "dots:7x8:12", "pictures": PICTURES, "pause_s": 0.0}}}
)
SENSOR = SensorSettings(
    id="left",
    address=ADDRESS,
    laser_output="UserOutput0",
    calibration_exposures=[
        {"exposure_us": 8000.0, "laser": False},
        {"exposure_us": 300.0, "laser": True},
    ],
)


@pytest.fixture
def capture():
    """The sensor's capture process; its socket is in a short path, as those have to be."""
    folder = Path(tempfile.mkdtemp(prefix="w"))
    source = ArraySource([np.full((200, 320), 40, np.uint8)])
    with SimulatedCamera(ADDRESS, source, serial="S1"):
        process = start_capture(SENSOR, folder / f"{os.getpid()}.sock")
        client = CaptureClient(folder / f"{os.getpid()}.sock", connect_timeout_s=60.0)
        yield client
        client.shutdown()
        process.join(30.0)
    shutil.rmtree(folder)


def test_a_night_takes_its_own_pictures_and_takes_them_into_the_recalibration(
    ground, tmp_path, rng, capture
):
    shop = Shop(ground, tmp_path / "trace", rng, settings=SETTINGS)
    settings = shop.station_settings.model_copy(update={"sensors": (SENSOR,), "rigs": ()})
    context = replace(shop.context, settings=settings, captures={"left": capture})
    shop.order()
    row = shop.found()
    quiet = Quiet(context, row, first=0.0, last=1.0, sleep=lambda _: None)
    collect(context, row, quiet)
    with shop.store.look() as session:
        taken = the(session, Recalibration, "r1").taken
        of_night = the(session, CalibrationSession, "recalibration-r1")
        (recording,) = recordings_of(session, of_night)
    assert (of_night.state, of_night.pictures) == ("recorded", PICTURES)
    assert taken == {"recordings": [recording.id], "target": "dots:7x8:12", "piece": []}
    # Each picture is of both exposures, and none is lost.
    assert (recording.recorded, recording.lost, recording.complete) == (2 * PICTURES, 0, True)
    path = ground.layout.root / recording.path
    assert verify(path).ok
    assert len(list(frames(path))) == 2 * PICTURES


def test_a_camera_tells_how_warm_it_is_while_nothing_is_recorded(capture):
    deadline = time.monotonic() + 30.0
    while (warm_c := capture.status().temperature_c) is None:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    assert warm_c == TEMPERATURE_C
