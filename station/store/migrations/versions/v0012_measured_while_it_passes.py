"""How far a recording was measured while it was written, and which readings are not certain yet."""

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create both tables."""
    op.create_table(
        "followings",
        sa.Column("recording_id", sa.String, nullable=False),
        sa.Column("reference", sa.String, nullable=False),
        sa.Column("regime", sa.String, nullable=False),
        sa.Column("software", sa.String, nullable=False),
        sa.Column("part", sa.Integer, nullable=False),
        sa.Column("offset_bytes", sa.BigInteger, nullable=False),
        sa.Column("frames", sa.Integer, nullable=False),
        sa.Column("shown_before", sa.Boolean, nullable=False),
        sa.PrimaryKeyConstraint("recording_id", name="pk_followings"),
        sa.ForeignKeyConstraint(["recording_id"], ["recordings.id"], "fk_followings_recording_id"),
    )
    op.create_table(
        "early_readings",
        sa.Column("measurement_id", sa.Integer, nullable=False),
        sa.PrimaryKeyConstraint("measurement_id", name="pk_early_readings"),
        sa.ForeignKeyConstraint(
            ["measurement_id"], ["measurements.id"], "fk_early_readings_measurement_id"
        ),
    )


def downgrade() -> None:
    """Drop them: finished recordings are measured from their beginning, early readings stand."""
    op.drop_table("early_readings")
    op.drop_table("followings")
