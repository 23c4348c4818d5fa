"""Migration 0002: workers and the holders of claims, for several processes on one journal."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    """Create the table of workers; add worker, epoch and time of release to claims."""
    op.create_table(
        "workers",
        sa.Column("worker_id", sa.String(32), primary_key=True),
        sa.Column("seen", sa.Float, nullable=False),
        sa.Column("address", sa.String(200), nullable=False),
    )
    with op.batch_alter_table("run_episodes") as table:
        table.add_column(sa.Column("epoch", sa.Integer, nullable=False, server_default="0"))
        table.add_column(sa.Column("worker", sa.String(32)))
        table.add_column(sa.Column("left", sa.Float))


def downgrade() -> None:
    """Drop the table and the columns."""
    with op.batch_alter_table("run_episodes") as table:
        for column in ("epoch", "worker", "left"):
            table.drop_column(column)
    op.drop_table("workers")
