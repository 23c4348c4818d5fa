"""The journal: runs, their episodes, and every step ever answered.

Steps are append-only and unique by (run, episode, step). Whatever is in memory elsewhere can be rebuilt from here.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection, Row

from server.errors import NotFound, TakenOver
from server.runs import tables
from server.runs.attendance import Attendance
from server.runs.callers import HOST, Caller, Role
from server.runs.claims import Claims
from server.runs.database import utc
from server.runs.records import ENDED, OPEN, PENDING, RUNNING, Progress, Run
from server.runs.steps import Steps


class Journal(Attendance, Claims, Steps):
    """All runs, with who plays them and their steps. Safe to use from several threads, but for `commit`.

    Args:
        database: where they are kept.
        host: which one this process is on.
    """

    def create(
        self, run: Run, episode_ids: Sequence[str], admit: Callable[[Connection], None] = lambda _: None
    ) -> None:
        """Writes a new run and its episodes, in the order in which they are to be played.

        Args:
            admit: asked first, in the same transaction; what it raises keeps the run out.
        """
        with self._database.write() as connection:
            admit(connection)
            row = {**{name: getattr(run, name) for name in Run.__slots__}, "sensors": list(run.sensors)}
            connection.execute(tables.runs.insert(), [row])
            rows = [
                {"run_id": run.run_id, "episode_id": episode_id, "ordinal": ordinal, "state": PENDING}
                for ordinal, episode_id in enumerate(episode_ids)
            ]
            connection.execute(tables.episodes.insert(), rows)

    def run(self, run_id: str) -> Run:
        """One run.

        Raises:
            NotFound: if there is none with that id.
        """
        if "\0" in run_id:  # PostgreSQL would not even look
            raise no_run(run_id)
        rows = self._database.read(sa.select(tables.runs).where(tables.runs.c.run_id == run_id))
        if not rows:
            raise no_run(run_id)
        return run_of(rows[0])

    def runs(self, limit: int, last: Run | None = None, *, caller: Caller = HOST) -> list[Run]:
        """Runs that a caller may see, the latest first: at most `limit`, from behind run `last` on."""
        table = tables.runs
        query = sa.select(table).order_by(table.c.created_at.desc(), table.c.run_id.desc()).limit(limit)
        if caller.role is not Role.HOST:
            query = query.where(table.c.account == caller.account)
        if last is not None:
            query = query.where(sa.tuple_(table.c.created_at, table.c.run_id) < (last.created_at, last.run_id))
        return [run_of(row) for row in self._database.read(query)]

    def set_state(self, run_id: str, state: str) -> None:
        """A run is over: complete or cancelled. What it became first, it stays."""
        table, values = tables.runs, {"state": state, "ended_at": datetime.now(UTC)}
        with self._database.write() as connection:
            connection.execute(table.update().where(table.c.run_id == run_id, table.c.state == RUNNING).values(values))

    def progress(self, run_id: str) -> Progress:
        """Counts of a run's episodes and steps."""
        table = tables.episodes
        query = (
            sa.select(
                table.c.state,
                table.c.cause,
                sa.func.count().label("number"),
                sa.func.sum(table.c.reoffers).label("reoffers"),
                sa.func.sum(table.c.steps).label("steps"),
            )
            .where(table.c.run_id == run_id)
            .group_by(table.c.state, table.c.cause)
        )
        rows = self._database.read(query)
        causes = {row.cause: row.number for row in rows if row.state == ENDED}
        table = tables.images
        seen = self._database.read(sa.select(table.c.images).where(table.c.run_id == run_id).order_by(table.c.images))
        images = tuple(row.images for row in seen)
        return Progress(
            episodes=sum(row.number for row in rows),
            ended=sum(causes.values()),
            steps=sum(int(row.steps or 0) for row in rows) + self._steps_of_open(run_id),
            causes=causes,
            images=images,
            reoffers=sum(int(row.reoffers) for row in rows),
            published=self.is_published(run_id),
        )

    def _steps_of_open(self, run_id: str) -> int:
        """What was played of the episodes that have not ended. Those that have know it: a run has 400,000 steps."""
        steps, episodes = tables.steps, tables.episodes
        query = sa.select(sa.func.count()).select_from(episodes.join(steps))
        rows = self._database.read(query.where(episodes.c.run_id == run_id, episodes.c.state == OPEN))
        count: int = rows[0][0]
        return count

    def note_images(self, run_id: str, images: str) -> None:
        """A run's images travel in this form, too. Of a run that is over nothing is noted: it stays what it was."""
        table, runs = tables.images, tables.runs
        known = sa.exists().where(table.c.run_id == run_id, table.c.images == images)
        played = sa.exists().where(runs.c.run_id == run_id, runs.c.state == RUNNING)
        row = sa.select(sa.literal(run_id), sa.literal(images)).where(~known, played)
        with suppress(TakenOver), self._database.write() as connection:  # by another worker, which has written the same
            connection.execute(table.insert().from_select(["run_id", "images"], row))

    def count_ended(self, run_id: str) -> int:
        """How many of the run's episodes have ended."""
        return self._count(run_id, tables.episodes.c.state == ENDED)

    def count_unended(self, run_id: str) -> int:
        """How many of the run's episodes have not ended."""
        return self._count(run_id, tables.episodes.c.state != ENDED)

    def is_published(self, run_id: str) -> bool:
        """Whether a run stands on the leaderboard."""
        if "\0" in run_id:  # as in `run`
            return False
        table = tables.entries
        query = sa.select(table.c.run_id).where(table.c.run_id == run_id, table.c.withdrawn_at.is_(None))
        return bool(self._database.read(query))

    def _count(self, run_id: str, condition: sa.ColumnElement[bool]) -> int:
        rows = self._database.read(sa.select(sa.func.count()).where(tables.episodes.c.run_id == run_id, condition))
        count: int = rows[0][0]
        return count


def no_run(run_id: str) -> NotFound:
    """What whoever asks is told of a run that is not there, and of one that is not theirs."""
    return NotFound(f"there is no run {run_id!r}")


def run_of(row: Row[Any]) -> Run:
    """The run that a row holds which has, among others, all columns of the table of runs."""
    values = {name: row._mapping[name] for name in Run.__slots__}
    times = {name: utc(values[name]) for name in ("created_at", "ended_at")}
    return Run(**{**values, **times, "sensors": tuple(values["sensors"])})
