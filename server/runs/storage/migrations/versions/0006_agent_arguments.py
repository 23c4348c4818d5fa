"""Migration 0006: arguments that the agent of a run was created with."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    """Add the agent's arguments to runs; existing runs have none."""
    with op.batch_alter_table("runs") as table:
        table.add_column(sa.Column("agent_arguments", sa.JSON, nullable=False, server_default="[]"))


def downgrade() -> None:
    """Drop the column."""
    with op.batch_alter_table("runs") as table:
        table.drop_column("agent_arguments")
