"""Tables of the database. Every change here needs a migration in `migrations/versions`."""

from sqlalchemy import (
    JSON,
    Boolean,
    Column,
    DateTime,
    Float,
    ForeignKey,
    ForeignKeyConstraint,
    Index,
    Integer,
    LargeBinary,
    String,
    Table,
    Text,
    false,
)

from arramon_server.runs.storage import collection_tables
from arramon_server.runs.storage.schema_metadata import metadata as metadata

workers = Table(
    "workers",
    metadata,
    Column("worker_id", String(32), primary_key=True),
    Column("seen", Float, nullable=False),
    Column("address", String(200), nullable=False),
    Column("host", String(200), nullable=False, server_default=""),
)

service_clock = Table(
    "service_clock",
    metadata,
    Column("clock_id", Integer, primary_key=True),
    Column("seconds", Float, nullable=False),
    Column("seen", Float, nullable=False),
)

participants = Table(
    "participants",
    metadata,
    Column("participant", String(100), primary_key=True),
    Column("role", String(20), nullable=False),
    Column("created_at", DateTime(timezone=True), nullable=False),
    Column("banned_at", DateTime(timezone=True)),
    Column("ban_reason", String(500), nullable=False, server_default=""),
)

earlier_names = Table(
    "earlier_names",
    metadata,
    Column("name", String(100), primary_key=True),
    Column("participant", String(100), ForeignKey("participants.participant"), nullable=False),
    Column("until", DateTime(timezone=True), nullable=False),
)

tokens = Table(
    "tokens",
    metadata,
    Column("token_id", String(32), primary_key=True),
    Column("participant", String(100), ForeignKey("participants.participant"), nullable=False),
    Column("hash", String(64), nullable=False, unique=True),
    Column("note", String(200), nullable=False),
    Column("created_at", DateTime(timezone=True), nullable=False),
    Column("expires_at", DateTime(timezone=True)),
    Column("revoked_at", DateTime(timezone=True)),
)

quotas = Table(
    "quotas",
    metadata,
    Column("participant", String(100), ForeignKey("participants.participant"), primary_key=True),
    Column("split", String(100), primary_key=True),
    Column("runs_per_day", Integer),
    Column("runs_in_all", Integer),
    Column("runs_at_once", Integer),
    Column("streams_at_once", Integer),
)

runs = Table(
    "runs",
    metadata,
    Column("run_id", String(32), primary_key=True),
    Column("account", String(100), ForeignKey("participants.participant")),
    Column("participant", String(100), nullable=False),
    Column("agent", String(200), nullable=False),
    Column("split", String(100), nullable=False),
    Column("language", String(20), nullable=False),
    Column("sensors", JSON, nullable=False),
    Column("steps_per_phase", Integer, nullable=False),
    Column("data_hash", String(64), nullable=False),
    Column("server_version", String(50), nullable=False),
    Column("state", String(20), nullable=False),
    Column("created_at", DateTime(timezone=True), nullable=False),
    Column("ended_at", DateTime(timezone=True)),
    Column("active_at", Float),
    Column("step_seconds", Float, nullable=False, server_default="0"),
    Column("bank_seconds", Float, nullable=False, server_default="0"),
    Column("bank_left", Float),
    Column("away_until", Float),
    Column("agent_arguments", JSON, nullable=False, server_default="[]"),
    Column("code", JSON, nullable=False, server_default="{}"),
    Column("notes_size", Integer, nullable=False, server_default="0"),
)
Index("runs_by_account", runs.c.account, runs.c.split, runs.c.created_at)

pruned_runs = Table(
    "pruned_runs",
    metadata,
    Column("run_id", String(32), primary_key=True),
    Column("account", String(100), ForeignKey("participants.participant")),
    Column("participant", String(100), nullable=False),
    Column("split", String(100), nullable=False),
    Column("language", String(20), nullable=False),
    Column("created_at", DateTime(timezone=True), nullable=False),
    Column("had_fault", Boolean, nullable=False),
)
Index("pruned_runs_by_account", pruned_runs.c.account, pruned_runs.c.split, pruned_runs.c.created_at)

streams = Table(
    "streams",
    metadata,
    Column("stream_id", String(32), primary_key=True),
    Column("run_id", String(32), ForeignKey("runs.run_id"), nullable=False),
    Column("player", String(100), nullable=False),
    Column("worker", String(32), nullable=False),
    Column("opened_at", DateTime(timezone=True), nullable=False),
)

