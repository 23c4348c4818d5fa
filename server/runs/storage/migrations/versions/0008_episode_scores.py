"""Migration 0008: scores of all episodes of a published run, in one compact column."""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"


def upgrade() -> None:
    """Add the column; the leaderboard fills it for existing entries when it first compares them."""
    with op.batch_alter_table("leaderboard_entries") as table:
        table.add_column(sa.Column("episodes", sa.LargeBinary))


def downgrade() -> None:
    """Drop the column."""
    with op.batch_alter_table("leaderboard_entries") as table:
        table.drop_column("episodes")
