"""Replays, measurements kept apart by their reference, and what lists are found by."""

import sqlalchemy as sa
from alembic import context, op

from station.errors import StationError

revision = "0011"
down_revision = "0010"
branch_labels = None
depends_on = None

_OF_SENSORS = "uq_measurements_of_sensors", ["recording_id", "frame", "calibration_id"], "NULL"
_OF_RIGS = (
    "uq_measurements_of_rigs",
    ["recording_id", "frame", "calibration_id", "rig_calibration_id"],
    "NOT NULL",
)
_LISTED = (
    ("ix_passes_opened_at_id", "passes", ["opened_at", "id"]),
    ("ix_passes_train_opened_at", "passes", ["train", "opened_at"]),
    ("ix_recordings_sensor_opened_at_id", "recordings", ["sensor", "opened_at", "id"]),
    ("ix_jobs_created_at_id", "jobs", ["created_at", "id"]),
    ("ix_jobs_subject_created_at", "jobs", ["subject", "created_at"]),
)


def upgrade() -> None:
    """Add the tables and indexes; a wheel may be measured against several references from now."""
    op.create_table(
        "replays",
        sa.Column("id", sa.String, nullable=False),
        sa.Column("ordered_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("ordered_by", sa.String, nullable=False),
        sa.Column("job_id", sa.String, nullable=False),
        sa.Column("pass_id", sa.String),
        sa.Column("steps", sa.JSON, nullable=False),
        sa.Column("calibrations", sa.JSON, nullable=False),
        sa.Column("rig_calibration_id", sa.String),
        sa.Column("reference", sa.String, nullable=False),
        sa.Column("results", sa.JSON, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_replays"),
        sa.ForeignKeyConstraint(["pass_id"], ["passes.id"], "fk_replays_pass_id"),
        sa.ForeignKeyConstraint(
            ["rig_calibration_id"], ["rig_calibrations.id"], "fk_replays_rig_calibration_id"
        ),
    )
    op.create_index("ix_replays_ordered_at_id", "replays", ["ordered_at", "id"])
    op.create_table(
        "replay_measurements",
        sa.Column("replay_id", sa.String, nullable=False),
        sa.Column("measurement_id", sa.Integer, nullable=False),
        sa.PrimaryKeyConstraint("replay_id", "measurement_id", name="pk_replay_measurements"),
        sa.ForeignKeyConstraint(["replay_id"], ["replays.id"], "fk_replay_measurements_replay_id"),
        sa.ForeignKeyConstraint(
            ["measurement_id"], ["measurements.id"], "fk_replay_measurements_measurement_id"
        ),
    )
    for name, table, columns in _LISTED:
        op.create_index(name, table, columns)
    for name, columns, null in (_OF_SENSORS, _OF_RIGS):
        op.drop_index(name, "measurements")
        _create_unique(name, [*columns, "reference"], null)


def downgrade() -> None:
    """Forget which rows replays came to; what they measured stays.

    Raises
    ------
    StationError
        If a wheel was measured against several references, and the caller of `migrate` did not say
        that all but the first may be lost.
    """
    _ensure_one_reference()
    for name, columns, null in (_OF_RIGS, _OF_SENSORS):
        op.drop_index(name, "measurements")
        _create_unique(name, columns, null)
    for name, table, _ in reversed(_LISTED):
        op.drop_index(name, table)
    op.drop_table("replay_measurements")
    op.drop_table("replays")


def _ensure_one_reference() -> None:
    key = "recording_id, frame, calibration_id, coalesce(rig_calibration_id, '')"
    firsts = f"SELECT min(id) FROM measurements GROUP BY {key}"  # noqa: S608  this file's own words
    others = f"SELECT id FROM measurements WHERE id NOT IN ({firsts})"  # noqa: S608  this file's own words
    if not op.get_bind().scalar(sa.text(f"SELECT count(*) FROM ({others}) AS several")):  # noqa: S608  this file's own words
        return
    if not context.config.attributes.get("losing"):
        raise StationError(
            "wheels were measured against several references, which the store of an older version "
            "cannot hold; make a backup, then go back with losing=True"
        )
    for table in ("replay_measurements", "measurement_profiles", "axle_wheels"):
        op.execute(f"DELETE FROM {table} WHERE measurement_id IN ({others})")  # noqa: S608  this file's own words
    op.execute(f"DELETE FROM measurements WHERE id IN ({others})")  # noqa: S608  this file's own words


def _create_unique(name: str, columns: list[str], null: str) -> None:
    where = sa.text(f"rig_calibration_id IS {null}")
    op.create_index(
        name, "measurements", columns, unique=True, sqlite_where=where, postgresql_where=where
    )
