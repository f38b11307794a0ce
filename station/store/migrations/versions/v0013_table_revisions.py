"""How many transactions have written to each table."""

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the table; a table that is not in it was never written to since."""
    op.create_table(
        "table_revisions",
        sa.Column("name", sa.String, nullable=False),
        sa.Column("number", sa.BigInteger, nullable=False),
        sa.PrimaryKeyConstraint("name", name="pk_table_revisions"),
    )


def downgrade() -> None:
    """Drop it: nothing rests on it but the memory of a running API."""
    op.drop_table("table_revisions")
