"""Shows that the bench of calls makes them when they are due, counts those that fail, and finds its
way through a station that records and measures.  A short and slow load: the times are no claims."""

import socket
import threading

import pytest

from station.bench.service.load import bench_service, calls_of
from station.bench.service.open_loop import Call, Load, drive
from station.progress import silent

ANSWER = b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\n{}"
REFUSAL = b"HTTP/1.1 503 Busy\r\nContent-Length: 0\r\n\r\n"
CALLS = (Call("get", "GET", "/", 3.0), Call("put", "PUT", "/", 1.0, body="{}"))


class Server:
    """Answers each connection in a thread of its own, by `answer`, which may take its time."""

    def __init__(self, answer):
        self._answer = answer
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.port = self._listening.getsockname()[1]
        self._threads = []
        self._accepting = threading.Thread(target=self._accept)
        self._accepting.start()

    def _accept(self):
        while True:
            connection, _ = self._listening.accept()
            if not self._threads and self._ending:
                connection.close()
                return
            thread = threading.Thread(target=self._serve, args=(connection,))
            thread.start()
            self._threads.append(thread)

    _ending = False
