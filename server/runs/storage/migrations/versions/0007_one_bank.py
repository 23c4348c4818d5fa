"""Migration 0007: one bank for slow answers and absences, measured by a service clock."""

import time

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"

AWAY_SECONDS = 86_400.0
"""Time for which a run of an earlier version could be away without a charge."""


def upgrade() -> None:
    """Start the service clock, and add what was left of the time of absence to the banks of running runs.

    Times by the wall clock are dropped: the episodes and runs that wait start anew.
    """
    clock = op.create_table(
        "service_clock",
        sa.Column("clock_id", sa.Integer, primary_key=True),
        sa.Column("seconds", sa.Float, nullable=False),
        sa.Column("seen", sa.Float, nullable=False),
    )
    now = time.time()
    op.bulk_insert(clock, [{"clock_id": 1, "seconds": now, "seen": now}])
    op.execute(f"""
        UPDATE runs SET bank_seconds = bank_seconds + {AWAY_SECONDS},
        bank_left = bank_left + CASE WHEN away < {AWAY_SECONDS} THEN {AWAY_SECONDS} - away ELSE 0 END
        WHERE state = 'RUNNING' AND bank_left IS NOT NULL
    """)  # noqa: S608 - the only inserted value is a constant
    op.execute("UPDATE runs SET active_at = NULL, away_until = NULL")
    with op.batch_alter_table("runs") as table:
        table.drop_column("first_step_seconds")
        table.drop_column("away")
    op.execute('UPDATE run_episodes SET "left" = NULL')
    with op.batch_alter_table("run_episodes") as table:
        table.drop_column("waited")
        table.add_column(sa.Column("sent", sa.Float))
        table.add_column(sa.Column("sent_step", sa.Integer))


def downgrade() -> None:
    """Restore the columns with their defaults, and drop the service clock."""
    with op.batch_alter_table("run_episodes") as table:
        table.drop_column("sent_step")
        table.drop_column("sent")
        table.add_column(sa.Column("waited", sa.Float, nullable=False, server_default="0"))
    with op.batch_alter_table("runs") as table:
        table.add_column(sa.Column("away", sa.Float, nullable=False, server_default="0"))
        table.add_column(sa.Column("first_step_seconds", sa.Float, nullable=False, server_default="0"))
    op.drop_table("service_clock")
