"""Rigs: their calibrations, which of them is in force, and what rests on them."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None

_TIME = sa.DateTime(timezone=True)
_RESTING = ("recordings", "measurements")


def upgrade() -> None:
    """Add tables and columns; what was recorded and measured before had no rig."""
    _create_rig_calibrations()
    _create_rig_activations()
    for name in _RESTING:
        with op.batch_alter_table(name) as table:
            table.add_column(sa.Column("rig_calibration_id", sa.String))
            table.create_foreign_key(
                f"fk_{name}_rig_calibration_id",
                "rig_calibrations",
                ["rig_calibration_id"],
                ["id"],
            )
    with op.batch_alter_table("calibration_sessions") as table:
        table.add_column(sa.Column("rig", sa.String))
        table.add_column(sa.Column("targets", sa.JSON))
        table.alter_column("sensor", existing_type=sa.String, nullable=True)


def downgrade() -> None:
    """Drop them; sessions of rigs go with them, what was measured keeps its readings."""
    op.execute(
        "UPDATE recordings SET session_id = NULL WHERE session_id IN "
        "(SELECT id FROM calibration_sessions WHERE sensor IS NULL)"
    )
    op.execute("DELETE FROM calibration_sessions WHERE sensor IS NULL")
    with op.batch_alter_table("calibration_sessions") as table:
        table.alter_column("sensor", existing_type=sa.String, nullable=False)
        table.drop_column("targets")
        table.drop_column("rig")
    for name in _RESTING:
        with op.batch_alter_table(name) as table:
            table.drop_constraint(f"fk_{name}_rig_calibration_id", type_="foreignkey")
            table.drop_column("rig_calibration_id")
    op.drop_table("rig_activations")
    op.drop_table("rig_calibrations")


def _create_rig_calibrations() -> None:
    op.create_table(
        "rig_calibrations",
        sa.Column("id", sa.String, nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("rig", sa.String, nullable=False),
        sa.Column("ordered", sa.JSON),
        sa.Column("created_at", _TIME, nullable=False),
        sa.Column("reason", sa.Text),
        sa.Column("job_id", sa.String),
        sa.Column("document", sa.Text),
        sa.Column("passed", sa.Boolean),
        sa.PrimaryKeyConstraint("id", name="pk_rig_calibrations"),
    )
    op.create_index("ix_rig_calibrations_rig", "rig_calibrations", ["rig"])


def _create_rig_activations() -> None:
    op.create_table(
        "rig_activations",
        sa.Column("id", sa.Integer, nullable=False),
        sa.Column("rig", sa.String, nullable=False),
        sa.Column("version", sa.Integer, nullable=False),
        sa.Column("rig_calibration_id", sa.String, nullable=False),
        sa.Column("activated_at", _TIME, nullable=False),
        sa.Column("activated_by", sa.String, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_rig_activations"),
        sa.UniqueConstraint("rig", "version", name="uq_rig_activations_rig_version"),
        sa.ForeignKeyConstraint(
            ["rig_calibration_id"],
            ["rig_calibrations.id"],
            name="fk_rig_activations_rig_calibration_id",
        ),
    )
