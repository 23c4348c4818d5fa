"""Migration 0013: corrections of splits, the runs that were rescored for them, and the receipts that they supersede."""

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"


def upgrade() -> None:
    """Add the tables, and the column; no split has been corrected yet."""
    with op.batch_alter_table("receipts") as table:
        table.add_column(sa.Column("corrections", sa.Integer, nullable=False, server_default="0"))
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


def downgrade() -> None:
    """Drop them."""
    op.drop_table("rescored_runs")
    op.drop_table("corrections")
    op.drop_table("superseded_receipts")
    with op.batch_alter_table("receipts") as table:
        table.drop_column("corrections")
