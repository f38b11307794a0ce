"""Who ended a pass or a calibration session, and what the station says of having done it itself."""

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None

_WHO = sa.String(16)  # who may be added later without a migration


def upgrade() -> None:
    """Add the columns; of what ended before, nobody can tell."""
    with op.batch_alter_table("passes") as table:
        table.add_column(sa.Column("ended_by", _WHO))
        table.add_column(sa.Column("ended_why", sa.Text))
    with op.batch_alter_table("calibration_sessions") as table:
        table.add_column(sa.Column("ended_by", _WHO))


def downgrade() -> None:
    """Drop them; the audit trail says the same."""
    with op.batch_alter_table("calibration_sessions") as table:
        table.drop_column("ended_by")
    with op.batch_alter_table("passes") as table:
        table.drop_column("ended_why")
        table.drop_column("ended_by")
