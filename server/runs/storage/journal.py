"""The journal: runs and their progress; the whole journal as one class, which inherits steps, claims and notes.

Steps are append-only and unique by (run, episode, step). All state in memory elsewhere can be rebuilt from the journal.
"""

from collections import OrderedDict, defaultdict
from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from threading import Lock
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection, Row

from arramon_server.errors import NotFound, TakenOver, quoted
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.claims import Claims
from arramon_server.runs.storage.corrections import Corrections
from arramon_server.runs.storage.database import Database, utc
from arramon_server.runs.storage.play_digest import play_digest
from arramon_server.runs.storage.records import ENDED, OPEN, PENDING, RUNNING, CodeReference, Run, RunProgress
from arramon_server.runs.storage.step_notes import StepNotes
from arramon_server.runs.storage.steps import Steps
from arramon_server.runs.storage.worker_registry import WorkerRegistry

_KEPT_PLAYS = 1024
"""Number of cached play digests: computing one reads all actions of a run."""


class Journal(WorkerRegistry, Claims, Steps, StepNotes):
    """All runs, with the claims, steps and notes of their episodes. Thread-safe, except for `commit`.

    Args:
        database: storage of the journal.
        host: identity of this process's host, by default `host_identity`.
    """

    def __init__(self, database: Database, *, host: str | None = None) -> None:
        super().__init__(database, host=host)
        self._plays = OrderedDict[str, str]()
        self._plays_lock = Lock()

    def create(
        self, run: Run, episode_ids: Sequence[str], admit: Callable[[Connection], None] = lambda _: None
    ) -> None:
        """Write a new run and its episodes.

        Args:
            run: the new run.
            episode_ids: ids of its episodes, in playing order.
            admit: called first, in the same transaction; an error that it raises prevents the creation.
        """
        with self._database.write() as connection:
            admit(connection)
            row = {name: getattr(run, name) for name in Run.__slots__}
            row |= {"sensors": list(run.sensors), "agent_arguments": [list(pair) for pair in run.agent_arguments]}
            row |= {"code": run.code.named()}
            connection.execute(tables.runs.insert(), [row])
            rows = [
                {"run_id": run.run_id, "episode_id": episode_id, "ordinal": ordinal, "state": PENDING}
                for ordinal, episode_id in enumerate(episode_ids)
            ]
            connection.execute(tables.episodes.insert(), rows)

    def run(self, run_id: str) -> Run:
        """Return the run with an id.

        Raises:
            NotFound: if there is no run with that id.
        """
        if "\0" in run_id:  # PostgreSQL would refuse the query
            raise run_not_found(run_id)
        rows = self._database.read(sa.select(tables.runs).where(tables.runs.c.run_id == run_id))
        if not rows:
            raise run_not_found(run_id)
        return run_of(rows[0])

    def runs(self, limit: int, last: Run | None = None) -> list[Run]:
        """Return at most `limit` runs, the latest first, starting after run `last`."""
        return self._select_runs(limit, last)

    def runs_of(self, account: str | None, limit: int, last: Run | None = None) -> list[Run]:
        """Return at most `limit` runs of an account, the latest first, starting after run `last`.

        Args:
            account: participant who owns the runs; None for the anonymous runs.
            limit: maximum number of runs.
            last: run before the first one to return; None to start with the latest.
        """
        return self._select_runs(limit, last, tables.runs.c.account == account)

    def _select_runs(self, limit: int, last: Run | None, *conditions: sa.ColumnElement[bool]) -> list[Run]:
        table = tables.runs
        query = sa.select(table).where(*conditions)
        query = query.order_by(table.c.created_at.desc(), table.c.run_id.desc()).limit(limit)
        if last is not None:
            query = query.where(sa.tuple_(table.c.created_at, table.c.run_id) < (last.created_at, last.run_id))
        return [run_of(row) for row in self._database.read(query)]

    def play_digest(self, run: Run) -> str:
        """Return the play digest of a run that has ended, see `play_digest`."""
        with self._plays_lock:
            found = self._plays.get(run.run_id)
        if found is None:
            found = play_digest(run, self.endings(run.run_id), self.actions)
            with self._plays_lock:
                self._plays[run.run_id] = found
                while len(self._plays) > _KEPT_PLAYS:
                    self._plays.popitem(last=False)
        return found

    def time(self) -> datetime:
        """Return the current time by the clock that all processes on the database share, in UTC."""
        return datetime.fromtimestamp(self._database.read(sa.select(self._database.now))[0][0], UTC)

    def set_state(self, run_id: str, state: str, ended_at: datetime | None = None) -> None:
        """End a run as complete or cancelled. A run that has ended already is not changed.

        Args:
            run_id: id of the run.
            state: COMPLETE or CANCELLED.
            ended_at: time of the end; None for now. A time before the creation of the run is replaced by the latter.
        """
        table = tables.runs
        ended_at = max(ended_at or self.time(), self.run(run_id).created_at)
        values = {"state": state, "ended_at": ended_at}
        with self._database.write() as connection:
            connection.execute(table.update().where(table.c.run_id == run_id, table.c.state == RUNNING).values(values))

    def voided(self, split: str) -> frozenset[str]:
        """Return the ids of the episodes of a split that its host has voided."""
        return Corrections(self._database).voided(split)

    def ended_runs(self, run_ids: Collection[str]) -> list[Run]:
        """Return which of the given runs have ended."""
        table = tables.runs
        query = sa.select(table).where(table.c.run_id.in_(run_ids), table.c.state != RUNNING)
        return [run_of(row) for row in self._database.read(query)] if run_ids else []

    def progress(self, run_id: str) -> RunProgress:
        """Return the progress of a run."""
        return self.progress_of([run_id])[run_id]

    def progress_of(self, run_ids: Sequence[str]) -> dict[str, RunProgress]:
        """Return the progress of several runs, by run, with as many queries as for one."""
        table = tables.episodes
        query = (
            sa.select(
                table.c.run_id,
                table.c.state,
                table.c.cause,
                sa.func.count().label("number"),
                sa.func.sum(table.c.reoffers).label("reoffers"),
                sa.func.sum(table.c.steps).label("steps"),
                sa.func.sum(table.c.thinking_seconds).label("thinking_seconds"),
                sa.func.sum(table.c.timed_steps).label("timed_steps"),
            )
            .where(table.c.run_id.in_(run_ids))
            .group_by(table.c.run_id, table.c.state, table.c.cause)
        )
        rows, images = _by_run(self._database.read(query)), self._images_of(run_ids)
        open_steps, published = self._steps_of_open(run_ids), self._published(run_ids)
        return {
            run_id: _progress(rows[run_id], open_steps.get(run_id, 0), images[run_id], published=run_id in published)
            for run_id in run_ids
        }

    def _images_of(self, run_ids: Sequence[str]) -> dict[str, tuple[str, ...]]:
        c = tables.images.c
        query = sa.select(c.run_id, c.images).where(c.run_id.in_(run_ids)).order_by(c.images)
        found = _by_run(self._database.read(query))
        return {run_id: tuple(row.images for row in found[run_id]) for run_id in run_ids}

    def _steps_of_open(self, run_ids: Sequence[str]) -> dict[str, int]:
        """Return the number of steps in open episodes, by run. It is stored for ended ones: a run has 400,000 steps."""
        steps, episodes = tables.steps, tables.episodes
        query = sa.select(episodes.c.run_id, sa.func.count().label("number")).select_from(episodes.join(steps))
        query = query.where(episodes.c.run_id.in_(run_ids), episodes.c.state == OPEN).group_by(episodes.c.run_id)
        return {row.run_id: row.number for row in self._database.read(query)}

    def record_image_format(self, run_id: str, images: str) -> None:
        """Record the encoding and size in which images of a run are sent. A run that has ended is not changed."""
        table, runs = tables.images, tables.runs
        known = sa.exists().where(table.c.run_id == run_id, table.c.images == images)
        played = sa.exists().where(runs.c.run_id == run_id, runs.c.state == RUNNING)
        row = sa.select(sa.literal(run_id), sa.literal(images)).where(~known, played)
        with (
            suppress(TakenOver),
            self._database.write() as connection,
        ):  # another worker has written the same row
            connection.execute(table.insert().from_select(["run_id", "images"], row))

    def episode_ids(self, run_id: str) -> list[str]:
        """Return the ids of all episodes of a run, in playing order."""
        c = tables.episodes.c
        query = sa.select(c.episode_id).where(c.run_id == run_id).order_by(c.ordinal)
        return [row.episode_id for row in self._database.read(query)]

    def count_ended(self, run_id: str) -> int:
        """Return the number of a run's episodes that have ended."""
        return self._count(run_id, tables.episodes.c.state == ENDED)

    def count_unended(self, run_id: str) -> int:
        """Return the number of a run's episodes that have not ended."""
        return self._count(run_id, tables.episodes.c.state != ENDED)

    def is_published(self, run_id: str) -> bool:
        """Return whether a run is listed on the leaderboard."""
        if "\0" in run_id:  # as in `run`
            return False
        return bool(self._published([run_id]))

    def _published(self, run_ids: Sequence[str]) -> set[str]:
        table = tables.entries
        query = sa.select(table.c.run_id).where(table.c.run_id.in_(run_ids), table.c.withdrawn_at.is_(None))
        return {row.run_id for row in self._database.read(query)}

    def _count(self, run_id: str, condition: sa.ColumnElement[bool]) -> int:
        rows = self._database.read(sa.select(sa.func.count()).where(tables.episodes.c.run_id == run_id, condition))
        count: int = rows[0][0]
        return count


