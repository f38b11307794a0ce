"""The least a service in Python can do: the same server and framework, a constant for an answer."""

import multiprocessing
import socket
from collections.abc import Generator
from contextlib import contextmanager

from fastapi import FastAPI

_END_S = 10.0


def bare_app() -> FastAPI:
    """Return an app that answers every call alike, from a thread as the station does."""
    app = FastAPI(openapi_url=None)

    def answer() -> dict[str, str]:
        return {"state": "recording"}

    app.add_api_route("/{path:path}", answer, methods=["GET", "PUT", "POST"])
    return app


@contextmanager
def served_peer() -> Generator[int]:
    """Serve the app in a process of its own while the block runs; yield its port."""
    listening = socket.create_server(("127.0.0.1", 0))
    process = multiprocessing.get_context("spawn").Process(
        target=_serve, args=(listening,), name="bare app", daemon=True
    )
    process.start()
    try:
        yield int(listening.getsockname()[1])
    finally:
        process.terminate()
        process.join(_END_S)
        process.kill()
        process.join()
        listening.close()


def _serve(listening: socket.socket) -> None:
    import uvicorn  # noqa: PLC0415  only this process pays for it

    listening.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    config = uvicorn.Config(bare_app(), http="h11", access_log=False, log_level="warning")
    uvicorn.Server(config).run(sockets=[listening])
