"""What changed, in the order of writing; and which life of the store this is.

Triggers note the changes: a writer that is added later is followed too.  On SQLite a migration
that makes one of these tables anew (a batch) drops its triggers, and must make them again: a test
looks for every one of them at the newest revision.
"""

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"
branch_labels = None
depends_on = None

_COUNTED = sa.BigInteger().with_variant(sa.Integer, "sqlite")
_ON_WRITING = ("INSERT", "UPDATE")
# Table, kind of the change, column that names what changed, and when it is noted.
_FOLLOWED = (
    ("passes", "pass", "id", _ON_WRITING),
    ("measurements", "pass", "pass_id", _ON_WRITING),
    ("axle_wheels", "pass", "pass_id", (*_ON_WRITING, "DELETE")),
    ("activations", "activation", "id", ("INSERT",)),
    ("rig_activations", "rig_activation", "id", ("INSERT",)),
    ("recalibrations", "recalibration", "id", _ON_WRITING),
)
_BEFORE = (
    ("pass", "id", "passes", "opened_at"),
    ("activation", "CAST(id AS VARCHAR)", "activations", "activated_at"),
    ("rig_activation", "CAST(id AS VARCHAR)", "rig_activations", "activated_at"),
    ("recalibration", "id", "recalibrations", "ordered_at"),
)


def upgrade() -> None:
    """Create the tables and the triggers, and note what was there before, the oldest first."""
    op.create_table(
        "changes",
        sa.Column("number", _COUNTED, nullable=False),
        sa.Column("kind", sa.String, nullable=False),
        sa.Column("key", sa.String, nullable=False),
        sa.Column("changed_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("number", name="pk_changes"),
        sa.UniqueConstraint("kind", "key", name="uq_changes_kind_key"),
        sqlite_autoincrement=True,
    )
    op.create_table(
        "store_epochs",
        sa.Column("id", sa.Integer, nullable=False),
        sa.Column("epoch", sa.String, nullable=False),
        sa.Column("began_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_store_epochs"),
    )
    op.create_table(
        "pushes",
        sa.Column("id", sa.Integer, nullable=False),
        sa.Column("token", sa.String, nullable=False),
        sa.Column("number", _COUNTED, nullable=False),
        sa.Column("prepared_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_pushes"),
        sa.UniqueConstraint("token", name="uq_pushes_token"),
    )
    before = " UNION ALL ".join(
        f"SELECT '{kind}' AS kind, {key} AS key, {at} AS at FROM {table}"
        for kind, key, table, at in _BEFORE
    )
    op.execute(
        f"INSERT INTO changes (kind, key, changed_at) SELECT kind, key, at FROM ({before}) AS b"
        " ORDER BY at, kind, key"
    )
    for statement in _triggers_sqlite() if _on_sqlite() else _triggers_postgresql():
        op.execute(statement)


def downgrade() -> None:
    """Drop them: whoever follows the store is sent everything once more after the next upgrade."""
    for table, _, _, events in _FOLLOWED:
        for event in events if _on_sqlite() else ("",):
            on = "" if _on_sqlite() else f" ON {table}"
            op.execute(f"DROP TRIGGER {_name(table, event)}{on}")
    if not _on_sqlite():
        for column in ("id", "pass_id"):
            op.execute(f"DROP FUNCTION note_change_by_{column}()")
    for table in ("pushes", "store_epochs", "changes"):
        op.drop_table(table)


def _on_sqlite() -> bool:
    return bool(op.get_bind().dialect.name == "sqlite")


def _name(table: str, event: str) -> str:
    return f"{table}_followed_{event.lower()}".rstrip("_")


def _triggers_sqlite() -> list[str]:
    # Deleted and inserted: the "OR ..." of a statement would override that of its triggers.
    return [
        f"CREATE TRIGGER {_name(table, event)} AFTER {event} ON {table}"
        f" WHEN {row}.{column} IS NOT NULL BEGIN"
        f" DELETE FROM changes WHERE kind = '{kind}' AND key = CAST({row}.{column} AS TEXT);"
        " INSERT INTO changes (kind, key, changed_at) VALUES"
        f" ('{kind}', CAST({row}.{column} AS TEXT), strftime('%Y-%m-%d %H:%M:%f', 'now')); END"
        for table, kind, column, events in _FOLLOWED
        for event in events
        for row in ("OLD" if event == "DELETE" else "NEW",)
    ]


def _triggers_postgresql() -> list[str]:
    functions = [
        f"CREATE OR REPLACE FUNCTION note_change_by_{column}() RETURNS trigger"
        " LANGUAGE plpgsql AS $$ DECLARE changed text; BEGIN"
        f" IF TG_OP = 'DELETE' THEN changed := OLD.{column}; ELSE changed := NEW.{column}; END IF;"
        " IF changed IS NOT NULL THEN INSERT INTO changes (kind, key, changed_at)"
        " VALUES (TG_ARGV[0], changed, clock_timestamp()) ON CONFLICT (kind, key) DO UPDATE"
        " SET number = excluded.number, changed_at = excluded.changed_at; END IF;"
        " RETURN NULL; END $$"
        for column in ("id", "pass_id")
    ]
    triggers = [
        f"CREATE TRIGGER {_name(table, '')} AFTER {' OR '.join(events)} ON {table}"
        f" FOR EACH ROW EXECUTE FUNCTION note_change_by_{column}('{kind}')"
        for table, kind, column, events in _FOLLOWED
    ]
    return functions + triggers
