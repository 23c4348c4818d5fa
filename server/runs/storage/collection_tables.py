"""Tables of collections, in which people write and verify instructions. The package `arramon_collecting` uses them.

Every change here needs a migration in `migrations/versions`. Amounts of money are whole numbers of the currency's
smallest unit.
"""

from sqlalchemy import (
    JSON,
    Boolean,
    Column,
    DateTime,
    Float,
    ForeignKey,
    Index,
    Integer,
    String,
    Table,
    Text,
    UniqueConstraint,
    false,
)

from arramon_server.runs.storage.schema_metadata import metadata

collections = Table(
    "collections",
    metadata,
    Column("name", String(60), primary_key=True),
    Column("kind", String(10), nullable=False),
    Column("language", String(20), nullable=False),
    Column("split", String(100), nullable=False),
    Column("settings", JSON, nullable=False),
    Column("consent", Text, nullable=False),
    Column("consent_hash", String(64), nullable=False),
    Column("state", String(20), nullable=False),
    Column("created_at", DateTime(timezone=True), nullable=False),
)

workers = Table(
    "collection_workers",
    metadata,
    Column("worker_id", String(32), primary_key=True),
    Column("collection", String(60), ForeignKey("collections.name"), nullable=False),
    Column("role", String(10), nullable=False),
    Column("stages", JSON, nullable=False),
    Column("link_hash", String(64), unique=True),
    Column("external_id", String(200)),
    Column("note", String(200), nullable=False, server_default=""),
    Column("state", String(20), nullable=False),
    Column("consented_at", DateTime(timezone=True)),
    Column("consent_hash", String(64)),
    Column("keep_texts", Boolean),
    Column("screening", JSON, nullable=False),
    Column("placement_passed_at", DateTime(timezone=True)),
    Column("device", JSON, nullable=False),
    Column("email", String(320), nullable=False, server_default=""),
    Column("page_language", String(20), nullable=False, server_default=""),
    Column("created_at", DateTime(timezone=True), nullable=False),
    UniqueConstraint("collection", "external_id", name="workers_by_external_id"),
)

visits = Table(
    "collection_visits",
    metadata,
    Column("visit_id", String(32), primary_key=True),
    Column("worker_id", String(32), ForeignKey("collection_workers.worker_id"), nullable=False),
    Column("study_id", String(200), nullable=False),
    Column("session_id", String(200), nullable=False),
    Column("joined_at", DateTime(timezone=True), nullable=False),
    Column("completed_at", DateTime(timezone=True)),
    Column("returned_at", DateTime(timezone=True)),
    UniqueConstraint("worker_id", "study_id", "session_id", name="visits_by_session"),
)

sign_ins = Table(
    "collection_sign_ins",
    metadata,
    Column("cookie_hash", String(64), primary_key=True),
    Column("worker_id", String(32), ForeignKey("collection_workers.worker_id"), nullable=False),
    Column("csrf", String(64), nullable=False),
    Column("created_at", DateTime(timezone=True), nullable=False),
    Column("renewed_at", DateTime(timezone=True), nullable=False),
    Column("expires_at", DateTime(timezone=True), nullable=False),
)
Index("sign_ins_by_worker", sign_ins.c.worker_id)

tasks = Table(
    "collection_tasks",
    metadata,
    Column("task_id", String(32), primary_key=True),
    Column("collection", String(60), ForeignKey("collections.name"), nullable=False),
    Column("stage", String(10), nullable=False),
    Column("worker_id", String(32), ForeignKey("collection_workers.worker_id"), nullable=False),
    Column("episode_id", String(100), nullable=False),
    Column("text_id", String(32)),
    Column("is_gold", Boolean, nullable=False, server_default=false()),
    Column("state", String(20), nullable=False),
    Column("started_at", DateTime(timezone=True), nullable=False),
    Column("seen_at", DateTime(timezone=True), nullable=False),
    Column("ended_at", DateTime(timezone=True)),
    Column("active_seconds", Float, nullable=False, server_default="0"),
    Column("submission_id", String(64)),
    Column("run_id", String(32)),
    Column("position", JSON, nullable=False),
)
Index("collection_tasks_by_state", tasks.c.collection, tasks.c.stage, tasks.c.state)
Index("collection_tasks_by_worker", tasks.c.worker_id, tasks.c.state)

