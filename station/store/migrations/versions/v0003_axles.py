"""Axles of a train, its consist, and the regime that readings were judged by."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add columns and table; of passes measured before, the axles were not worked out."""
    with op.batch_alter_table("passes") as table:
        table.add_column(sa.Column("axles", sa.Integer))
        table.add_column(sa.Column("consist", sa.JSON))
    with op.batch_alter_table("measurements") as table:
        table.add_column(sa.Column("regime", sa.String))
    _create_axle_wheels()


def downgrade() -> None:
    """Drop them; what they say is lost."""
    op.drop_table("axle_wheels")
    with op.batch_alter_table("measurements") as table:
        table.drop_column("regime")
    with op.batch_alter_table("passes") as table:
        table.drop_column("consist")
        table.drop_column("axles")


def _create_axle_wheels() -> None:
    op.create_table(
        "axle_wheels",
        sa.Column("id", sa.Integer, nullable=False),
        sa.Column("pass_id", sa.String, nullable=False),
        sa.Column("place", sa.Integer, nullable=False),
        sa.Column("side", sa.String(16), nullable=False),
        sa.Column("number", sa.Integer),
        sa.Column("placing", sa.String(16), nullable=False),
        sa.Column("passed_at", sa.DateTime(timezone=True)),
        sa.Column("remark", sa.Text),
        sa.Column("measurement_id", sa.Integer),
        sa.Column("others", sa.JSON, nullable=False),
        sa.Column("reason", sa.Text),
        sa.Column("wheelset", sa.String),
        sa.Column("wheelset_side", sa.String(16)),
        sa.Column("vehicle", sa.String),
        sa.Column("position", sa.String),
        sa.Column("jumps", sa.JSON, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_axle_wheels"),
        sa.UniqueConstraint("pass_id", "place", "side", name="uq_axle_wheels_pass_id_place_side"),
        sa.ForeignKeyConstraint(["pass_id"], ["passes.id"], name="fk_axle_wheels_pass_id"),
        sa.ForeignKeyConstraint(
            ["measurement_id"], ["measurements.id"], name="fk_axle_wheels_measurement_id"
        ),
    )
    op.create_index(
        "ix_axle_wheels_wheelset_wheelset_side_id",
        "axle_wheels",
        ["wheelset", "wheelset_side", "id"],
    )
    op.create_index("ix_axle_wheels_measurement_id", "axle_wheels", ["measurement_id"])
