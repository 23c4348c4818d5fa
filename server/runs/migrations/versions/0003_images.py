"""In which form a run's images travelled."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Makes the table of it; of runs that are there already it is not known."""
    op.create_table(
        "run_images",
        sa.Column("run_id", sa.String(32), sa.ForeignKey("runs.run_id"), primary_key=True),
        sa.Column("images", sa.String(40), primary_key=True),
    )


def downgrade() -> None:
    """Forgets it."""
    op.drop_table("run_images")
