"""Migration 0004: accounts, quotas, clocks, receipts and a leaderboard, for a public service."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    """Create the tables and columns. Existing runs have no owner and no clocks."""
    op.create_table(
        "participants",
        sa.Column("participant", sa.String(100), primary_key=True),
        sa.Column("role", sa.String(20), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
    )
    op.create_table(
        "tokens",
        sa.Column("token_id", sa.String(32), primary_key=True),
        sa.Column("participant", sa.String(100), sa.ForeignKey("participants.participant"), nullable=False),
        sa.Column("hash", sa.String(64), nullable=False, unique=True),
        sa.Column("note", sa.String(200), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("expires_at", sa.DateTime(timezone=True)),
        sa.Column("revoked_at", sa.DateTime(timezone=True)),
    )
    op.create_table(
        "quotas",
        sa.Column("participant", sa.String(100), sa.ForeignKey("participants.participant"), primary_key=True),
        sa.Column("split", sa.String(100), primary_key=True),
        sa.Column("runs_per_day", sa.Integer),
        sa.Column("runs_in_all", sa.Integer),
        sa.Column("runs_at_once", sa.Integer),
        sa.Column("streams_at_once", sa.Integer),
    )
    with op.batch_alter_table("runs") as table:
        table.add_column(
            sa.Column("account", sa.String(100), sa.ForeignKey("participants.participant", name="runs_account_fkey"))
        )
        table.add_column(sa.Column("ended_at", sa.DateTime(timezone=True)))
        table.add_column(sa.Column("active_at", sa.Float))
        table.add_column(sa.Column("step_seconds", sa.Float, nullable=False, server_default="0"))
        table.add_column(sa.Column("first_step_seconds", sa.Float, nullable=False, server_default="0"))
        table.add_column(sa.Column("bank_seconds", sa.Float, nullable=False, server_default="0"))
        table.add_column(sa.Column("bank_left", sa.Float))
        table.create_index("runs_by_account", ["account", "split", "created_at"])
    with op.batch_alter_table("workers") as table:
        table.add_column(sa.Column("host", sa.String(200), nullable=False, server_default=""))
    with op.batch_alter_table("run_episodes") as table:
        table.add_column(sa.Column("reoffers", sa.Integer, nullable=False, server_default="0"))
        table.add_column(sa.Column("faults", sa.Integer, nullable=False, server_default="0"))
        table.add_column(sa.Column("waited", sa.Float, nullable=False, server_default="0"))
    by_fault = sa.text("cause = 'SERVER_FAULT'")
    op.create_index(
        "run_episodes_by_fault", "run_episodes", ["run_id"], sqlite_where=by_fault, postgresql_where=by_fault
    )
    op.create_table(
        "streams",
        sa.Column("stream_id", sa.String(32), primary_key=True),
        sa.Column("run_id", sa.String(32), sa.ForeignKey("runs.run_id"), nullable=False),
        sa.Column("player", sa.String(100), nullable=False),
        sa.Column("worker", sa.String(32), nullable=False),
        sa.Column("opened_at", sa.DateTime(timezone=True), nullable=False),
    )
    op.create_table(
        "host_keys",
        sa.Column("public_key", sa.LargeBinary, primary_key=True),
        sa.Column("since", sa.DateTime(timezone=True), nullable=False),
    )
    op.create_table(
        "receipts",
        sa.Column("run_id", sa.String(32), sa.ForeignKey("runs.run_id"), primary_key=True),
        sa.Column("payload", sa.LargeBinary, nullable=False),
        sa.Column("signature", sa.LargeBinary, nullable=False),
        sa.Column("public_key", sa.LargeBinary, nullable=False),
    )
    op.create_table(
        "leaderboard_entries",
        sa.Column("run_id", sa.String(32), sa.ForeignKey("runs.run_id"), primary_key=True),
        sa.Column("published_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("withdrawn_at", sa.DateTime(timezone=True)),
        sa.Column("withdrawn_by_host", sa.Boolean, nullable=False, server_default=sa.false()),
        sa.Column("note", sa.String(500), nullable=False, server_default=""),
        sa.Column("revision", sa.Integer, nullable=False, server_default="0"),
        sa.Column("scores", sa.JSON, nullable=False),
    )


def downgrade() -> None:
    """Drop the tables and columns."""
    for name in ("leaderboard_entries", "receipts", "host_keys", "streams"):
        op.drop_table(name)
    op.drop_index("run_episodes_by_fault", "run_episodes")
    with op.batch_alter_table("run_episodes") as table:
        for column in ("reoffers", "faults", "waited"):
            table.drop_column(column)
    with op.batch_alter_table("workers") as table:
        table.drop_column("host")
    with op.batch_alter_table("runs") as table:
        table.drop_index("runs_by_account")
        table.drop_constraint("runs_account_fkey", type_="foreignkey")
        for column in (
            "account",
            "ended_at",
            "active_at",
            "step_seconds",
            "first_step_seconds",
            "bank_seconds",
            "bank_left",
        ):
            table.drop_column(column)
    for name in ("quotas", "tokens", "participants"):
        op.drop_table(name)
