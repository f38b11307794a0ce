"""The first tables: passes, recordings, calibrations, measurements, jobs, keys."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None

_TIME = sa.DateTime(timezone=True)
_STATE = sa.String(16)


def upgrade() -> None:
    """Make the tables, those that others refer to first."""
    _create_passes_and_sessions()
    _create_calibrations()
    _create_recordings()
    _create_measurements()
    _create_jobs()
    _create_keys()


def downgrade() -> None:
    """Drop the tables, and what is in them."""
    for table in (
        "keys",
        "jobs",
        "measurements",
        "recordings",
        "activations",
        "calibration_points",
        "calibrations",
        "calibration_sessions",
        "passes",
    ):
        op.drop_table(table)


def _create_passes_and_sessions() -> None:
    op.create_table(
        "passes",
        sa.Column("id", sa.String, nullable=False),
        sa.Column("state", _STATE, nullable=False),
        sa.Column("train", sa.String),
        sa.Column("opened_at", _TIME, nullable=False),
        sa.Column("finished_at", _TIME),
        sa.Column("reason", sa.Text),
        sa.Column("job_id", sa.String),
        sa.PrimaryKeyConstraint("id", name="pk_passes"),
    )
    op.create_index("ix_passes_state", "passes", ["state"])
    op.create_table(
        "calibration_sessions",
        sa.Column("id", sa.String, nullable=False),
        sa.Column("state", _STATE, nullable=False),
        sa.Column("sensor", sa.String, nullable=False),
        sa.Column("target", sa.String, nullable=False),
        sa.Column("pictures", sa.Integer, nullable=False),
        sa.Column("opened_at", _TIME, nullable=False),
        sa.Column("finished_at", _TIME),
        sa.Column("reason", sa.Text),
        sa.PrimaryKeyConstraint("id", name="pk_calibration_sessions"),
    )
    op.create_index("ix_calibration_sessions_state", "calibration_sessions", ["state"])


def _create_calibrations() -> None:
    op.create_table(
        "calibrations",
        sa.Column("id", sa.String, nullable=False),
        sa.Column("state", _STATE, nullable=False),
        sa.Column("sensor", sa.String, nullable=False),
        sa.Column("target", sa.String, nullable=False),
        sa.Column("method", sa.String, nullable=False),
        sa.Column("recording_ids", sa.JSON, nullable=False),
        sa.Column("created_at", _TIME, nullable=False),
        sa.Column("reason", sa.Text),
        sa.Column("job_id", sa.String, nullable=False),
        sa.Column("document", sa.Text),
        sa.Column("passed", sa.Boolean),
        sa.PrimaryKeyConstraint("id", name="pk_calibrations"),
    )
    op.create_index("ix_calibrations_sensor", "calibrations", ["sensor"])
    op.create_table(
        "calibration_points",
        sa.Column("calibration_id", sa.String, nullable=False),
        sa.Column("csv", sa.Text, nullable=False),
        sa.PrimaryKeyConstraint("calibration_id", name="pk_calibration_points"),
        _foreign_key("calibration_points", "calibration_id", "calibrations"),
    )
    op.create_table(
        "activations",
        sa.Column("id", sa.Integer, nullable=False),
        sa.Column("sensor", sa.String, nullable=False),
        sa.Column("version", sa.Integer, nullable=False),
        sa.Column("calibration_id", sa.String, nullable=False),
        sa.Column("activated_at", _TIME, nullable=False),
        sa.Column("activated_by", sa.String, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_activations"),
        sa.UniqueConstraint("sensor", "version", name="uq_activations_sensor_version"),
        _foreign_key("activations", "calibration_id", "calibrations"),
    )


def _create_recordings() -> None:
    op.create_table(
        "recordings",
        sa.Column("id", sa.String, nullable=False),
        sa.Column("sensor", sa.String, nullable=False),
        sa.Column("pass_id", sa.String),
        sa.Column("session_id", sa.String),
        sa.Column("path", sa.String, nullable=False),
        sa.Column("opened_at", _TIME, nullable=False),
        sa.Column("closed_at", _TIME),
        sa.Column("calibration_id", sa.String),
        sa.Column("expected", sa.Integer),
        sa.Column("recorded", sa.Integer),
        sa.Column("lost", sa.Integer),
        sa.Column("repeated", sa.Integer),
        sa.Column("refused", sa.Integer),
        sa.Column("complete", sa.Boolean),
        sa.Column("recovered", sa.Boolean, nullable=False),
        sa.Column("summary", sa.Text),
        sa.PrimaryKeyConstraint("id", name="pk_recordings"),
        _foreign_key("recordings", "pass_id", "passes"),
        _foreign_key("recordings", "session_id", "calibration_sessions"),
        _foreign_key("recordings", "calibration_id", "calibrations"),
    )
    for column in ("sensor", "pass_id", "session_id", "opened_at"):
        op.create_index(f"ix_recordings_{column}", "recordings", [column])


def _create_measurements() -> None:
    op.create_table(
        "measurements",
        sa.Column("id", sa.Integer, nullable=False),
        sa.Column("recording_id", sa.String, nullable=False),
        sa.Column("frame", sa.Integer, nullable=False),
        sa.Column("calibration_id", sa.String, nullable=False),
        sa.Column("sensor", sa.String, nullable=False),
        sa.Column("pass_id", sa.String),
        sa.Column("reference", sa.String, nullable=False),
        sa.Column("software", sa.String, nullable=False),
        sa.Column("measured_at", _TIME, nullable=False),
        sa.Column("wheel", sa.JSON, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_measurements"),
        sa.UniqueConstraint(
            "recording_id",
            "frame",
            "calibration_id",
            name="uq_measurements_recording_id_frame_calibration_id",
        ),
        _foreign_key("measurements", "recording_id", "recordings"),
        _foreign_key("measurements", "calibration_id", "calibrations"),
        _foreign_key("measurements", "pass_id", "passes"),
    )
    op.create_index("ix_measurements_sensor_id", "measurements", ["sensor", "id"])
    op.create_index("ix_measurements_pass_id_id", "measurements", ["pass_id", "id"])


def _create_jobs() -> None:
    op.create_table(
        "jobs",
        sa.Column("id", sa.String, nullable=False),
        sa.Column("kind", sa.String, nullable=False),
        sa.Column("subject", sa.String, nullable=False),
        sa.Column("state", _STATE, nullable=False),
        sa.Column("progress", sa.Double, nullable=False),
        sa.Column("doing", sa.String, nullable=False),
        sa.Column("error", sa.Text),
        sa.Column("created_at", _TIME, nullable=False),
        sa.Column("started_at", _TIME),
        sa.Column("ended_at", _TIME),
        sa.PrimaryKeyConstraint("id", name="pk_jobs"),
    )
    op.create_index("ix_jobs_state", "jobs", ["state"])


def _create_keys() -> None:
    op.create_table(
        "keys",
        sa.Column("id", sa.String, nullable=False),
        sa.Column("name", sa.String, nullable=False),
        sa.Column("scopes", sa.JSON, nullable=False),
        sa.Column("secret_sha256", sa.String, nullable=False),
        sa.Column("created_at", _TIME, nullable=False),
        sa.Column("expires_at", _TIME),
        sa.Column("revoked_at", _TIME),
        sa.PrimaryKeyConstraint("id", name="pk_keys"),
    )


def _foreign_key(table: str, column: str, target: str) -> sa.ForeignKeyConstraint:
    return sa.ForeignKeyConstraint([column], [f"{target}.id"], name=f"fk_{table}_{column}")
