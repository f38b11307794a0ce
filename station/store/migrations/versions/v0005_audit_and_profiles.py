"""The audit trail, profiles of wheels in a table that lists do not read, and what is compacted."""

import sqlalchemy as sa
from alembic import context, op

from station.errors import StationError

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None

_WHEELSET_INDEX = "ix_axle_wheels_wheelset_measurement_id"
_GUARDS_SQLITE = (
    "CREATE TRIGGER audit_entries_stay BEFORE UPDATE ON audit_entries"
    " BEGIN SELECT RAISE(ABORT, 'the audit trail is only added to'); END",
    "CREATE TRIGGER audit_entries_are_kept BEFORE DELETE ON audit_entries"
    " BEGIN SELECT RAISE(ABORT, 'the audit trail is only added to'); END",
    # INSERT OR REPLACE deletes without asking the trigger above.
    "CREATE TRIGGER audit_entries_are_not_replaced BEFORE INSERT ON audit_entries"
    " WHEN EXISTS (SELECT 1 FROM audit_entries WHERE id = NEW.id)"
    " BEGIN SELECT RAISE(ABORT, 'the audit trail is only added to'); END",
)
_GUARDS_POSTGRESQL = (
    "CREATE FUNCTION refuse_change_of_audit() RETURNS trigger LANGUAGE plpgsql AS $$"
    " BEGIN RAISE EXCEPTION 'the audit trail is only added to'; END $$",
    "CREATE TRIGGER audit_entries_stay BEFORE UPDATE OR DELETE OR TRUNCATE ON audit_entries"
    " FOR EACH STATEMENT EXECUTE FUNCTION refuse_change_of_audit()",
)


def upgrade() -> None:
    """Add the tables, and move the profiles of what was measured before into theirs."""
    _create_audit_entries()
    op.create_table(
        "measurement_profiles",
        sa.Column("measurement_id", sa.Integer, nullable=False),
        sa.Column("profile", sa.JSON, nullable=False),
        sa.PrimaryKeyConstraint("measurement_id", name="pk_measurement_profiles"),
        sa.ForeignKeyConstraint(
            ["measurement_id"], ["measurements.id"], name="fk_measurement_profiles_measurement_id"
        ),
    )
    for statement in _MOVE_OUT_SQLITE if _on_sqlite() else _MOVE_OUT_POSTGRESQL:
        op.execute(statement)
    op.create_index(_WHEELSET_INDEX, "axle_wheels", ["wheelset", "measurement_id"])
    with op.batch_alter_table("recordings") as table:
        table.add_column(sa.Column("compacted_at", sa.DateTime(timezone=True)))


def downgrade() -> None:
    """Put the profiles back and drop the audit trail: one with entries only when told to.

    Raises
    ------
    StationError
        If the trail has entries, and the caller of `migrate` did not say that they may be lost.
    """
    entries = op.get_bind().scalar(sa.text("SELECT count(*) FROM audit_entries"))
    if entries and not context.config.attributes.get("losing"):
        raise StationError(
            f"revision {down_revision} has no place for the audit trail, {entries} entries: "
            "back the store up, then say that they may be lost"
        )
    with op.batch_alter_table("recordings") as table:
        table.drop_column("compacted_at")
    op.drop_index(_WHEELSET_INDEX, "axle_wheels")
    op.execute(_PUT_BACK_SQLITE if _on_sqlite() else _PUT_BACK_POSTGRESQL)
    op.drop_table("measurement_profiles")
    op.drop_table("audit_entries")
    if not _on_sqlite():
        op.execute("DROP FUNCTION refuse_change_of_audit()")


def _on_sqlite() -> bool:
    return bool(op.get_bind().dialect.name == "sqlite")


def _create_audit_entries() -> None:
    op.create_table(
        "audit_entries",
        sa.Column("id", sa.Integer, nullable=False),
        sa.Column("at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("who", sa.String, nullable=False),
        sa.Column("address", sa.String),
        sa.Column("action", sa.String, nullable=False),
        sa.Column("kind", sa.String, nullable=False),
        sa.Column("subject", sa.String, nullable=False),
        sa.Column("before", sa.JSON),
        sa.Column("after", sa.JSON),
        sa.PrimaryKeyConstraint("id", name="pk_audit_entries"),
    )
    op.create_index("ix_audit_entries_subject_id", "audit_entries", ["subject", "id"])
    for statement in _GUARDS_SQLITE if _on_sqlite() else _GUARDS_POSTGRESQL:
        op.execute(statement)


_MOVE_OUT_SQLITE = (
    "INSERT INTO measurement_profiles (measurement_id, profile)"
    " SELECT id, json_extract(wheel, '$.profile') FROM measurements"
    " WHERE json_type(wheel, '$.profile') = 'object'",
    "UPDATE measurements SET wheel = json_remove(wheel, '$.profile')",
)
_PUT_BACK_SQLITE = (
    "UPDATE measurements SET wheel = json_set(wheel, '$.profile', json((SELECT profile"
    " FROM measurement_profiles WHERE measurement_id = measurements.id)))"
    " WHERE id IN (SELECT measurement_id FROM measurement_profiles)"
)
_MOVE_OUT_POSTGRESQL = (
    "INSERT INTO measurement_profiles (measurement_id, profile)"
    " SELECT id, wheel->'profile' FROM measurements"
    " WHERE json_typeof(wheel->'profile') = 'object'",
    "UPDATE measurements SET wheel = (CAST(wheel AS jsonb) - 'profile')",
)
_PUT_BACK_POSTGRESQL = (
    "UPDATE measurements SET wheel = CAST(wheel AS jsonb) || jsonb_build_object("
    "'profile', CAST(kept.profile AS jsonb))"
    " FROM measurement_profiles AS kept WHERE kept.measurement_id = measurements.id"
)
