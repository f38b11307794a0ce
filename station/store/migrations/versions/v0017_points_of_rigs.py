"""Where the points of a rig's calibration were seen, and where they belong."""

import sqlalchemy as sa
from alembic import op

revision = "0017"
down_revision = "0016"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the table, empty: rigs that were calibrated before have kept no points."""
    op.create_table(
        "rig_calibration_points",
        sa.Column("rig_calibration_id", sa.String, nullable=False),
        sa.Column("sensor", sa.String, nullable=False),
        sa.Column("csv", sa.Text, nullable=False),
        sa.ForeignKeyConstraint(
            ["rig_calibration_id"],
            ["rig_calibrations.id"],
            name="fk_rig_calibration_points_rig_calibration_id",
        ),
        sa.PrimaryKeyConstraint("rig_calibration_id", "sensor", name="pk_rig_calibration_points"),
    )


def downgrade() -> None:
    """Drop it: what a rig was calibrated to does not rest on it."""
    op.drop_table("rig_calibration_points")
