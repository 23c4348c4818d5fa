"""Runs that people play on the pages: created by the same service as those of agents."""

from collections.abc import Mapping, Sequence
from contextlib import suppress

from arramon_server.board.publisher import Publisher
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput, NotFound
from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.run_service import HUMAN, RunService
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import Run
from arramon_server.web.play.aids import Aids
from arramon_server.web.play.practice_split import PRACTICE
from arramon_server.web.play.requests import MAX_EPISODES, NewRun

_RECENT_RUNS = 1000
"""Number of an account's latest runs that are searched for episodes that it has played before."""


class PeopleRuns:
    """Creates and finds the runs of people. Thread-safe.

    Args:
        runs: creates and finds runs.
        journal: source of the episodes that a person has played before.
        publisher: publishes runs.
        aids: aids that the host gives in new runs.
    """

    def __init__(self, runs: RunService, journal: Journal, publisher: Publisher, aids: Aids) -> None:
        self._runs = runs
        self._publisher = publisher
        self._journal = journal
        self._aids = aids

    @property
    def splits(self) -> Mapping[str, Split]:
        """The splits served, by name."""
        return self._runs.splits

    def is_hidden(self, run: Run) -> bool:
        """Return whether the split of a run is hidden."""
        return self._runs.splits[run.split].hidden

    def publish(self, caller: Caller, run: Run) -> None:
        """Put an ended run on the leaderboard.

        Raises:
            ArraMonError: as `Publisher.publish`.
        """
        self._publisher.publish(caller, run.run_id, "")

    def find_or_create(self, caller: Caller, run: str | NewRun) -> Run:
        """Return the run of an id, or a new one.

        Raises:
            ArraMonError: if the run cannot be played or created by the caller.
        """
        if isinstance(run, NewRun):
            return self._create(caller, run)
        found = self._runs.playable_run(caller, run)
        if found.agent != HUMAN:
            raise NotFound(f"run {run!r} is of the agent {found.agent!r}, not of a person")
        return found

    def _create(self, caller: Caller, new: NewRun) -> Run:
        split = self._runs.splits.get(new.split)
        aids = self._aids if split is None else self._aids.offered_with(split.sensors)
        chosen: Sequence[str] = ()
        if split is not None and split.name == PRACTICE:
            chosen = list(split.episodes)[-new.episodes :]  # in the order of the lessons; 0 for all
        elif split is not None and not split.hidden:
            chosen = self._unplayed(caller, split, new)
        return self._runs.create(
            caller,
            participant="" if caller.account else new.participant,
            agent=HUMAN,
            split=new.split,
            language=new.language,
            sensors=aids.sensors,
            episodes=0,
            episode_ids=chosen,
            agent_arguments=aids.as_arguments(),
            by_person=True,
        )

    def _unplayed(self, caller: Caller, split: Split, new: NewRun) -> Sequence[str]:
        """Return the first episodes that a person has not played yet, in playing order, and then the others.

        Raises:
            BadInput: if no episode is requested, or more than there are.
        """
        if not new.episodes:
            raise BadInput(f"episodes is 0, expected 1 to {MAX_EPISODES}")
        before = set[str]()
        for run_id in self._earlier_runs(caller, split, new):
            before.update(self._journal.episode_ids(run_id))
        order = [episode.episode_id for episode in split.in_playing_order(new.language)]
        if order and new.episodes > len(order):
            raise BadInput(f"{new.episodes} episodes were requested; split {split.name!r} has {len(order)}")
        return sorted(order, key=before.__contains__)[: new.episodes]

    def _earlier_runs(self, caller: Caller, split: Split, new: NewRun) -> list[str]:
        """Return the ids of the runs on a split that the caller's account, or else the browser, has played before."""
        if caller.account is not None:
            runs = self._journal.runs_of(caller.account, _RECENT_RUNS)
        else:
            runs = []
            for run_id in new.earlier:
                with suppress(NotFound):  # deleted, or of another server at the same address
                    runs.append(self._runs.visible_run(caller, run_id))
        return [run.run_id for run in runs if (run.agent, run.split) == (HUMAN, split.name)]
