"""The journal: runs, their episodes, and every step ever answered.

Steps are append-only and unique by (run, episode, step). Whatever is in memory elsewhere can be rebuilt from here.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from datetime import UTC, datetime
from operator import attrgetter, itemgetter
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection, Row

from server.errors import NotFound, TakenOver
from server.runs import tables
from server.runs.callers import HOST, Caller, Role
from server.runs.database import Database, utc
from server.runs.here import here
from server.runs.records import ENDED, OPEN, PENDING, RUNNING, Batch, Claim, Ending, Progress, Run

FORGET_SECONDS = 86_400.0
"""After its last sign of life, in which a worker that was killed is not listed any more."""


class Journal:
    """All runs. Safe to use from several threads, but for `commit`, which belongs to one.

    Args:
        database: where they are kept.
        host: which one this process is on: what a host's own addresses are told to.
    """

    def __init__(self, database: Database, *, host: str | None = None) -> None:
        self._database = database
        self._host = here() if host is None else host

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

    def open_claims(self, run_id: str, limit: int | None = None) -> list[Claim]:
        """The run's first episodes that were begun and have not ended."""
        episodes, workers = tables.episodes, tables.workers
        query = (
            sa.select(
                episodes.c.episode_id,
                episodes.c.state,
                episodes.c.player,
                episodes.c.epoch,
                episodes.c.waited,
                workers.c.worker_id,
                # A clock that jumped back leaves times in the future: they are as old as they are far away.
                sa.func.abs(self._database.now - sa.func.coalesce(episodes.c.left, workers.c.seen, 0.0)).label("idle"),
            )
            .outerjoin_from(episodes, workers, episodes.c.worker == workers.c.worker_id)
            .where(episodes.c.run_id == run_id, episodes.c.state == OPEN)
            .order_by(episodes.c.ordinal)
            .limit(limit)
        )
        return [
            Claim(row.episode_id, row.state, row.player, row.epoch, row.worker_id, row.idle, row.waited)
            for row in self._database.read(query)
        ]

    def pending(self, run_id: str, limit: int | None = None) -> list[Claim]:
        """The run's next episodes that nobody has begun."""
        table = tables.episodes
        query = (
            sa.select(table.c.episode_id, table.c.state, table.c.player, table.c.epoch)
            .where(table.c.run_id == run_id, table.c.state == PENDING)
            .order_by(table.c.ordinal)
            .limit(limit)
        )
        return [Claim(row.episode_id, row.state, row.player, row.epoch) for row in self._database.read(query)]

    def claim(
        self, run_id: str, claims: Sequence[Claim], player: str, worker: str, *, reoffered: Collection[str] = ()
    ) -> list[Claim]:
        """Makes episodes `player`'s at a worker, and returns those that were still as `claims` has them.

        Args:
            run_id: of the run.
            claims: as they were read.
            player: the stream's own name.
            worker: this process.
            reoffered: those, by id, that are offered again by the server's fault.
        """
        c = tables.episodes.c

        def these(wanted: Iterable[Claim]) -> sa.ColumnElement[bool]:
            return sa.and_(c.run_id == run_id, c.episode_id.in_([claim.episode_id for claim in wanted]))

        with self._database.write() as connection:
            # Locked before they are looked at: what another process is about to write to them is waited for, and seen.
            query = sa.select(c.episode_id, c.epoch).where(these(claims), c.state != ENDED).order_by(c.episode_id)
            rows = connection.execute(query.with_for_update(key_share=True))
            epochs: dict[str, int] = {row.episode_id: row.epoch for row in rows}
            won = [claim for claim in claims if epochs.get(claim.episode_id) == claim.epoch]
            values = {
                "state": OPEN,
                "player": player,
                "epoch": c.epoch + 1,
                "worker": worker,
                "left": None,
                "waited": 0.0,
            }
            again = [claim for claim in won if claim.episode_id in reoffered]
            if again:
                connection.execute(tables.episodes.update().where(these(again)).values(reoffers=c.reoffers + 1))
            if won:
                # The stream knows now how long its step has waited; what a process that dies forgets is not charged.
                connection.execute(tables.episodes.update().where(these(won)).values(values))
        return [replace(claim, epoch=claim.epoch + 1) for claim in won]

    def release(
        self, run_id: str, epochs: Mapping[str, int], *, ago: float = 0.0, waited: Mapping[str, float] | None = None
    ) -> None:
        """Lets go of open episodes that are still held under these epochs.

        Args:
            run_id: of the run.
            epochs: by episode.
            ago: seconds since their stream left.
            waited: by episode how many seconds the present step's clock had run.
        """
        c, left = tables.episodes.c, self._database.now - ago
        held = sa.and_(c.run_id == run_id, c.episode_id == sa.bindparam("id"), c.epoch == sa.bindparam("held"))
        statement = tables.episodes.update().where(held).values(worker=None, left=left, waited=sa.bindparam("seconds"))
        rows = [
            {"id": episode_id, "held": epoch, "seconds": (waited or {}).get(episode_id, 0.0)}
            for episode_id, epoch in sorted(epochs.items())  # in one order everywhere, as in `commit`
        ]
        if rows:
            with self._database.write() as connection:
                connection.execute(statement, rows)

    def beat(self, worker: str, address: str = "") -> None:
        """A worker is alive, and can be reached on this host at an address of its own, if it has one."""
        table, now = tables.workers, self._database.now
        with self._database.write() as connection:
            done = connection.execute(table.update().where(table.c.worker_id == worker).values(seen=now))
            if not done.rowcount:
                row = {"worker_id": worker, "seen": now, "address": address, "host": self._host}
                connection.execute(table.insert().values(row))
                connection.execute(table.delete().where(table.c.seen < now - FORGET_SECONDS))

    def addresses(self, within: float) -> list[str]:
        """The own addresses of this host's workers that were seen alive in the last `within` seconds."""
        c = tables.workers.c
        alive = sa.func.abs(self._database.now - c.seen) <= within
        query = sa.select(c.address).where(alive, c.host == self._host, c.address != "").order_by(c.address)
        return [row.address for row in self._database.read(query)]

    def retire(self, worker: str) -> None:
        """A worker is gone for good; what it still held is free."""
        table = tables.workers
        with self._database.write() as connection:
            connection.execute(table.delete().where(table.c.worker_id == worker))

    def actions(self, run_id: str, episode_id: str) -> list[int]:
        """The actions recorded for an episode, in order."""
        table = tables.steps
        query = (
            sa.select(table.c.action)
            .where(table.c.run_id == run_id, table.c.episode_id == episode_id)
            .order_by(table.c.step)
        )
        return [row[0] for row in self._database.read(query)]

    def endings(self, run_id: str) -> list[Ending]:
        """The run's ended episodes, in playing order."""
        table = tables.episodes
        query = sa.select(table).where(table.c.run_id == run_id, table.c.state == ENDED).order_by(table.c.ordinal)
        return [
            Ending(run_id, row.episode_id, row.cause, row.steps, row.scores, row.note or "")
            for row in self._database.read(query)
        ]

    def commit(self, batch: Batch) -> None:
        """Writes steps, endings and charges, all or nothing.

        Raises:
            TakenOver: if a step is there already, or a claim is not held any more: another process plays the episode.
            StorageError: if the database cannot be written.
        """
        if not (batch.steps or batch.endings or batch.charges):
            return
        # In one order everywhere: who locks episodes in another waits for whoever waits for them.
        steps = sorted(batch.steps, key=itemgetter("run", "episode", "number"))
        taken_over = "another process of this server has taken over an episode, or it has ended"
        if not (batch.endings or batch.charges):
            if not self._database.commit_rows(_INSERT_STEP, steps, at_once=_INSERT_STEPS):
                raise TakenOver(taken_over)
            return
        with self._database.commit() as connection:
            if steps and connection.execute(_INSERT_STEP, steps).rowcount != len(steps):
                raise TakenOver(taken_over)
            for ending in sorted(batch.endings, key=attrgetter("run_id", "episode_id")):
                values = {name: getattr(ending, name) for name in ("cause", "steps", "scores")}
                values["note"] = ending.note.replace("\0", "")  # PostgreSQL's texts hold none
                done = connection.execute(
                    tables.episodes.update()
                    .where(_is_held(ending.run_id, ending.episode_id, ending.epoch))
                    .values(state=ENDED, **values)
                )
                if not done.rowcount:
                    raise TakenOver(f"another process of this server has taken over episode {ending.episode_id!r}")
            for run_id, seconds in sorted(batch.charges.items()):
                left = tables.runs.c.bank_left
                values = {"bank_left": sa.case((left > seconds, left - seconds), else_=0.0)}
                connection.execute(tables.runs.update().where(tables.runs.c.run_id == run_id).values(values))

    def lost(self, batch: Batch) -> set[tuple[str, str]]:
        """The episodes of a batch, by run and id, that are not held any more under the claims that it names."""
        epochs = {(step["run"], step["episode"]): step["epoch"] for step in batch.steps}
        epochs |= {(ending.run_id, ending.episode_id): ending.epoch for ending in batch.endings}
        c = tables.episodes.c
        query = sa.select(c.run_id, c.episode_id, c.epoch).where(c.state != ENDED)
        rows = self._database.read(query.where(sa.tuple_(c.run_id, c.episode_id).in_(list(epochs))))
        held = {(row.run_id, row.episode_id): row.epoch for row in rows}
        return {key for key, epoch in epochs.items() if held.get(key) != epoch}

    def is_published(self, run_id: str) -> bool:
        """Whether a run stands on the leaderboard."""
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


