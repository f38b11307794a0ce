"""Recordings of several files, and those whose files were deleted."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the columns; recordings made before have one file each."""
    with op.batch_alter_table("recordings") as table:
        table.add_column(sa.Column("files", sa.Integer))
        table.add_column(sa.Column("deleted_at", sa.DateTime(timezone=True)))
        table.add_column(sa.Column("deleted_why", sa.Text))
    op.execute("UPDATE recordings SET files = 1 WHERE closed_at IS NOT NULL")


def downgrade() -> None:
    """Drop the columns; what they say is lost."""
    with op.batch_alter_table("recordings") as table:
        for name in ("deleted_why", "deleted_at", "files"):
            table.drop_column(name)
