"""Which calibrations a person refused, and why."""

import sqlalchemy as sa
from alembic import op

revision = "0015"
down_revision = "0014"
branch_labels = None
depends_on = None

_TABLES = ("calibrations", "rig_calibrations")


def upgrade() -> None:
    """Add the columns, empty: nothing was refused before."""
    for table in _TABLES:
        op.add_column(table, sa.Column("refused_at", sa.DateTime(timezone=True), nullable=True))
        op.add_column(table, sa.Column("refused_by", sa.String, nullable=True))
        op.add_column(table, sa.Column("refused_why", sa.Text, nullable=True))


def downgrade() -> None:
    """Drop them; the audit trail still tells of it."""
    for table in _TABLES:
        for column in ("refused_why", "refused_by", "refused_at"):
            op.drop_column(table, column)
