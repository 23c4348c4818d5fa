"""Listing of the notes that agents left beside their steps, for those who may read them."""

from collections.abc import Mapping, Sequence

from arramon_server.closing_times import NEVER_CLOSES, ClosingTimes
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput, Forbidden, NotFound, quoted
from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.storage.journal import Journal, run_not_found
from arramon_server.runs.storage.records import Run, StepNote

PAGE, MAX_PAGE, PAGE_BYTES = 500, 2000, 1 << 20
"""Usual and maximum number of notes on one page, and the size of their texts, in bytes, at which a page ends."""


class RunNotes:
    """Notes of all runs, in pages.

    Args:
        splits: served splits, by name.
        journal: storage of the notes.
        closing: when the leaderboards of splits close.
    """

    def __init__(self, splits: Mapping[str, Split], journal: Journal, closing: ClosingTimes = NEVER_CLOSES) -> None:
        self._splits = splits
        self._journal = journal
        self._closing = closing

    def page(
        self, caller: Caller, run_id: str, episode_id: str = "", size: int = 0, token: str = ""
    ) -> tuple[Sequence[StepNote], str]:
        """Return a page of a run's notes, by episode and step, and the token of the next page; empty on the last.

        Args:
            caller: the run's participant or a host; anyone, if the run is published on a split that is not hidden.
            run_id: id of the run.
            episode_id: only the notes of this episode; empty for all.
            size: maximum number of notes; 0 for PAGE.
            token: token of the page; empty for the first.

        Raises:
            NotFound: if there is no such run that the caller may see, or it has no such episode.
            Forbidden: if the run is published and its split hidden, and the run may be another caller's.
            Conflict: if its leaderboard is frozen, and the run may be another caller's.
            BadInput: if size or token are wrong.
        """
        if not 0 <= size <= MAX_PAGE:
            raise BadInput(f"page_size is {size}, expected 1 to {MAX_PAGE}, or 0 for {PAGE}")
        last = _last_of(token)
        run = self._readable(caller, run_id)
        if episode_id and not ("\0" not in episode_id and self._journal.has_episode(run_id, episode_id)):
            raise NotFound(f"run {run.run_id!r} has no episode {quoted(episode_id)}")
        size = size or PAGE
        found = self._journal.note_page(run.run_id, size + 1, episode_id=episode_id or None, last=last)
        page, room = list[StepNote](), PAGE_BYTES
        for note in found[:size]:
            room -= len(note.text.encode())
            if page and room < 0:
                break
            page.append(note)
        is_last = len(page) == len(found)
        return page, "" if is_last else f"{page[-1].step}:{page[-1].episode_id}"

    def _readable(self, caller: Caller, run_id: str) -> Run:
        """Return a run whose notes the caller may read."""
        published = self._journal.is_published(run_id)
        run = self._journal.run(run_id)
        if caller.may_see_withheld(run, published=published):
            return run
        if not published:
            raise run_not_found(run_id)
        split = self._splits.get(run.split)
        if split is None or split.hidden:
            raise Forbidden(
                f"the notes of run {run_id!r} are private to its participant and hosts: the split {run.split!r} is "
                "hidden or no longer served"
            )
        self._closing.check_shown(run.split)
        return run


def _last_of(token: str) -> tuple[str, int] | None:
    """Return the episode and step of the note before a page; None for the first page."""
    if not token:
        return None
    step, separator, episode_id = token.partition(":")
    if not (separator and step.isascii() and step.isdecimal() and len(step) < 10 and "\0" not in episode_id):
        raise BadInput(f"page_token is {quoted(token)}, expected the next_page_token of the previous page")
    return episode_id, int(step)
