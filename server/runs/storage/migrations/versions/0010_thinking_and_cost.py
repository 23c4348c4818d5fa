"""Migration 0010: the time that agents took for their answers, and what their runs cost as declared."""

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0008"


def upgrade() -> None:
    """Add the columns. Of episodes that have ended before, the time is not known."""
    with op.batch_alter_table("run_episodes") as table:
        table.add_column(sa.Column("thinking_seconds", sa.Float))
        table.add_column(sa.Column("timed_steps", sa.Integer))
    with op.batch_alter_table("leaderboard_entries") as table:
        table.add_column(sa.Column("cost", sa.JSON))


def downgrade() -> None:
    """Drop the columns."""
    with op.batch_alter_table("leaderboard_entries") as table:
        table.drop_column("cost")
    with op.batch_alter_table("run_episodes") as table:
        table.drop_column("timed_steps")
        table.drop_column("thinking_seconds")
