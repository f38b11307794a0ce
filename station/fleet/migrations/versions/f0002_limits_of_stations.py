"""The limits that a station judges by, so that the fleet knows what is left to them."""

import sqlalchemy as sa
from alembic import op

revision = "f0002"
down_revision = "f0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column; a station fills it when it is heard next."""
    op.add_column("fleet_stations", sa.Column("limits", sa.JSON, nullable=True))


def downgrade() -> None:
    """Drop it."""
    op.drop_column("fleet_stations", "limits")
