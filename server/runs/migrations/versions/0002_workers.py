"""Who holds an episode: several processes share a journal."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    """Gives claims a worker, an epoch and the time when they were left."""
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
    """Forgets who held what."""
    with op.batch_alter_table("run_episodes") as table:
        for column in ("epoch", "worker", "left"):
            table.drop_column(column)
    op.drop_table("workers")