drafts = Table(
    "collection_drafts",
    metadata,
    Column("task_id", String(32), ForeignKey("collection_tasks.task_id"), primary_key=True),
    Column("revision", Integer, nullable=False),
    Column("body", JSON, nullable=False),
    Column("saved_at", DateTime(timezone=True), nullable=False),
)

texts = Table(
    "collection_texts",
    metadata,
    Column("text_id", String(32), primary_key=True),
    Column("collection", String(60), ForeignKey("collections.name"), nullable=False),
    Column("task_id", String(32)),
    Column("worker_id", String(32), ForeignKey("collection_workers.worker_id")),
    Column("episode_id", String(100), nullable=False),
    Column("language", String(20), nullable=False),
    Column("instructions", JSON, nullable=False),
    Column("failures", JSON, nullable=False),
    Column("evidence", JSON, nullable=False),
    Column("state", String(20), nullable=False),
    Column("version", Integer, nullable=False),
    Column("history", JSON, nullable=False),
    Column("reason", String(2000), nullable=False, server_default=""),
    Column("created_at", DateTime(timezone=True), nullable=False),
    Column("reviewed_at", DateTime(timezone=True)),
    Column("reviewed_by", String(32)),
)
Index("collection_texts_by_state", texts.c.collection, texts.c.state)
Index("collection_texts_by_episode", texts.c.collection, texts.c.episode_id)

verifications = Table(
    "collection_verifications",
    metadata,
    Column("task_id", String(32), ForeignKey("collection_tasks.task_id"), primary_key=True),
    Column("collection", String(60), ForeignKey("collections.name"), nullable=False),
    Column("text_id", String(32)),
    Column("episode_id", String(100), nullable=False),
    Column("worker_id", String(32), ForeignKey("collection_workers.worker_id"), nullable=False),
    Column("run_id", String(32), nullable=False),
    Column("ndtw", JSON, nullable=False),
    Column("ptc", JSON, nullable=False),
    Column("placed_cells", JSON, nullable=False),
    Column("path", JSON, nullable=False),
    Column("flags", JSON, nullable=False),
    Column("seconds", Float, nullable=False),
    Column("counts", Boolean, nullable=False),
    Column("created_at", DateTime(timezone=True), nullable=False),
)
Index("verifications_by_text", verifications.c.text_id)
Index("verifications_by_worker", verifications.c.worker_id)

ledger = Table(
    "collection_ledger",
    metadata,
    Column("entry_id", String(32), primary_key=True),
    Column("collection", String(60), ForeignKey("collections.name"), nullable=False),
    Column("worker_id", String(32), ForeignKey("collection_workers.worker_id"), nullable=False),
    Column("kind", String(20), nullable=False),
    Column("subject", String(32), nullable=False),
    Column("amount_minor", Integer, nullable=False),
    Column("currency", String(3), nullable=False),
    Column("created_at", DateTime(timezone=True), nullable=False),
    UniqueConstraint("collection", "worker_id", "kind", "subject", name="ledger_pays_once"),
)

mail = Table(
    "collection_mail",
    metadata,
    Column("mail_id", String(32), primary_key=True),
    Column("collection", String(60), ForeignKey("collections.name"), nullable=False),
    Column("worker_id", String(32), ForeignKey("collection_workers.worker_id"), nullable=False),
    Column("recipient", String(320), nullable=False),
    Column("subject", String(200), nullable=False),
    Column("body", Text, nullable=False),
    Column("state", String(10), nullable=False),
    Column("attempts", Integer, nullable=False, server_default="0"),
    Column("problem", String(500), nullable=False, server_default=""),
    Column("next_at", DateTime(timezone=True), nullable=False),
    Column("created_at", DateTime(timezone=True), nullable=False),
)
Index("collection_mail_by_time", mail.c.state, mail.c.next_at)

COLLECTION_TABLES = (collections, workers, visits, sign_ins, tasks, drafts, texts, verifications, ledger, mail)
"""All of these tables, each after those that it refers to."""
