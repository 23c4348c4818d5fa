"""Migration 0001: tables of runs, their episodes and steps."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Create the first three tables."""
    op.create_table(
        "runs",
        sa.Column("run_id", sa.String(32), primary_key=True),
        sa.Column("participant", sa.String(100), nullable=False),
        sa.Column("agent", sa.String(200), nullable=False),
        sa.Column("split", sa.String(100), nullable=False),
        sa.Column("language", sa.String(20), nullable=False),
        sa.Column("sensors", sa.JSON, nullable=False),
        sa.Column("steps_per_phase", sa.Integer, nullable=False),
        sa.Column("data_hash", sa.String(64), nullable=False),
        sa.Column("server_version", sa.String(50), nullable=False),
        sa.Column("state", sa.String(20), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
    )
    op.create_table(
        "run_episodes",
        sa.Column("run_id", sa.String(32), sa.ForeignKey("runs.run_id"), primary_key=True),
        sa.Column("episode_id", sa.String(100), primary_key=True),
        sa.Column("ordinal", sa.Integer, nullable=False),
        sa.Column("state", sa.String(20), nullable=False),
        sa.Column("player", sa.String(100)),
        sa.Column("cause", sa.String(20)),
        sa.Column("note", sa.String(500)),
        sa.Column("steps", sa.Integer),
        sa.Column("scores", sa.JSON),
    )
    op.create_index("run_episodes_by_state", "run_episodes", ["run_id", "state", "ordinal"])
    op.create_table(
        "steps",
        sa.Column("run_id", sa.String(32), primary_key=True),
        sa.Column("episode_id", sa.String(100), primary_key=True),
        sa.Column("step", sa.Integer, primary_key=True),
        sa.Column("action", sa.Integer, nullable=False),
        sa.ForeignKeyConstraint(["run_id", "episode_id"], ["run_episodes.run_id", "run_episodes.episode_id"]),
        sqlite_with_rowid=False,
    )


def downgrade() -> None:
    """Drop the tables."""
    for table in ("steps", "run_episodes", "runs"):
        op.drop_table(table)
