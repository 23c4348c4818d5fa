"""Search for runs and their progress, for the host, with a fixed number of queries per `CHUNK` runs."""

from dataclasses import dataclass

import sqlalchemy as sa

from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal, run_of
from arramon_server.runs.storage.records import Run, RunProgress

CHUNK = 500
"""Number of runs whose episodes are counted in one query."""


@dataclass(frozen=True, slots=True)
class RunFilter:
    """Conditions of a search for runs; None for any value.

    Attributes:
        participant: displayed name of the participant.
        split, agent: name of the split or agent.
        state: RUNNING, COMPLETE or CANCELLED.
    """

    participant: str | None = None
    split: str | None = None
    state: str | None = None
    agent: str | None = None


@dataclass(frozen=True, slots=True)
class RunSummary:
    """A run with the number of its episodes and of those that have ended."""

    run: Run
    episodes: int
    ended: int


def find_runs(database: Database, wanted: RunFilter, limit: int) -> list[RunSummary]:
    """Return at most `limit` runs that match a filter, the latest first.

    Raises:
        StorageError: if the journal cannot be read.
    """
    table = tables.runs
    columns = ("participant", "split", "state", "agent")
    conditions = [table.c[name] == getattr(wanted, name) for name in columns if getattr(wanted, name) is not None]
    query = sa.select(table).where(*conditions).order_by(table.c.created_at.desc(), table.c.run_id.desc()).limit(limit)
    runs = [run_of(row) for row in database.read(query)]
    journal, progress = Journal(database), dict[str, RunProgress]()
    for start in range(0, len(runs), CHUNK):
        progress |= journal.progress_of([run.run_id for run in runs[start : start + CHUNK]])
    return [RunSummary(run, progress[run.run_id].episodes, progress[run.run_id].ended) for run in runs]
