"""Migration 0014: notes of steps, and the space that each run has used for them."""

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"


def upgrade() -> None:
    """Create the table of notes. There is no way back: it would delete them."""
    op.create_table(
        "step_notes",
        sa.Column("run_id", sa.String(32), primary_key=True),
        sa.Column("episode_id", sa.String(100), primary_key=True),
        sa.Column("step", sa.Integer, primary_key=True),
        sa.Column("note", sa.Text, nullable=False),
        sa.ForeignKeyConstraint(
            ["run_id", "episode_id", "step"],
            ["steps.run_id", "steps.episode_id", "steps.step"],
            name="step_notes_of_steps",
        ),
        sqlite_with_rowid=False,
    )
    op.add_column("runs", sa.Column("notes_size", sa.Integer, nullable=False, server_default="0"))
