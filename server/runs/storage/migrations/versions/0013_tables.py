"""Migration 0013: all tables of the first release.

Development versions came to the same tables in twelve steps. The last step's number stays, so that their latest
journals are opened as they are; journals with a lower number are refused, see `migrations.FIRST`.
"""

import time

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = None


def upgrade() -> None:
    """Create the tables, and start the service clock. There is no way back: it would delete the journal."""
    _create_accounts()
    _create_runs()
    _create_processes()
    _create_leaderboard()
    _create_corrections()


def _create_accounts() -> None:
    op.create_table(
        "participants",
        sa.Column("participant", sa.String(100), primary_key=True),
        sa.Column("role", sa.String(20), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("banned_at", sa.DateTime(timezone=True)),
        sa.Column("ban_reason", sa.String(500), nullable=False, server_default=""),
    )
    op.create_table(
        "earlier_names",
        sa.Column("name", sa.String(100), primary_key=True),
        sa.Column("participant", sa.String(100), sa.ForeignKey("participants.participant"), nullable=False),
        sa.Column("until", sa.DateTime(timezone=True), nullable=False),
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


def _create_runs() -> None:
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
        sa.Column("account", sa.String(100), sa.ForeignKey("participants.participant", name="runs_account_fkey")),
        sa.Column("ended_at", sa.DateTime(timezone=True)),
        sa.Column("active_at", sa.Float),
        sa.Column("step_seconds", sa.Float, nullable=False, server_default="0"),
        sa.Column("bank_seconds", sa.Float, nullable=False, server_default="0"),
        sa.Column("bank_left", sa.Float),
        sa.Column("away_until", sa.Float),
        sa.Column("agent_arguments", sa.JSON, nullable=False, server_default="[]"),
        sa.Column("code", sa.JSON, nullable=False, server_default="{}"),
    )
    op.create_index("runs_by_account", "runs", ["account", "split", "created_at"])
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
        sa.Column("epoch", sa.Integer, nullable=False, server_default="0"),
        sa.Column("worker", sa.String(32)),
        sa.Column("left", sa.Float),
        sa.Column("reoffers", sa.Integer, nullable=False, server_default="0"),
        sa.Column("faults", sa.Integer, nullable=False, server_default="0"),
        sa.Column("sent", sa.Float),
        sa.Column("sent_step", sa.Integer),
        sa.Column("thinking_seconds", sa.Float),
        sa.Column("timed_steps", sa.Integer),
    )
    op.create_index("run_episodes_by_state", "run_episodes", ["run_id", "state", "ordinal"])
    by_fault = sa.text("cause = 'SERVER_FAULT'")
    op.create_index(
        "run_episodes_by_fault", "run_episodes", ["run_id"], sqlite_where=by_fault, postgresql_where=by_fault
    )
    op.create_table(
        "run_images",
        sa.Column("run_id", sa.String(32), sa.ForeignKey("runs.run_id"), primary_key=True),
        sa.Column("images", sa.String(40), primary_key=True),
    )
    op.create_table(
        "steps",
        sa.Column("run_id", sa.String(32), primary_key=True),
        sa.Column("episode_id", sa.String(100), primary_key=True),
        sa.Column("step", sa.Integer, primary_key=True),
        sa.Column("action", sa.Integer, nullable=False),
        sa.ForeignKeyConstraint(["run_id", "episode_id"], ["run_episodes.run_id", "run_episodes.episode_id"]),
        sqlite_with_rowid=False,
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


def _create_processes() -> None:
    op.create_table(
        "workers",
        sa.Column("worker_id", sa.String(32), primary_key=True),
        sa.Column("seen", sa.Float, nullable=False),
        sa.Column("address", sa.String(200), nullable=False),
        sa.Column("host", sa.String(200), nullable=False, server_default=""),
    )
    op.create_table(
        "streams",
        sa.Column("stream_id", sa.String(32), primary_key=True),
        sa.Column("run_id", sa.String(32), sa.ForeignKey("runs.run_id"), nullable=False),
        sa.Column("player", sa.String(100), nullable=False),
        sa.Column("worker", sa.String(32), nullable=False),
        sa.Column("opened_at", sa.DateTime(timezone=True), nullable=False),
    )
    clock = op.create_table(
        "service_clock",
        sa.Column("clock_id", sa.Integer, primary_key=True),
        sa.Column("seconds", sa.Float, nullable=False),
        sa.Column("seen", sa.Float, nullable=False),
    )
    now = time.time()
    op.bulk_insert(clock, [{"clock_id": 1, "seconds": now, "seen": now}])


def _create_leaderboard() -> None:
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
        sa.Column("corrections", sa.Integer, nullable=False, server_default="0"),
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
        sa.Column("episodes", sa.LargeBinary),
        sa.Column("cost", sa.JSON),
        sa.Column("reproduces", sa.String(32)),
    )
    op.create_index("entries_by_reproduced", "leaderboard_entries", ["reproduces"])
    op.create_table(
        "epochs",
        sa.Column("split", sa.String(100), primary_key=True),
        sa.Column("statement", sa.LargeBinary, nullable=False),
        sa.Column("opened_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("closed_at", sa.DateTime(timezone=True)),
        sa.Column("revealed_at", sa.DateTime(timezone=True)),
        sa.Column("secret", sa.String(64)),
    )


def _create_corrections() -> None:
    op.create_table(
        "superseded_receipts",
        sa.Column("run_id", sa.String(32), sa.ForeignKey("runs.run_id"), primary_key=True),
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("superseded_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("payload", sa.LargeBinary, nullable=False),
        sa.Column("signature", sa.LargeBinary, nullable=False),
        sa.Column("public_key", sa.LargeBinary, nullable=False),
    )
    op.create_table(
        "corrections",
        sa.Column("correction_id", sa.String(32), primary_key=True),
        sa.Column("split", sa.String(100), nullable=False),
        sa.Column("number", sa.Integer, nullable=False),
        sa.Column("kind", sa.String(20), nullable=False),
        sa.Column("made_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("reason", sa.String(500), nullable=False),
        sa.Column("episodes", sa.JSON, nullable=False),
        sa.Column("data_before", sa.String(64)),
        sa.Column("data_after", sa.String(64)),
    )
    op.create_index("corrections_by_split", "corrections", ["split", "number"], unique=True)
    op.create_table(
        "rescored_runs",
        sa.Column("run_id", sa.String(32), sa.ForeignKey("runs.run_id"), primary_key=True),
        sa.Column("correction_id", sa.String(32), sa.ForeignKey("corrections.correction_id"), primary_key=True),
    )
