"""Migration 0005: time that the episodes of a run waited for absent players."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    """Add the time of absence to runs; existing runs start with 0."""
    with op.batch_alter_table("runs") as table:
        table.add_column(sa.Column("away", sa.Float, nullable=False, server_default="0"))
        table.add_column(sa.Column("away_until", sa.Float))


def downgrade() -> None:
    """Drop the columns."""
    with op.batch_alter_table("runs") as table:
        table.drop_column("away_until")
        table.drop_column("away")
