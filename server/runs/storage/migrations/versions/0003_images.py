"""Migration 0003: encodings and sizes in which the images of a run were sent."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Create the table; existing runs have no rows, as theirs are unknown."""
    op.create_table(
        "run_images",
        sa.Column("run_id", sa.String(32), sa.ForeignKey("runs.run_id"), primary_key=True),
        sa.Column("images", sa.String(40), primary_key=True),
    )


def downgrade() -> None:
    """Drop the table."""
    op.drop_table("run_images")
