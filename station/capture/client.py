"""Commanding a capture process from another one."""

import json
import logging
import multiprocessing
import os
import socket
import time
from collections.abc import Callable
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import TYPE_CHECKING, Any

import structlog

from station import errors
from station.capture.look import Look
from station.capture.plan import CaptureReport, RecordingPlan
from station.capture.status import CaptureStatus
from station.errors import CameraError, CameraLost, StateConflict, StationError

if TYPE_CHECKING:  # pydantic would make a new recorder late by a quarter of a second
    from station.settings import SensorSettings

_ANSWER_TIMEOUT_S = 30.0
_CONNECT_TIMEOUT_S = 10.0
_RETRY_S = 0.05
_PIECE_BYTES = 1 << 16


class CaptureClient:
    """Gives orders at the socket of a capture process, each over a connection of its own.

    Every method raises the station's error that the capture process answers with, and CameraLost
    where that process does not answer.
    """

    def __init__(self, socket_path: Path, *, connect_timeout_s: float = _CONNECT_TIMEOUT_S) -> None:
        self._path = socket_path
        self._connect_timeout_s = connect_timeout_s

    def status(self) -> CaptureStatus:
        """Return what the capture process is doing."""
        return CaptureStatus.from_json(self._ask({"do": "status"})["status"])

    def arm(self, plan: RecordingPlan) -> None:
        """Open the recording and let the camera wait for its triggers, or run.

        Raises
        ------
        StateConflict
            If a recording is being made.
        CameraUnreachable, CameraRefused
            If the camera cannot be opened or does not take a setting.
        InputUnusable
            If the recording exists or its folder does not take it.
        """
        self._ask({"do": "arm", "plan": plan.to_json()})

    def look(self) -> Look:
        """Have the camera take one picture that is recorded nowhere; the caller closes it.

        Raises
        ------
        StateConflict
            If the sensor is not idle, nor between two triggers of a recording that allows it.
        CameraError
            If no whole picture comes of it.
        """
        answer, descriptors = self._asked({"do": "look"})
        return Look.from_json(answer["look"], *descriptors)

    def trigger(self) -> int:
        """Expose once by command; return the frame's id once it is in the file.

        Raises
        ------
        StateConflict
            If nothing is being recorded by software trigger, or a trigger is under way.
        CameraError
            If no whole frame comes of it.
        """
        return int(self._ask({"do": "trigger"})["frame_id"])

    def finish(self, expected_frames: int | None = None, timeout_s: float = 10.0) -> CaptureReport:
        """Wait for the last frames, close the recording and return its account.

        Parameters
        ----------
        expected_frames
            Exposures as somebody else counted them; a difference makes the report incomplete.
        timeout_s
            How long to wait for frames that are expected; it ends sooner once a second has passed
            without any.
        """
        order = {"do": "finish", "expected": expected_frames, "timeout_s": timeout_s}
        answer = self._ask(order, patience_s=_ANSWER_TIMEOUT_S + timeout_s)
        return CaptureReport.from_json(answer["report"])

    def shutdown(self) -> None:
        """End the capture process; a recording under way is finished."""
        self._ask({"do": "shutdown"})

    def _ask(self, order: dict[str, Any], patience_s: float = _ANSWER_TIMEOUT_S) -> dict[str, Any]:
        return self._asked(order, patience_s)[0]

    def _asked(
        self, order: dict[str, Any], patience_s: float = _ANSWER_TIMEOUT_S
    ) -> tuple[dict[str, Any], list[int]]:
        """Return the answer, and the open files that came with it."""
        with self._connected() as connection:
            connection.settimeout(patience_s)
            try:
                connection.sendall(json.dumps(order).encode() + b"\n")
                line, descriptors = _read_line(connection)
            except OSError as error:
                raise self._silent(error) from error
        answer: dict[str, Any] = json.loads(line)
        if "error" in answer:
            raise _error(answer)
        return answer, descriptors

    def _connected(self) -> socket.socket:
        """Connect; a process that was just started needs a moment to listen."""
        deadline = time.monotonic() + self._connect_timeout_s
        while True:
            connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            try:
                connection.connect(str(self._path))
            except OSError as error:
                connection.close()
                if time.monotonic() > deadline:
                    raise self._silent(error) from error
                time.sleep(_RETRY_S)
            else:
                return connection

    def _silent(self, error: OSError) -> CameraLost:
        return CameraLost(
            f"the capture process at {self._path} does not answer ({error}); is it running?"
        )


def start_capture(
    settings: "SensorSettings", socket_path: Path, *, log: Callable[[], None] | None = None
) -> BaseProcess:
    """Start the capture process of a sensor; it ends with the process that starts it.

    It is spawned, never forked: a fork of a process that has used Aravis carries dead threads.

    Parameters
    ----------
    log
        Sets up the logging of the process; without it nothing is logged, as where a person waits
        for one recording and is told by the report.
    """
    process = multiprocessing.get_context("spawn").Process(
        target=_run,
        args=(settings, socket_path, os.getpid(), log or log_nothing),
        name=f"capture {settings.id}",
        daemon=True,
    )
    process.start()
    return process


def log_nothing() -> None:
    """Keep a process from logging; by itself it would log to stdout."""
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.CRITICAL))


def _run(
    settings: "SensorSettings", socket_path: Path, parent_pid: int, log: Callable[[], None]
) -> None:
    from station.capture.process import run_capture  # noqa: PLC0415  only this process loads Aravis

    log()
    run_capture(settings, socket_path, parent_pid)


def _read_line(connection: socket.socket) -> tuple[bytes, list[int]]:
    received, shared = bytearray(), list[int]()
    while not received.endswith(b"\n"):
        piece, descriptors, *_ = socket.recv_fds(
            connection, _PIECE_BYTES, 1, socket.MSG_CMSG_CLOEXEC
        )
        shared += descriptors
        if not piece:
            raise ConnectionResetError("it closed the connection")
        received += piece
    return bytes(received), shared


def _error(answer: dict[str, Any]) -> StationError:
    kind = getattr(errors, answer["error"], CameraError)
    if kind is StateConflict:
        return StateConflict(answer["message"], state=answer["state"])
    error: StationError = kind(answer["message"])
    return error
