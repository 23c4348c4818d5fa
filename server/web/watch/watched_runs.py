"""Which runs and episodes a caller of the pages may watch, and whether the ground truth is shown."""

from collections.abc import Mapping
from dataclasses import dataclass

from arramon_server.board.board import Board
from arramon_server.board.standings import Entry
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split
from arramon_server.errors import NotFound, quoted
from arramon_server.runs.accounts.callers import Caller, Role
from arramon_server.runs.run_service import HUMAN
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import RUNNING, EpisodeEnding, Run


@dataclass(frozen=True, slots=True)
class WatchedRun:
    """A run that a caller may watch.

    Attributes:
        run: the run.
        split: its split; hidden ones are for hosts.
        entry: its entry on the leaderboard; None if it is not published.
        is_own: whether the caller is on the machine of the server, and may see all runs without account there. Who has
            signed in may be playing the run, so it is no reason to show the ground truth early.
    """

    run: Run
    split: Split
    entry: Entry | None
    is_own: bool


@dataclass(frozen=True, slots=True)
class WatchedEpisode:
    """An episode that a caller may watch.

    Attributes:
        watched: its run.
        episode: the episode.
        ending: how it ended; None if it has not.
    """

    watched: WatchedRun
    episode: Episode
    ending: EpisodeEnding | None

    @property
    def run(self) -> Run:
        """Its run."""
        return self.watched.run

    @property
    def is_live(self) -> bool:
        """Whether further steps may come."""
        return self.ending is None and self.run.state == RUNNING

    @property
    def is_played_by_person(self) -> bool:
        """Whether a person is playing it: the maps, too, are then withheld, as a second tab would show them the answer.

        This holds on one's own machine, too, where the person and the viewer may be the same.
        """
        return self.is_live and self.run.agent == HUMAN

    @property
    def shows_truth(self) -> bool:
        """Whether reference path, target and scores are shown.

        Once the episode has ended, as they would help a person who is playing it; those of agents on one's own machine
        always.
        """
        return not self.is_live or (self.watched.is_own and not self.is_played_by_person)


class WatchedRuns:
    """Finds runs and episodes for the callers of the pages.

    Runs of hidden splits are watched by the host alone, once signed in.

    Args:
        splits: the splits served, by name.
        journal: storage of the runs.
        board: the leaderboard.
    """

    def __init__(self, splits: Mapping[str, Split], journal: Journal, board: Board) -> None:
        self._splits = splits
        self._journal = journal
        self._board = board

    def run(self, caller: Caller, run_id: str) -> WatchedRun:
        """Return a run that the caller may watch: a published one, or one that it may see unpublished.

        Raises:
            NotFound: if there is none: the error is the same for one that the caller may not see, as on a hidden split
                all but hosts, whose data has changed, or whose leaderboard is frozen.
        """
        entry = self._published(run_id)
        run = self._journal.run(run_id) if entry is None else entry.run
        sees_all = caller.may_see_withheld(run, published=entry is not None)
        split = self._splits.get(run.split)
        is_shown = sees_all or (entry is not None and not entry.frozen)
        is_withheld = split is not None and split.hidden and caller.role is not Role.HOST
        if not is_shown or split is None or is_withheld or split.data_hash != run.data_hash:
            raise NotFound(f"there is no run {quoted(run_id)} to watch")
        is_own = sees_all and caller.may_list and caller.role is Role.ANONYMOUS
        return WatchedRun(run, split, entry, is_own)

    def episode(self, caller: Caller, run_id: str, episode_id: str) -> WatchedEpisode:
        """Return an episode that the caller may watch.

        Raises:
            NotFound: if there is none, see `run`.
        """
        watched = self.run(caller, run_id)
        episode = watched.split.episodes.get(episode_id)
        state = self._journal.episode_state(run_id, episode_id) if episode is not None else None
        if episode is None or state is None:
            raise NotFound(f"run {run_id!r} has no episode {quoted(episode_id)}")
        return WatchedEpisode(watched, episode, state[1])

    def listed(self, caller: Caller, limit: int) -> list[WatchedRun]:
        """Return the latest runs that the caller may list and watch, published or not; none on a public server."""
        if not caller.may_list:
            return []
        found = list[WatchedRun]()
        for run in self._runs_of(caller, limit):
            try:
                found.append(self.run(caller, run.run_id))
            except NotFound:
                continue  # on a hidden split, for example
        return found

    def others(self, caller: Caller, watched: WatchedRun, limit: int, episode_id: str = "") -> list[Run]:
        """Return other runs on the same data that the caller may watch: its own, then published ones, the latest first.

        Args:
            caller: the caller.
            watched: the run to which they are other.
            limit: maximum number of runs.
            episode_id: an episode that they must have ended; empty for any.
        """
        own = self._runs_of(caller, limit) if caller.may_list else []
        runs = {run.run_id: run for run in (*own, *self._board.runs_on(watched.run.split))}
        runs.pop(watched.run.run_id, None)
        found = [
            run for run in runs.values() if (run.split, run.data_hash) == (watched.run.split, watched.run.data_hash)
        ]
        if episode_id:
            ended = self._journal.ended_in([run.run_id for run in found], episode_id)
            found = [run for run in found if run.run_id in ended]
        return found[:limit]

    def _runs_of(self, caller: Caller, limit: int) -> list[Run]:
        """Return the latest runs of a caller's account; all runs for a host."""
        return self._journal.runs(limit) if caller.role is Role.HOST else self._journal.runs_of(caller.account, limit)

    def _published(self, run_id: str) -> Entry | None:
        try:
            return self._board.entry(run_id)
        except NotFound:
            return None
