"""A real PostgreSQL for tests: a server of its own, on a socket in a folder of its own."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import psycopg

_LET_GO = """
SELECT pg_terminate_backend(pid) FROM pg_stat_activity
WHERE backend_type = 'client backend' AND pid <> pg_backend_pid()
"""
_EMPTY = """
DO $$ DECLARE one record; BEGIN
  FOR one IN SELECT tablename FROM pg_tables WHERE schemaname = 'public' LOOP
    EXECUTE format('DROP TABLE %I CASCADE', one.tablename);
  END LOOP;
  DROP FUNCTION IF EXISTS refuse_change_of_audit(), note_change_by_id(), note_change_by_pass_id();
END $$
"""


def initdb():
    """The program that makes a server's folder, on the PATH or where Debian keeps it; or None."""
    debian = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"))
    found = shutil.which("initdb") or (debian[-1] if debian else None)
    return None if found is None else Path(found).resolve()


class PostgresServer:
    """A running server with one database, which each test gets empty."""

    def __init__(self, programs: Path) -> None:
        self.root = Path(tempfile.mkdtemp(prefix="treadline-pg-"))
        # PostgreSQL refuses to be run by root.
        self._as_user = {"user": "postgres", "group": "postgres"} if os.getuid() == 0 else {}
        if self._as_user:
            shutil.chown(self.root, **self._as_user)
        self._control = programs / "pg_ctl"
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
        self.start()

    @property
    def _data(self):
        return self.root / "data"

    def _run(self, *command):
        subprocess.run(command, check=True, capture_output=True, cwd=self.root, **self._as_user)

    def start(self):
        """Start the server; after a crash it recovers first."""
        options = f"-k {self.root} -c listen_addresses='' -c fsync=off -c max_connections=200"
        self._run(
            self._control, "-D", self._data, "-o", options, "-l", self.root / "log", "-w", "start"
        )

    @property
    def pid(self):
        """The process that takes connections."""
        return int((self._data / "postmaster.pid").read_text().splitlines()[0])

    def crash(self):
        """End the server at once, its connections with it."""
        self._run(self._control, "-D", self._data, "-m", "immediate", "stop")

    def empty_database(self):
        """The URL of the database, emptied: making one anew takes longer than most tests."""
        with psycopg.connect(
            host=str(self.root), user="treadline", dbname="postgres", autocommit=True
        ) as connection:
            connection.execute(_LET_GO)
            connection.execute(_EMPTY)
        return f"postgresql://treadline@/postgres?host={self.root}"

    def stop(self):
        self.crash()
        shutil.rmtree(self.root)
