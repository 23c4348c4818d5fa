"""Migration 0015: tables of the collections of instructions."""

import sqlalchemy as sa
from alembic import op

revision = "0015"
down_revision = "0014"


def upgrade() -> None:
    """Create the tables. There is no way back: it would delete them."""
    _create_workers()
    _create_tasks()
    _create_payments()


def _create_workers() -> None:
    op.create_table(
        "collections",
        sa.Column("name", sa.String(60), primary_key=True),
        sa.Column("kind", sa.String(10), nullable=False),
        sa.Column("language", sa.String(20), nullable=False),
        sa.Column("split", sa.String(100), nullable=False),
        sa.Column("settings", sa.JSON, nullable=False),
        sa.Column("consent", sa.Text, nullable=False),
        sa.Column("consent_hash", sa.String(64), nullable=False),
        sa.Column("state", sa.String(20), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
    )
    op.create_table(
        "collection_workers",
        sa.Column("worker_id", sa.String(32), primary_key=True),
        sa.Column("collection", sa.String(60), sa.ForeignKey("collections.name"), nullable=False),
        sa.Column("role", sa.String(10), nullable=False),
        sa.Column("stages", sa.JSON, nullable=False),
        sa.Column("link_hash", sa.String(64), unique=True),
        sa.Column("external_id", sa.String(200)),
        sa.Column("note", sa.String(200), nullable=False, server_default=""),
        sa.Column("state", sa.String(20), nullable=False),
        sa.Column("consented_at", sa.DateTime(timezone=True)),
        sa.Column("consent_hash", sa.String(64)),
        sa.Column("keep_texts", sa.Boolean),
        sa.Column("screening", sa.JSON, nullable=False),
        sa.Column("placement_passed_at", sa.DateTime(timezone=True)),
        sa.Column("device", sa.JSON, nullable=False),
        sa.Column("email", sa.String(320), nullable=False, server_default=""),
        sa.Column("page_language", sa.String(20), nullable=False, server_default=""),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.UniqueConstraint("collection", "external_id", name="workers_by_external_id"),
    )
    op.create_table(
        "collection_visits",
        sa.Column("visit_id", sa.String(32), primary_key=True),
        sa.Column("worker_id", sa.String(32), sa.ForeignKey("collection_workers.worker_id"), nullable=False),
        sa.Column("study_id", sa.String(200), nullable=False),
        sa.Column("session_id", sa.String(200), nullable=False),
        sa.Column("joined_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("completed_at", sa.DateTime(timezone=True)),
        sa.Column("returned_at", sa.DateTime(timezone=True)),
        sa.UniqueConstraint("worker_id", "study_id", "session_id", name="visits_by_session"),
    )
    op.create_table(
        "collection_sign_ins",
        sa.Column("cookie_hash", sa.String(64), primary_key=True),
        sa.Column("worker_id", sa.String(32), sa.ForeignKey("collection_workers.worker_id"), nullable=False),
        sa.Column("csrf", sa.String(64), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("renewed_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("expires_at", sa.DateTime(timezone=True), nullable=False),
    )
    op.create_index("sign_ins_by_worker", "collection_sign_ins", ["worker_id"])


def _create_tasks() -> None:
    op.create_table(
        "collection_tasks",
        sa.Column("task_id", sa.String(32), primary_key=True),
        sa.Column("collection", sa.String(60), sa.ForeignKey("collections.name"), nullable=False),
        sa.Column("stage", sa.String(10), nullable=False),
        sa.Column("worker_id", sa.String(32), sa.ForeignKey("collection_workers.worker_id"), nullable=False),
        sa.Column("episode_id", sa.String(100), nullable=False),
        sa.Column("text_id", sa.String(32)),
        sa.Column("is_gold", sa.Boolean, nullable=False, server_default=sa.false()),
        sa.Column("state", sa.String(20), nullable=False),
        sa.Column("started_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("seen_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("ended_at", sa.DateTime(timezone=True)),
        sa.Column("active_seconds", sa.Float, nullable=False, server_default="0"),
        sa.Column("submission_id", sa.String(64)),
        sa.Column("run_id", sa.String(32)),
        sa.Column("position", sa.JSON, nullable=False),
    )
    op.create_index("collection_tasks_by_state", "collection_tasks", ["collection", "stage", "state"])
    op.create_index("collection_tasks_by_worker", "collection_tasks", ["worker_id", "state"])
    op.create_table(
        "collection_drafts",
        sa.Column("task_id", sa.String(32), sa.ForeignKey("collection_tasks.task_id"), primary_key=True),
        sa.Column("revision", sa.Integer, nullable=False),
        sa.Column("body", sa.JSON, nullable=False),
        sa.Column("saved_at", sa.DateTime(timezone=True), nullable=False),
    )
    op.create_table(
        "collection_texts",
        sa.Column("text_id", sa.String(32), primary_key=True),
        sa.Column("collection", sa.String(60), sa.ForeignKey("collections.name"), nullable=False),
        sa.Column("task_id", sa.String(32)),
        sa.Column("worker_id", sa.String(32), sa.ForeignKey("collection_workers.worker_id")),
        sa.Column("episode_id", sa.String(100), nullable=False),
        sa.Column("language", sa.String(20), nullable=False),
        sa.Column("instructions", sa.JSON, nullable=False),
        sa.Column("failures", sa.JSON, nullable=False),
        sa.Column("evidence", sa.JSON, nullable=False),
        sa.Column("state", sa.String(20), nullable=False),
        sa.Column("version", sa.Integer, nullable=False),
        sa.Column("history", sa.JSON, nullable=False),
        sa.Column("reason", sa.String(2000), nullable=False, server_default=""),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("reviewed_at", sa.DateTime(timezone=True)),
        sa.Column("reviewed_by", sa.String(32)),
    )
    op.create_index("collection_texts_by_state", "collection_texts", ["collection", "state"])
    op.create_index("collection_texts_by_episode", "collection_texts", ["collection", "episode_id"])
    op.create_table(
        "collection_verifications",
        sa.Column("task_id", sa.String(32), sa.ForeignKey("collection_tasks.task_id"), primary_key=True),
        sa.Column("collection", sa.String(60), sa.ForeignKey("collections.name"), nullable=False),
        sa.Column("text_id", sa.String(32)),
        sa.Column("episode_id", sa.String(100), nullable=False),
        sa.Column("worker_id", sa.String(32), sa.ForeignKey("collection_workers.worker_id"), nullable=False),
        sa.Column("run_id", sa.String(32), nullable=False),
        sa.Column("ndtw", sa.JSON, nullable=False),
        sa.Column("ptc", sa.JSON, nullable=False),
        sa.Column("placed_cells", sa.JSON, nullable=False),
        sa.Column("path", sa.JSON, nullable=False),
        sa.Column("flags", sa.JSON, nullable=False),
        sa.Column("seconds", sa.Float, nullable=False),
        sa.Column("counts", sa.Boolean, nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
    )
    op.create_index("verifications_by_text", "collection_verifications", ["text_id"])
    op.create_index("verifications_by_worker", "collection_verifications", ["worker_id"])


def _create_payments() -> None:
    op.create_table(
        "collection_ledger",
        sa.Column("entry_id", sa.String(32), primary_key=True),
        sa.Column("collection", sa.String(60), sa.ForeignKey("collections.name"), nullable=False),
        sa.Column("worker_id", sa.String(32), sa.ForeignKey("collection_workers.worker_id"), nullable=False),
        sa.Column("kind", sa.String(20), nullable=False),
        sa.Column("subject", sa.String(32), nullable=False),
        sa.Column("amount_minor", sa.Integer, nullable=False),
        sa.Column("currency", sa.String(3), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.UniqueConstraint("collection", "worker_id", "kind", "subject", name="ledger_pays_once"),
    )
    op.create_table(
        "collection_mail",
        sa.Column("mail_id", sa.String(32), primary_key=True),
        sa.Column("collection", sa.String(60), sa.ForeignKey("collections.name"), nullable=False),
        sa.Column("worker_id", sa.String(32), sa.ForeignKey("collection_workers.worker_id"), nullable=False),
        sa.Column("recipient", sa.String(320), nullable=False),
        sa.Column("subject", sa.String(200), nullable=False),
        sa.Column("body", sa.Text, nullable=False),
        sa.Column("state", sa.String(10), nullable=False),
        sa.Column("attempts", sa.Integer, nullable=False, server_default="0"),
        sa.Column("problem", sa.String(500), nullable=False, server_default=""),
        sa.Column("next_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
    )
    op.create_index("collection_mail_by_time", "collection_mail", ["state", "next_at"])
