"""Puts runs on the leaderboard and takes them off: who may, and which."""

from collections.abc import Mapping

from server.board.entries import Entries, Published, Scores
from server.board.standings import is_control
from server.episodes.splits import Split
from server.errors import BadInput, Conflict, Forbidden, NotFound
from server.runs.callers import STRANGER, Caller, Role
from server.runs.journal import Journal, no_run
from server.runs.receipts import Receipts
from server.runs.records import Run
from server.runs.reports import Report, report_of

MAX_NOTE = 500
"""Characters of a note."""


class Publishing:
    """Publishes and withdraws. Safe to use from several threads.

    Args:
        journal: has the runs.
        splits: what is served, by name.
        entries: what is published.
        receipts: what is published has one.
    """

    def __init__(self, journal: Journal, splits: Mapping[str, Split], entries: Entries, receipts: Receipts) -> None:
        self._journal = journal
        self._splits = splits
        self._entries = entries
        self._receipts = receipts

    def publish(self, caller: Caller, run_id: str, note: str) -> None:
        """Puts a run that is over on the leaderboard, and signs its receipt. A run that is listed gets the new note.

        Args:
            caller: the run's participant, or a host.
            run_id: of the run.
            note: a line of at most MAX_NOTE characters for its readers, or empty.

        Raises:
            NotFound: if there is none of that id that the caller may see.
            Forbidden: for somebody anonymous on a server that is open to everyone, where whoever reads the run's id on
                the leaderboard could pass for its participant; or where the host has withdrawn the run.
            Conflict: while it is being played; if its split's data has changed since; or if the split is hidden and the
                run has not all of its episodes, since the mean over a few of them tells of each.
            BadInput: for a note that is too long, or of more than one line.
        """
        run = self._own(caller, run_id)
        _check_note(note := note.strip())
        by_host = caller.role is Role.HOST
        entry = self._entries.find(run_id)
        if entry is not None and entry.withdrawn_by_host and not by_host:
            raise _withdrawn_by_host(run_id)
        report = report_of(run, self._journal, self._splits)
        _check_whole(report, self._splits[run.split])
        self._receipts.of(caller, run_id)
        scores = Scores(report.progress, report.table.rows, report.signature)
        if not self._entries.publish(run_id, note, scores, by_host=by_host):
            raise _withdrawn_by_host(run_id)

    def withdraw(self, caller: Caller, run_id: str) -> None:
        """Takes a run off the leaderboard. It can be published again; after a host has withdrawn it, by a host alone.

        A host may withdraw what its participant has withdrawn already, so that it does not come back.

        Raises:
            NotFound: if there is none of that id that the caller may see, or it is not on the leaderboard.
            Forbidden: for somebody anonymous on a server that is open to everyone.
        """
        self._own(caller, run_id)
        entry, by_host = self._entries.find(run_id), caller.role is Role.HOST
        if not (_is_listed(entry) or (by_host and entry is not None and not entry.withdrawn_by_host)):
            raise NotFound(f"run {run_id!r} is not on the leaderboard")
        self._entries.withdraw(run_id, by_host=by_host)

    def _own(self, caller: Caller, run_id: str) -> Run:
        if caller == STRANGER:
            raise Forbidden("publishing and withdrawing take a token on this server; ask its host for one")
        run = self._journal.run(run_id)
        if not caller.may_see(run):
            raise no_run(run_id)
        return run


def _withdrawn_by_host(run_id: str) -> Forbidden:
    return Forbidden(f"the host has withdrawn run {run_id!r}; only the host can publish it again")


def _is_listed(entry: Published | None) -> bool:
    return entry is not None and entry.withdrawn_at is None


def _check_whole(report: Report, split: Split) -> None:
    played, all_ = report.progress.episodes, split.languages[report.run.language]
    if split.hidden and played < all_:
        raise Conflict(
            f"run {report.run.run_id!r} has {played} of {all_} episodes; the split {split.name!r} is hidden, "
            f"and only runs of all its episodes can be published"
        )


def _check_note(note: str) -> None:
    if len(note) > MAX_NOTE:
        raise BadInput(f"the note has {len(note)} characters; at most {MAX_NOTE} are allowed")
    if any(is_control(letter) for letter in note):
        raise BadInput("the note holds a line break or a control character; expected one line of text")
