"""Migration 0012: bans and earlier names of participants, and a record of pruned runs."""

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"


def upgrade() -> None:
    """Add the columns and tables; nobody is banned or renamed, and no run was pruned."""
    with op.batch_alter_table("participants") as table:
        table.add_column(sa.Column("banned_at", sa.DateTime(timezone=True)))
        table.add_column(sa.Column("ban_reason", sa.String(500), nullable=False, server_default=""))
    op.create_table(
        "earlier_names",
        sa.Column("name", sa.String(100), primary_key=True),
        sa.Column("participant", sa.String(100), sa.ForeignKey("participants.participant"), nullable=False),
        sa.Column("until", sa.DateTime(timezone=True), nullable=False),
    )
    op.create_table(
        "pruned_runs",
        sa.Column("run_id", sa.String(32), primary_key=True),
        sa.Column("account", sa.String(100), sa.ForeignKey("participants.participant")),
        sa.Column("participant", sa.String(100), nullable=False),
        sa.Column("split", sa.String(100), nullable=False),
        sa.Column("language", sa.String(20), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("had_fault", sa.Boolean, nullable=False),
    )
    op.create_index("pruned_runs_by_account", "pruned_runs", ["account", "split", "created_at"])


def downgrade() -> None:
    """Drop them."""
    op.drop_table("pruned_runs")
    op.drop_table("earlier_names")
    with op.batch_alter_table("participants") as table:
        table.drop_column("ban_reason")
        table.drop_column("banned_at")
