"""One picture taken through the camera and recorded nowhere: to aim, to focus, to hold a target.

Nothing else is done meanwhile: whoever orders something else waits for one exposure at most.  The
picture leaves the process in memory without a name, so that nothing is left behind by a look.
"""

import os
import time

from station.capture.camera import Camera
from station.capture.look import Look
from station.capture.plan import Trigger
from station.capture.ring import Ring
from station.capture.stream import FrameStream, ReceivedFrame
from station.errors import CameraError, CameraLost

_SLOT = 0
_ON_ITS_WAY_S = 0.25
"""From the end of the exposure to the first packet; a frame of which packets came is waited for."""
_WAIT_US = 5_000
_SILENT = "the camera stopped answering; check its power and cable"


def take_look(camera: Camera, ring: Ring) -> Look:
    """Have a camera that does not acquire expose once, as its settings say; return the picture.

    Parameters
    ----------
    ring
        Where frames are received; none of its slots is in use.

    Raises
    ------
    CameraLost
        If the camera stopped answering; it is to be opened again.
    CameraError
        If no whole frame came of the trigger.
    """
    if not camera.answers():
        raise CameraLost(_SILENT)  # an order to it would take seconds, and others wait
    stream = camera.start(Trigger.SOFTWARE, ring, [_SLOT])
    try:
        camera.trigger()
        frame = _awaited(stream, time.monotonic() + camera.exposure_us * 1e-6 + _ON_ITS_WAY_S)
    finally:
        _end(camera, stream)
    if frame is None:
        raise CameraError("no frame came of the trigger; look again")
    if frame.flaw is not None:
        raise CameraError(f"the frame arrived incomplete ({frame.flaw}); look again")
    shared = _shared(ring.picture(frame.slot, frame.width * frame.height))
    return Look(shared, frame.width, frame.height, frame.received_ns)


def _awaited(stream: FrameStream, deadline_s: float) -> ReceivedFrame | None:
    while time.monotonic() < deadline_s or stream.in_flight:
        frame = next(stream.take(_WAIT_US), None)
        if frame is not None:
            return frame
    return None


def _end(camera: Camera, stream: FrameStream) -> None:
    """Leave the camera as it was; CameraLost where it is gone."""
    if camera.answers():
        camera.stop()
        stream.close(lost=False)
    else:
        stream.close(lost=True)
        raise CameraLost(_SILENT)


def _shared(picture: memoryview) -> int:
    """Return the descriptor of a copy in memory; the ring is for the next recording."""
    descriptor = os.memfd_create("look")
    with os.fdopen(descriptor, "wb", closefd=False) as memory:
        memory.write(picture)
    return descriptor
