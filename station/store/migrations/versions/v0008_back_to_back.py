"""The distance between the flange backs of axles."""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column; axles kept before have none."""
    with op.batch_alter_table("axle_wheels") as table:
        table.add_column(sa.Column("back_to_back", sa.JSON))


def downgrade() -> None:
    """Drop it; what wheels keep of their flange backs stays."""
    with op.batch_alter_table("axle_wheels") as table:
        table.drop_column("back_to_back")
