"""Recalibrations: what was found of each sensor, what was decided, and the reference piece."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None

_TIME = sa.DateTime(timezone=True)


def upgrade() -> None:
    """Create both tables."""
    _create_recalibrations()
    _create_piece_checks()


def downgrade() -> None:
    """Drop them; what was activated stays so, without its reasons."""
    op.drop_table("piece_checks")
    op.drop_table("recalibrations")


def _create_recalibrations() -> None:
    op.create_table(
        "recalibrations",
        sa.Column("id", sa.String, nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("sensor", sa.String, nullable=False),
        sa.Column("due_at", _TIME),
        sa.Column("ordered_at", _TIME, nullable=False),
        sa.Column("ordered_by", sa.String, nullable=False),
        sa.Column("job_id", sa.String, nullable=False),
        sa.Column("ended_at", _TIME),
        sa.Column("taken", sa.JSON),
        sa.Column("pictures_at", _TIME),
        sa.Column("calibration_id", sa.String),
        sa.Column("present_id", sa.String),
        sa.Column("present_version", sa.Integer),
        sa.Column("findings", sa.JSON, nullable=False),
        sa.Column("outcome", sa.String),
        sa.Column("action", sa.String),
        sa.Column("reasons", sa.JSON),
        sa.Column("figures", sa.JSON),
        sa.Column("alarm", sa.Boolean),
        sa.Column("reason", sa.Text),
        sa.Column("activated_version", sa.Integer),
        sa.Column("answered_by", sa.String),
        sa.Column("answered_at", _TIME),
        sa.Column("answer", sa.Text),
        sa.Column("measuring_job_id", sa.String),
        sa.Column("version", sa.Integer, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_recalibrations"),
        sa.UniqueConstraint("sensor", "due_at", name="uq_recalibrations_sensor_due_at"),
        *(
            sa.ForeignKeyConstraint([name], ["calibrations.id"], name=f"fk_recalibrations_{name}")
            for name in ("calibration_id", "present_id")
        ),
    )
    op.create_index("ix_recalibrations_state", "recalibrations", ["state"])
    op.create_index(
        "ix_recalibrations_sensor_ordered_at", "recalibrations", ["sensor", "ordered_at"]
    )


def _create_piece_checks() -> None:
    op.create_table(
        "piece_checks",
        sa.Column("id", sa.Integer, nullable=False),
        sa.Column("sensor", sa.String, nullable=False),
        sa.Column("calibration_id", sa.String, nullable=False),
        sa.Column("recalibration_id", sa.String, nullable=False),
        sa.Column("checked_at", _TIME, nullable=False),
        sa.Column("verdict", sa.String, nullable=False),
        sa.Column("document", sa.Text, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_piece_checks"),
        sa.ForeignKeyConstraint(
            ["calibration_id"], ["calibrations.id"], name="fk_piece_checks_calibration_id"
        ),
        sa.ForeignKeyConstraint(
            ["recalibration_id"], ["recalibrations.id"], name="fk_piece_checks_recalibration_id"
        ),
    )
    for column in ("calibration_id", "recalibration_id"):
        op.create_index(f"ix_piece_checks_{column}", "piece_checks", [column])
