"""How long a run was away between its streams."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    """Gives runs their time away; those that are there already begin with none."""
    with op.batch_alter_table("runs") as table:
        table.add_column(sa.Column("away", sa.Float, nullable=False, server_default="0"))
        table.add_column(sa.Column("away_until", sa.Float))


def downgrade() -> None:
    """Forgets it."""
    with op.batch_alter_table("runs") as table:
        table.drop_column("away_until")
        table.drop_column("away")
