"""A host's corrections of a split: voiding episodes, rescoring runs on corrected data, and signing new receipts."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace

import sqlalchemy as sa

from arramon_server.board.entries import Entries, StoredScores
from arramon_server.board.episode_table import EpisodeTable
from arramon_server.episodes.split_changes import EpisodeChanges, changes_between, describe_episodes
from arramon_server.episodes.splits import Split, check_split
from arramon_server.errors import BadInput, Conflict, NotFound
from arramon_server.runs.play.worlds import Worlds
from arramon_server.runs.results.receipts import Receipts
from arramon_server.runs.results.reports import make_report
from arramon_server.runs.results.rescoring import check_same_states, replay_ending
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.corrections import MAX_REASON, Correction, CorrectionKind, Corrections
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.epoch_store import EpochStore
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import RUNNING, EpisodeEnding, Run
from arramon_server.visible_text import invisible_part


class AlreadyCorrected(Conflict):
    """All the episodes are void already or, when restoring, none of them is void."""


@dataclass(frozen=True, slots=True)
class RescoredRun:
    """Result of rescoring one run after its split's data was corrected.

    Attributes:
        run: the run, before it was rescored.
        problem: why it could not be rescored; empty if it was.
        changed: number of its episodes whose scores changed.
        has_new_receipt: whether a new receipt supersedes an earlier one.
    """

    run: Run
    problem: str = ""
    changed: int = 0
    has_new_receipt: bool = False


class Corrector:
    """Corrects splits. Servers may be running, but only one process may correct at a time.

    Args:
        database: storage of the runs.
        splits: splits with their current data, by name.
        key: key that signs the new receipts.
    """

    def __init__(self, database: Database, splits: Mapping[str, Split], key: SigningKey) -> None:
        self._database = database
        self._splits = splits
        self._journal = Journal(database)
        self._entries = Entries(database)
        self._corrections = Corrections(database)
        self._receipts = Receipts(database, splits, key)

    def void(self, split: str, episode_ids: Collection[str], reason: str, *, restore: bool = False) -> Correction:
        """Void episodes of a split for all its runs, past and future, or let them count again.

        Receipts are not touched; call `renew_receipts` afterwards.

        Args:
            split: name of the split.
            episode_ids: ids of the episodes, at least one.
            reason: one line for readers of the leaderboard.
            restore: whether void episodes count again instead.

        Raises:
            NotFound: if there is no such split or episode.
            AlreadyCorrected: if all episodes are void already or, when restoring, none of them is void.
            Conflict: if that is true of some of them, or if no episode would be left in a language.
            BadInput: if the reason is empty or too long.
        """
        reason = _clean_reason(reason)
        check_split(self._splits, split)
        found = self._splits[split]
        requested = frozenset(episode_ids)
        if unknown := sorted(requested - found.episodes.keys()):
            raise NotFound(f"split {split!r} has no episode {unknown[0]!r}")
        void = self._corrections.voided(split)
        wrong = requested - void if restore else requested & void
        if wrong:
            kind = AlreadyCorrected if wrong == requested else Conflict
            raise kind(f"{describe_episodes(wrong)} of split {split!r} {'not void' if restore else 'void already'}")
        left = found.episodes.keys() - requested - void
        if not restore and any(
            not any(language in found.episodes[name].instructions for name in left) for language in found.languages
        ):
            raise Conflict(f"no episode of split {split!r} would be left in a language; expected at least one")
        return self._corrections.add(
            split, CorrectionKind.RESTORE if restore else CorrectionKind.VOID, reason, requested
        )

    def renew_receipts(self, split: str) -> int:
        """Sign new receipts for all runs of a split whose receipts are outdated by corrections; return their number."""
        return sum(self._receipts.renew(run) for run in self._runs_on(split))

    def rescore(self, before: Split, reason: str) -> Iterator[RescoredRun]:
        """Rescore all runs that were played on a split's former data on its current data; yield the result of each.

        Only ground truths and texts may have changed: a run cannot be scored in a world that it was not played in.
        Episodes whose world changed must be void. After an interruption, the next call continues with the remaining
        runs.

        Args:
            before: the split with its former data.
            reason: one line for readers of the leaderboard.

        Raises:
            NotFound: if there is no split of that name now.
            Conflict: if nothing changed; if the world of an episode that is not void changed; if the set of episodes
                changed; or if the split is an epoch, to whose data the host has committed.
            BadInput: if the reason is empty or too long.
        """
        reason, name = _clean_reason(reason), before.name
        check_split(self._splits, name)
        after = self._splits[name]
        if before.data_hash == after.data_hash:
            raise Conflict(f"the data of split {name!r} has not changed: both are {after.data_hash[:12]}")
        if EpochStore(self._database).find(name) is not None:
            raise Conflict(
                f"split {name!r} is an epoch: the host has committed to its data, which cannot be corrected; void the "
                f"episodes that are wrong (`arramon-server void {name} EPISODE`)"
            )
        changes = changes_between(before, after)
        if changed_worlds := changes.world - self._corrections.voided(name):
            raise Conflict(
                f"the world of {describe_episodes(changed_worlds)} of split {name!r} has changed since they were "
                "played, so their actions cannot be scored in it; void these episodes first (`arramon-server void`), "
                "or leave the runs without a rank"
            )
        return self._rescore(before, after, changes, reason)

    def _rescore(self, before: Split, after: Split, changes: EpisodeChanges, reason: str) -> Iterator[RescoredRun]:
        correction = self._correction(before, after, changes, reason)
        with closing(Worlds({after.name: after})) as worlds:
            for run in self._runs_on(after.name):
                if run.data_hash != before.data_hash:
                    if run.data_hash == after.data_hash:
                        self._receipts.renew(run)  # an earlier call may have stopped before it
                    continue
                if run.state == RUNNING:
                    yield RescoredRun(run, "it is still being played")
                    continue
                endings = self._journal.endings(run.run_id)
                try:
                    scored = [self._scored(run, before, after, changes, one, worlds) for one in endings]
                except (KeyError, ValueError) as error:
                    yield RescoredRun(run, f"it cannot be replayed: {error}")
                    continue
                self._write(run, after, correction, scored)
                changed = sum(one.scores != other.scores for one, other in zip(endings, scored, strict=True))
                has_new_receipt = self._receipts.renew(replace(run, data_hash=after.data_hash))
                yield RescoredRun(run, "", changed, has_new_receipt)

    def _correction(self, before: Split, after: Split, changes: EpisodeChanges, reason: str) -> Correction:
        """Return the record of this correction of the data, which an interrupted earlier call may have written.

        Only the latest correction can be continued: each correction rescores a run once, and data that was corrected,
        reverted and corrected again needs a new one.
        """
        data = (before.data_hash, after.data_hash)
        made = [one for one in self._corrections.on(after.name) if one.kind is CorrectionKind.RESCORE]
        if made and (made[-1].data_before, made[-1].data_after) == data:
            return made[-1]
        return self._corrections.add(after.name, CorrectionKind.RESCORE, reason, changes.all, data)

    def _scored(
        self, run: Run, before: Split, after: Split, changes: EpisodeChanges, ending: EpisodeEnding, worlds: Worlds
    ) -> EpisodeEnding:
        """Return the ending of an episode, scored on the current data.

        Raises:
            ValueError: if replaying the recorded actions does not give the recorded result.
        """
        name = ending.episode_id
        if name not in changes.truth or name in changes.world:
            return ending
        again = replay_ending(run, after, ending, worlds, self._journal.actions)
        if (again.cause, again.steps) != (ending.cause, ending.steps):
            raise ValueError(
                f"episode {name} ended by {ending.cause} after {ending.steps} steps, and would by {again.cause} after "
                f"{again.steps}"
            )
        check_same_states(run, before, after, ending, worlds, self._journal.actions)
        return again

    def _write(self, run: Run, after: Split, correction: Correction, endings: Sequence[EpisodeEnding]) -> None:
        """Write the new scores of a run in one transaction."""
        now = replace(run, data_hash=after.data_hash)
        play = self._journal.play_digest(run)
        report = make_report(now, self._journal.progress(run.run_id), endings, after, play)
        scores = StoredScores(report.progress, report.table.rows, report.signature)
        runs, episodes, receipts = tables.runs, tables.episodes, tables.receipts
        with self._database.write() as connection:
            this_run = sa.and_(runs.c.run_id == run.run_id, runs.c.data_hash == run.data_hash)
            if not connection.execute(runs.update().where(this_run).values(data_hash=after.data_hash)).rowcount:
                raise Conflict(f"another process is scoring run {run.run_id!r} again")
            for ending in endings:
                this_episode = sa.and_(episodes.c.run_id == run.run_id, episodes.c.episode_id == ending.episode_id)
                connection.execute(episodes.update().where(this_episode).values(scores=ending.scores))
            self._corrections.note_rescored(connection, run.run_id, correction)
            self._entries.rescore(connection, run.run_id, scores, EpisodeTable.from_endings(endings, play))
            outdated = sa.and_(receipts.c.run_id == run.run_id, receipts.c.corrections >= correction.number)
            connection.execute(receipts.update().where(outdated).values(corrections=correction.number - 1))

    def _runs_on(self, split: str) -> list[Run]:
        """Return the runs of a split, the latest first."""
        found, last = [], None
        while page := self._journal.runs(1000, last):
            found += [run for run in page if run.split == split]
            last = page[-1]
        return found


def _clean_reason(reason: str) -> str:
    reason = reason.strip()
    if not reason or len(reason) > MAX_REASON:
        raise BadInput(f"the reason has {len(reason)} characters; expected one line of 1 to {MAX_REASON}")
    if (found := invisible_part(reason)) is not None:
        raise BadInput(f"the reason contains {found}; expected one line of visible characters")
    return reason
