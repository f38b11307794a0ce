"""A real PostgreSQL for tests: a server of its own, on a socket in a folder of its own."""

import os
import shutil
import subprocess
import tempfile
from itertools import count
from pathlib import Path

import psycopg


def initdb():
    """The program that makes a server's folder, on the PATH or where Debian keeps it; or None."""
    debian = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"))
    found = shutil.which("initdb") or (debian[-1] if debian else None)
    return None if found is None else Path(found).resolve()


class PostgresServer:
    """A running server; each test takes a database of its own."""

    def __init__(self, programs: Path) -> None:
        self.root = Path(tempfile.mkdtemp(prefix="treadline-pg-"))
        # PostgreSQL refuses to be run by root.
        self._as_user = {"user": "postgres", "group": "postgres"} if os.getuid() == 0 else {}
        if self._as_user:
            shutil.chown(self.root, **self._as_user)
        self._control = programs / "pg_ctl"
        self._names = (f"store{n}" for n in count())
        make = [
            programs / "initdb",
            "-D",
            self._data,
            "-U",
            "treadline",
            "-A",
            "trust",
            "--no-sync",
        ]
        self._run(*make, "-E", "UTF8", "--locale=C.UTF-8")
        options = f"-k {self.root} -c listen_addresses='' -c fsync=off -c max_connections=200"
        self._run(
            self._control, "-D", self._data, "-o", options, "-l", self.root / "log", "-w", "start"
        )

    @property
    def _data(self):
        return self.root / "data"

    def _run(self, *command):
        subprocess.run(command, check=True, capture_output=True, cwd=self.root, **self._as_user)

    def new_database(self):
        """The URL of an empty database."""
        name = next(self._names)
        with psycopg.connect(
            host=str(self.root), user="treadline", dbname="postgres", autocommit=True
        ) as connection:
            connection.execute(f"CREATE DATABASE {name}")
        return f"postgresql://treadline@/{name}?host={self.root}"

    def stop(self):
        self._run(self._control, "-D", self._data, "-m", "immediate", "stop")
        shutil.rmtree(self.root)
