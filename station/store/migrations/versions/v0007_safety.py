"""When keys were used last, what was uploaded, and the answers that repeated calls get again."""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None

_TIME = sa.DateTime(timezone=True)


def upgrade() -> None:
    """Add the columns and the table."""
    with op.batch_alter_table("keys") as table:
        table.add_column(sa.Column("last_used_at", _TIME))
    with op.batch_alter_table("recordings") as table:
        table.add_column(sa.Column("sha256", sa.String))
        table.create_index("ix_recordings_sha256", ["sha256"])
    op.create_table(
        "kept_answers",
        sa.Column("caller", sa.String, nullable=False),
        sa.Column("key", sa.String, nullable=False),
        sa.Column("fingerprint", sa.String, nullable=False),
        sa.Column("asked_at", _TIME, nullable=False),
        sa.Column("status", sa.Integer),
        sa.Column("headers", sa.JSON),
        sa.Column("body", sa.LargeBinary),
        sa.PrimaryKeyConstraint("caller", "key", name="pk_kept_answers"),
    )
    op.create_index("ix_kept_answers_asked_at", "kept_answers", ["asked_at"])


def downgrade() -> None:
    """Drop them; what was uploaded stays."""
    op.drop_table("kept_answers")
    with op.batch_alter_table("recordings") as table:
        table.drop_index("ix_recordings_sha256")
        table.drop_column("sha256")
    with op.batch_alter_table("keys") as table:
        table.drop_column("last_used_at")