def _is_held(run_id: Any, episode_id: Any, epoch: Any) -> sa.ColumnElement[bool]:
    """Whether an episode has not ended and nobody has claimed it since."""
    c = tables.episodes.c
    return sa.and_(c.run_id == run_id, c.episode_id == episode_id, c.epoch == epoch, c.state != ENDED)


_INSERT_STEP = (
    tables.steps.insert()
    .from_select(
        ["run_id", "episode_id", "step", "action"],
        sa.select(
            tables.episodes.c.run_id,
            tables.episodes.c.episode_id,
            sa.bindparam("number", type_=sa.Integer),
            sa.bindparam("taken", type_=sa.Integer),
        )
        .where(_is_held(sa.bindparam("run"), sa.bindparam("episode"), sa.bindparam("epoch")))
        .with_for_update(key_share=True),
    )
    .execution_options(preserve_rowcount=True)
)
"""Writes a step under the claim of an epoch, and nothing where that is not held any more.

The episode's row is locked (on PostgreSQL; SQLite has one writer at a time): a claim that is made at the same moment
either waits until the step is written, or is waited for and then found to have taken the episode.
"""

_INSERT_STEPS = sa.text(f"""
    WITH given AS (
        SELECT * FROM unnest(
            CAST(:run AS text[]), CAST(:episode AS text[]), CAST(:epoch AS int[]), CAST(:number AS int[]),
            CAST(:taken AS int[])
        ) AS given (run_id, episode_id, epoch, number, taken)
    ),
    held AS (
        SELECT run_id, episode_id, number, taken FROM given JOIN run_episodes USING (run_id, episode_id, epoch)
        WHERE state != '{ENDED}' ORDER BY run_id, episode_id FOR NO KEY UPDATE OF run_episodes
    )
    INSERT INTO steps (run_id, episode_id, step, action)
    SELECT * FROM held WHERE (SELECT count(*) FROM held) = (SELECT count(*) FROM given)
""").execution_options(preserve_rowcount=True)  # noqa: S608 - of a constant
"""The same for many steps, in one statement of PostgreSQL's: all of them, or none where one is not held any more."""


def run_of(row: Row[Any]) -> Run:
    """The run that a row holds which has, among others, all columns of the table of runs."""
    values = {name: row._mapping[name] for name in Run.__slots__}
    times = {name: utc(values[name]) for name in ("created_at", "ended_at")}
    return Run(**{**values, **times, "sensors": tuple(values["sensors"])})
