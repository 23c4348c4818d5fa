"""Migration 0011: the code that a run names, reproductions of runs, and epochs of hidden splits."""

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"


def upgrade() -> None:
    """Add the columns and the table; existing runs name no code and reproduce none."""
    with op.batch_alter_table("runs") as table:
        table.add_column(sa.Column("code", sa.JSON, nullable=False, server_default="{}"))
    with op.batch_alter_table("leaderboard_entries") as table:
        table.add_column(sa.Column("reproduces", sa.String(32)))
        table.create_index("entries_by_reproduced", ["reproduces"])
    op.create_table(
        "epochs",
        sa.Column("split", sa.String(100), primary_key=True),
        sa.Column("statement", sa.LargeBinary, nullable=False),
        sa.Column("opened_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("closed_at", sa.DateTime(timezone=True)),
        sa.Column("revealed_at", sa.DateTime(timezone=True)),
        sa.Column("secret", sa.String(64)),
    )


def downgrade() -> None:
    """Drop them."""
    op.drop_table("epochs")
    with op.batch_alter_table("leaderboard_entries") as table:
        table.drop_index("entries_by_reproduced")
        table.drop_column("reproduces")
    with op.batch_alter_table("runs") as table:
        table.drop_column("code")