episodes = Table(
    "run_episodes",
    metadata,
    Column("run_id", String(32), ForeignKey("runs.run_id"), primary_key=True),
    Column("episode_id", String(100), primary_key=True),
    Column("ordinal", Integer, nullable=False),
    Column("state", String(20), nullable=False),
    Column("player", String(100)),
    Column("cause", String(20)),
    Column("note", String(500)),
    Column("steps", Integer),
    Column("scores", JSON),
    Column("epoch", Integer, nullable=False, server_default="0"),
    Column("worker", String(32)),
    Column("left", Float),
    Column("reoffers", Integer, nullable=False, server_default="0"),
    Column("faults", Integer, nullable=False, server_default="0"),
    Column("sent", Float),
    Column("sent_step", Integer),
    Column("thinking_seconds", Float),
    Column("timed_steps", Integer),
)
Index("run_episodes_by_state", episodes.c.run_id, episodes.c.state, episodes.c.ordinal)
Index(
    "run_episodes_by_fault",
    episodes.c.run_id,
    sqlite_where=episodes.c.cause == "SERVER_FAULT",
    postgresql_where=episodes.c.cause == "SERVER_FAULT",
)

images = Table(
    "run_images",
    metadata,
    Column("run_id", String(32), ForeignKey("runs.run_id"), primary_key=True),
    Column("images", String(40), primary_key=True),
)

steps = Table(
    "steps",
    metadata,
    Column("run_id", String(32), primary_key=True),
    Column("episode_id", String(100), primary_key=True),
    Column("step", Integer, primary_key=True),
    Column("action", Integer, nullable=False),
    ForeignKeyConstraint(["run_id", "episode_id"], ["run_episodes.run_id", "run_episodes.episode_id"]),
    sqlite_with_rowid=False,
)

step_notes = Table(
    "step_notes",
    metadata,
    Column("run_id", String(32), primary_key=True),
    Column("episode_id", String(100), primary_key=True),
    Column("step", Integer, primary_key=True),
    Column("note", Text, nullable=False),
    ForeignKeyConstraint(
        ["run_id", "episode_id", "step"], ["steps.run_id", "steps.episode_id", "steps.step"], name="step_notes_of_steps"
    ),
    sqlite_with_rowid=False,
)

host_keys = Table(
    "host_keys",
    metadata,
    Column("public_key", LargeBinary, primary_key=True),
    Column("since", DateTime(timezone=True), nullable=False),
)

receipts = Table(
    "receipts",
    metadata,
    Column("run_id", String(32), ForeignKey("runs.run_id"), primary_key=True),
    Column("payload", LargeBinary, nullable=False),
    Column("signature", LargeBinary, nullable=False),
    Column("public_key", LargeBinary, nullable=False),
    Column("corrections", Integer, nullable=False, server_default="0"),
)

superseded_receipts = Table(
    "superseded_receipts",
    metadata,
    Column("run_id", String(32), ForeignKey("runs.run_id"), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("superseded_at", DateTime(timezone=True), nullable=False),
    Column("payload", LargeBinary, nullable=False),
    Column("signature", LargeBinary, nullable=False),
    Column("public_key", LargeBinary, nullable=False),
)

corrections = Table(
    "corrections",
    metadata,
    Column("correction_id", String(32), primary_key=True),
    Column("split", String(100), nullable=False),
    Column("number", Integer, nullable=False),
    Column("kind", String(20), nullable=False),
    Column("made_at", DateTime(timezone=True), nullable=False),
    Column("reason", String(500), nullable=False),
    Column("episodes", JSON, nullable=False),
    Column("data_before", String(64)),
    Column("data_after", String(64)),
)
Index("corrections_by_split", corrections.c.split, corrections.c.number, unique=True)

rescored_runs = Table(
    "rescored_runs",
    metadata,
    Column("run_id", String(32), ForeignKey("runs.run_id"), primary_key=True),
    Column("correction_id", String(32), ForeignKey("corrections.correction_id"), primary_key=True),
)

entries = Table(
    "leaderboard_entries",
    metadata,
    Column("run_id", String(32), ForeignKey("runs.run_id"), primary_key=True),
    Column("published_at", DateTime(timezone=True), nullable=False),
    Column("withdrawn_at", DateTime(timezone=True)),
    Column("withdrawn_by_host", Boolean, nullable=False, server_default=false()),
    Column("note", String(500), nullable=False, server_default=""),
    Column("revision", Integer, nullable=False, server_default="0"),
    Column("scores", JSON, nullable=False),
    Column("episodes", LargeBinary),
    Column("cost", JSON),
    Column("reproduces", String(32)),  # no foreign key: rows are imported in any order
)
Index("entries_by_reproduced", entries.c.reproduces)

epochs = Table(
    "epochs",
    metadata,
    Column("split", String(100), primary_key=True),
    Column("statement", LargeBinary, nullable=False),
    Column("opened_at", DateTime(timezone=True), nullable=False),
    Column("closed_at", DateTime(timezone=True)),
    Column("revealed_at", DateTime(timezone=True)),
    Column("secret", String(64)),
)

collections = collection_tables.COLLECTION_TABLES
"""Tables of the collections of instructions, each after those that it refers to."""
