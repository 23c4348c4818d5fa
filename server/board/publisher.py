"""Publishing and withdrawing runs on the leaderboard, and the conditions for it."""

from collections.abc import Mapping

from arramon_server.board.cost import Cost
from arramon_server.board.entries import Entries, PublishedRun, StoredScores
from arramon_server.board.episode_table import EpisodeTable
from arramon_server.board.reproductions import check_reproduction
from arramon_server.closing_times import NEVER_CLOSES, ClosingTimes
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput, Conflict, Forbidden, NotFound, quoted
from arramon_server.runs.accounts.callers import UNAUTHENTICATED, Caller, Role
from arramon_server.runs.results.receipts import Receipts
from arramon_server.runs.results.reports import Report, report_of
from arramon_server.runs.storage.causes import AGENT_FINISHED, FORFEITED, STEP_LIMIT, TIME_LIMIT
from arramon_server.runs.storage.journal import Journal, run_not_found
from arramon_server.runs.storage.records import Run
from arramon_server.visible_text import invisible_part

MAX_NOTE = 500
"""Maximum characters of a note."""

FINISHED = frozenset((AGENT_FINISHED, STEP_LIMIT, TIME_LIMIT))
"""Causes of episodes that were played to their end: neither forfeited nor ended by a server fault."""


class Publisher:
    """Publishes and withdraws runs. Thread-safe.

    Args:
        journal: source of the runs.
        splits: served splits, by name.
        entries: storage of the published runs.
        receipts: creates the receipt that every published run has.
        closing: when the leaderboards of splits close.
    """

    def __init__(
        self,
        journal: Journal,
        splits: Mapping[str, Split],
        entries: Entries,
        receipts: Receipts,
        closing: ClosingTimes = NEVER_CLOSES,
    ) -> None:
        self._journal = journal
        self._splits = splits
        self._entries = entries
        self._receipts = receipts
        self._closing = closing

    def publish(
        self, caller: Caller, run_id: str, note: str, cost: Cost | None = None, reproduces: str | None = None
    ) -> None:
        """Publish an ended run and sign its receipt; if it is listed already, replace its note.

        After the leaderboard of its split has closed, only a host can publish further runs.

        Args:
            caller: the run's participant, or a host.
            run_id: id of the run.
            note: one line of at most MAX_NOTE characters for readers of the leaderboard; may be empty.
            cost: declared cost; None to keep an earlier declaration.
            reproduces: id of the published run that it reproduces; empty for none, None to leave it unchanged.

        Raises:
            NotFound: if the caller can see no such run, or the run to reproduce is not published.
            Forbidden: if the caller is anonymous on a public server, where anyone who reads the run's id on the
                leaderboard could pose as its participant; or if the host has withdrawn the run.
            Conflict: if the leaderboard is closed; if the run is still being played; if the data of its split has
                changed; if the split is for training alone; if the split is hidden and the run lacks some of its
                episodes, as the mean over a few would reveal single scores; if no episode was played to its end; or if
                the run does not reproduce the one that it names (see `check_reproduction`).
            BadInput: if the note is too long, or has more than one line, or a number of the cost is out of range.
        """
        run = self._own(caller, run_id)
        _check_note(note := note.strip())
        if cost is not None:
            cost.check()
        by_host = caller.role is Role.HOST
        entry = self._entries.find(run_id)
        if entry is not None and entry.withdrawn_by_host and not by_host:
            raise _withdrawn_by_host(run_id)
        if not (by_host or _is_listed(entry)):
            self._closing.check_open(run.split, "no runs on it are published")
        # Stored with all episodes: the board leaves out those that are void at the time.
        report = report_of(run, self._journal, self._splits, with_void=True)
        _check_ranked(report, self._splits[run.split])
        _check_whole(report, self._splits[run.split])
        _check_played(report)
        if reproduces:
            self._check_reproduces(report, reproduces)
        self._receipts.of(caller, run_id)
        scores = StoredScores(report.progress, report.table.rows, report.signature)
        episodes = EpisodeTable.from_endings(self._journal.endings(run_id), self._journal.play_digest(run))
        if not self._entries.publish(run_id, note, scores, episodes, by_host=by_host, cost=cost, reproduces=reproduces):
            raise _withdrawn_by_host(run_id)

    def withdraw(self, caller: Caller, run_id: str) -> None:
        """Withdraw a run from the leaderboard. It can be published again; if a host withdrew it, only by a host.

        A host may withdraw a run that is already withdrawn, to keep its participant from publishing it again, or to
        keep it from being listed again when the ban that withdrew it ends.

        Raises:
            NotFound: if the caller can see no such run, or it is not on the leaderboard; for a host, only if it never
                was.
            Forbidden: if the caller is anonymous on a public server.
        """
        self._own(caller, run_id)
        entry, by_host = self._entries.find(run_id), caller.role is Role.HOST
        if entry is None or not (by_host or entry.is_listed):
            raise NotFound(f"run {run_id!r} is not on the leaderboard")
        self._entries.withdraw(run_id, by_host=by_host)

    def _check_reproduces(self, report: Report, reproduced: str) -> None:
        original = self._entries.find(reproduced) if "\0" not in reproduced else None
        if original is None or not original.is_listed:
            raise NotFound(f"there is no run {quoted(reproduced)} on the leaderboard that could be reproduced")
        check_reproduction(
            report.run,
            report.signature,
            original,
            self._entries.scores(reproduced, original.rescored).signature,
            is_original=bool(self._entries.reproductions(report.run.run_id)),
        )

    def _own(self, caller: Caller, run_id: str) -> Run:
        if caller == UNAUTHENTICATED:
            raise Forbidden(
                "authentication required: publishing and withdrawing need a token on this server; ask its host for one"
            )
        run = self._journal.run(run_id)
        if not caller.may_see(run):
            raise run_not_found(run_id)
        return run


def _withdrawn_by_host(run_id: str) -> Forbidden:
    return Forbidden(f"the host has withdrawn run {run_id!r}; only the host can publish it again")


def _is_listed(entry: PublishedRun | None) -> bool:
    return entry is not None and entry.is_listed


def _check_ranked(report: Report, split: Split) -> None:
    if split.training:
        raise Conflict(
            f"run {report.run.run_id!r} is on the split {split.name!r}, which is for training alone; "
            "runs on such splits are not ranked"
        )


def _check_whole(report: Report, split: Split) -> None:
    played, all_ = report.progress.episodes, split.languages[report.run.language]
    if split.hidden and played < all_:
        raise Conflict(
            f"run {report.run.run_id!r} has {played} of {all_} episodes; the split {split.name!r} is hidden, "
            "and only runs of all its episodes can be published"
        )


def _check_played(report: Report) -> None:
    # Runs that only faults of the server left unfinished can be published; they are marked.
    if FORFEITED in report.progress.causes and FINISHED.isdisjoint(report.progress.causes):
        ends = ", ".join(f"{number} {cause}" for cause, number in sorted(report.progress.causes.items()))
        raise Conflict(
            f"run {report.run.run_id!r} has no episode that was played to its end, and only a run with at least one "
            f"can be published; causes of its episodes: {ends}"
        )


def _check_note(note: str) -> None:
    if len(note) > MAX_NOTE:
        raise BadInput(f"the note has {len(note)} characters; at most {MAX_NOTE} are allowed")
    if (part := invisible_part(note)) is not None:
        raise BadInput(f"the note has {part}; expected one line of visible text")