def run_not_found(run_id: str) -> NotFound:
    """Return the error for a run that does not exist or that the caller may not see, the same for both."""
    return NotFound(f"there is no run {quoted(run_id)}")


def _by_run(rows: Iterable[Row[Any]]) -> defaultdict[str, list[Row[Any]]]:
    found = defaultdict[str, list[Row[Any]]](list)
    for row in rows:
        found[row.run_id].append(row)
    return found


def _progress(
    episodes: Sequence[Row[Any]], open_steps: int, images: tuple[str, ...], *, published: bool
) -> RunProgress:
    causes = {row.cause: row.number for row in episodes if row.state == ENDED}
    return RunProgress(
        episodes=sum(row.number for row in episodes),
        ended=sum(causes.values()),
        steps=sum(int(row.steps or 0) for row in episodes) + open_steps,
        causes=causes,
        images=images,
        reoffers=sum(int(row.reoffers) for row in episodes),
        published=published,
        thinking_seconds=sum(float(row.thinking_seconds or 0.0) for row in episodes),
        timed_steps=sum(int(row.timed_steps or 0) for row in episodes),
    )


def run_of(row: Row[Any]) -> Run:
    """Return the run in a row that has all columns of the table of runs; other columns are ignored."""
    values = {name: row._mapping[name] for name in Run.__slots__}
    times = {name: utc(values[name]) for name in ("created_at", "ended_at")}
    arguments = tuple((name, value) for name, value in values["agent_arguments"])
    plain = {"sensors": tuple(values["sensors"]), "agent_arguments": arguments, "code": CodeReference(**values["code"])}
    return Run(**{**values, **times, **plain})
