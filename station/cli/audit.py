"""`station audit`: who changed what."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from station.cli.output import AsJson, emit
from station.errors import InputUnusable
from station.operations import DataLayout
from station.settings import load_settings
from station.store import AuditEntry, Store, revision_of
from station.store.lists import audit_page

_PAGE = 1000


def audit(
    config: Annotated[
        Path, typer.Option(metavar="FILE", help="Settings of the station (TOML).")
    ] = Path("station.toml"),
    subject: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of this pass, job, key, sensor ... alone.")
    ] = None,
    who: Annotated[
        str | None, typer.Option(metavar="NAME", help="By this key or user alone.")
    ] = None,
    limit: Annotated[int, typer.Option(min=1, help="The newest so many.")] = 100,
    as_json: AsJson = False,
) -> None:
    """Tell who changed what, when and from where: the newest first."""
    url = DataLayout.of(load_settings(config)).store_url
    if revision_of(url) is None:
        raise InputUnusable("there is no store yet; has `station serve` run?")
    store = Store.open(url)
    try:
        entries = [_as_data(entry) for entry in _entries(store, limit, subject, who)]
    finally:
        store.close()
    text = "\n".join(map(_line, entries)) or "nothing was changed"
    emit({"entries": entries}, text, as_json=as_json)


def _entries(
    store: Store, limit: int, subject: str | None, who: str | None
) -> Iterator[AuditEntry]:
    before = None
    while limit > 0:
        with store.look() as session:
            page = audit_page(
                session, limit=min(limit, _PAGE), before=before, subject=subject, who=who
            )
        yield from page.rows
        if not page.more:
            return
        limit -= len(page.rows)
        before = page.rows[-1].id


def _as_data(entry: AuditEntry) -> dict[str, Any]:
    return {
        "id": entry.id,
        "at": entry.at.isoformat(),
        "who": entry.who,
        "address": entry.address,
        "action": entry.action,
        "kind": entry.kind,
        "subject": entry.subject,
        "before": entry.before,
        "after": entry.after,
    }


def _line(entry: dict[str, Any]) -> str:
    place = f" from {entry['address']}" if entry["address"] else ""
    changes = [
        f"{name} {', '.join(f'{key} {value}' for key, value in entry[name].items())}"
        for name in ("before", "after")
        if entry[name]
    ]
    what = f"{entry['action']} {entry['kind']} {entry['subject']}"
    told = f" ({'; '.join(changes)})" if changes else ""
    return f"{entry['at'][:19]}Z  {entry['who']}{place}: {what}{told}"
