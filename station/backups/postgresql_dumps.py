"""Dumps of a store in PostgreSQL by its own programs, which come with its client package."""

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from sqlalchemy.dialects import registry

from station.errors import InputUnusable, StoreUnusable
from station.store import Table, database_url

MAGIC = b"PGDMP"
_VARIABLES = {
    "host": "PGHOST",
    "port": "PGPORT",
    "user": "PGUSER",
    "password": "PGPASSWORD",
    "dbname": "PGDATABASE",
    "sslmode": "PGSSLMODE",
    "sslrootcert": "PGSSLROOTCERT",
    "sslcert": "PGSSLCERT",
    "sslkey": "PGSSLKEY",
}


def dump_store(url: str, target: Path) -> None:
    """Write the database of a store, as it is at one moment, into a file.

    Raises
    ------
    StoreUnusable
        If the database does not let it.
    """
    _run(url, ["pg_dump", "--format=custom", "--no-owner", "--no-privileges", "-f", str(target)])


def ensure_readable(url: str, path: Path) -> None:
    """Read through a dump.

    Raises
    ------
    StoreUnusable
        If it is cut short or damaged.
    """
    _run(url, ["pg_restore", "--file", os.devnull, str(path)])


def load_dump(url: str, path: Path) -> None:
    """Put a dump in the place of what the database has, all of it or nothing.

    Raises
    ------
    StoreUnusable
        If the database does not take it; it is then as it was.
    """
    script = _run(url, ["pg_restore", "--no-owner", "--no-privileges", "--file=-", str(path)])
    names = ", ".join([*Table.metadata.tables, "alembic_version"])
    emptied = (
        f"DROP TABLE IF EXISTS {names} CASCADE;\n"
        "DROP FUNCTION IF EXISTS refuse_change_of_audit(), note_change_by_id(),"
        " note_change_by_pass_id() CASCADE;\n"
    )
    # In the dump of a database whose schema somebody made anew; here there is one already.
    script = script.replace(b"\nCREATE SCHEMA public;\n", b"\n")
    command = ["psql", "--no-psqlrc", "--quiet", "--single-transaction", "-v", "ON_ERROR_STOP=1"]
    _run(url, [*command, "--file=-"], given=emptied.encode() + script)


def _run(url: str, command: Sequence[str], given: bytes = b"") -> bytes:
    program = shutil.which(command[0])
    if program is None:
        raise InputUnusable(
            f"{command[0]} is not here; install PostgreSQL's client (postgresql-client)"
        )
    done = subprocess.run(
        [program, *command[1:]],
        env={**os.environ, **_environment(url)},
        input=given,
        capture_output=True,
        check=False,
    )
    if done.returncode != 0:
        lines = done.stderr.decode(errors="replace").strip().splitlines() or ["no reason given"]
        raise StoreUnusable(f"{command[0]}: {lines[0]}")
    return done.stdout


def _environment(url: str) -> dict[str, str]:
    """Return the connection as libpq's variables: what stands in a command line, others see."""
    parsed = database_url(url)
    dialect = registry.load(parsed.drivername.replace("+", "."))()
    _, given = dialect.create_connect_args(parsed)
    unknown = sorted(set(given) - set(_VARIABLES))
    if unknown:
        known = ", ".join(_VARIABLES)
        raise InputUnusable(f"store_url has {unknown[0]}; allowed for backups: {known}")
    return {_VARIABLES[name]: str(value) for name, value in given.items()}
