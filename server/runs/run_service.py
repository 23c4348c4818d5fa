"""Operations on runs except play: create, list, cancel, report."""

import uuid
from collections.abc import Mapping, Sequence
from dataclasses import replace

from sqlalchemy.engine import Connection

from arramon_server import __version__
from arramon_server.closing_times import NEVER_CLOSES, ClosingTimes
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput, Conflict, Forbidden, NotFound, quoted
from arramon_server.runs.accounts.accounts import ANONYMOUS_NAME, Accounts, check_name
from arramon_server.runs.accounts.administration import check_may_act
from arramon_server.runs.accounts.callers import Caller, Role
from arramon_server.runs.accounts.quotas import Quotas
from arramon_server.runs.agent_arguments import normalize_arguments
from arramon_server.runs.code_reference import normalize_code
from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.results.breakdown import Breakdown, Breakdowns
from arramon_server.runs.results.reports import Report, coarse_progress, report_of, split_as_played
from arramon_server.runs.storage.epoch_store import check_open
from arramon_server.runs.storage.journal import Journal, run_not_found
from arramon_server.runs.storage.records import LEASE, NO_CODE, RUNNING, CodeReference, Run, RunProgress
from arramon_server.sim.rules import Limits
from arramon_server.visible_text import is_visible

MAX_PAGE = 1000
"""Maximum number of runs on one page of a listing."""

LONGEST_AGENT = 200
"""Maximum characters in an agent's name."""

HUMAN = "human"
"""Agent name of runs that people play on the pages. Runs created in any other way cannot have it."""

LONGEST_ID = 100
"""Maximum characters of an episode's id in an error message."""


class RunService:
    """Operations on the runs of this server.

    Args:
        splits: served splits, by name.
        journal: storage of the runs.
        engine: plays the runs.
        limits: step limits of new runs.
        clocks: clocks of new runs.
        accounts: participants, whose names are reserved for them.
        quotas: limits of each participant.
        closing: when the leaderboards of splits close.
    """

    def __init__(
        self,
        splits: Mapping[str, Split],
        journal: Journal,
        engine: Engine,
        limits: Limits,
        clocks: ClockSettings,
        accounts: Accounts,
        quotas: Quotas,
        closing: ClosingTimes = NEVER_CLOSES,
    ) -> None:
        self.splits = splits
        self.limits = limits
        self.clocks = clocks
        self.quotas = quotas
        self.closing = closing
        self._journal = journal
        self._engine = engine
        self._accounts = accounts
        self._breakdowns = Breakdowns(splits, journal.play_digest)

    def addresses(self) -> list[str]:
        """Return the addresses of this host's server processes, one each; empty unless there are at least two."""
        found = self._journal.addresses(LEASE)
        return found if len(found) > 1 else []

    def episodes(self, split: str, language: str) -> list[Episode]:
        """Return the episodes of a split in a language, in playing order.

        Raises:
            NotFound: if there is no such split or language.
            BadInput: if the split is hidden.
        """
        chosen = self._split(split)
        if chosen.hidden:
            raise BadInput(f"split {split!r} is hidden and can only be played whole; its episodes are not listed")
        return _playing_order(chosen, language)

    def create(
        self,
        caller: Caller,
        *,
        participant: str,
        agent: str,
        split: str,
        language: str,
        sensors: Sequence[str],
        episodes: int,
        episode_ids: Sequence[str] = (),
        agent_arguments: Sequence[tuple[str, str]] = (),
        code: CodeReference = NO_CODE,
        by_person: bool = False,
    ) -> Run:
        """Create a run.

        Args:
            caller: owner of the run.
            participant: name of the participant; empty for that of the caller, or "anonymous" without a token.
            agent: name of the agent on the leaderboard.
            split: name of the split.
            language: code of the language.
            sensors: sensors that the agent receives; may be empty.
            episodes: number of episodes, in the split's shuffled order; 0 for all.
            episode_ids: ids of the episodes to play, in this order, instead of a number; not on a hidden split.
            agent_arguments: names and values of the arguments that the agent was created with.
            code: where the agent's code can be found, if the participant names it.
            by_person: whether a person plays it on the pages, as the agent HUMAN.

        Raises:
            NotFound: if there is no such split, language or episode.
            Conflict: if the split is an epoch that is closed, or its data is not what the host committed to, or its
                leaderboard is closed.
            OverQuota: if the caller's quota on the split is used up.
            BadInput: if any other argument is wrong.
        """
        chosen = self._split(split)
        self.closing.check_open(split, "no runs are created on it")
        order = _playing_order(chosen, language)
        if len(agent) > LONGEST_AGENT:
            raise BadInput(f"the agent's name has {len(agent)} characters; at most {LONGEST_AGENT} are allowed")
        if not agent.strip() or not is_visible(agent):
            raise BadInput(f"the agent's name is {agent!r}, expected one line of visible text")
        if not by_person and agent.strip().casefold() == HUMAN:
            raise BadInput(
                f"the agent's name is {agent!r}, which only runs have that people play on the server's pages"
            )
        played = _chosen(chosen, language, [episode.episode_id for episode in order], episodes, episode_ids)
        self._check_participant(caller, participant)
        run = Run(
            run_id=uuid.uuid4().hex,
            participant=caller.account or participant or ANONYMOUS_NAME,
            account=caller.account,
            agent=agent,
            split=split,
            language=language,
            sensors=_check_sensors(sensors, chosen),
            steps_per_phase=self.limits.steps_per_phase,
            data_hash=chosen.data_hash,
            server_version=__version__,
            state=RUNNING,
            created_at=self._journal.time(),
            step_seconds=self.clocks.step_seconds,
            bank_seconds=self.clocks.bank_seconds,
            bank_left=self.clocks.bank_seconds if self.clocks else None,
            agent_arguments=normalize_arguments(agent_arguments),
            code=normalize_code(code.url, code.commit, code.image),
        )
        self._journal.create(
            run,
            played,
            lambda connection: self._admit(connection, caller, chosen),
        )
        self._engine.note_new_run(run)
        return run

    def _admit(self, connection: Connection, caller: Caller, split: Split) -> None:
        check_may_act(connection, caller.account)
        check_open(connection, split.name, split.data_hash)
        self.quotas.admit_run(connection, caller, split.name)

    def visible_run(self, caller: Caller, run_id: str) -> Run:
        """Return a run that the caller may see.

        Raises:
            NotFound: if there is no such run, or the caller may not see it: the error is the same.
        """
        run = self._journal.run(run_id)
        if not caller.may_see(run):
            raise run_not_found(run_id)
        return run

    def progress_for(self, caller: Caller, run_id: str) -> tuple[Run, RunProgress]:
        """Return a run that the caller may see, and its progress, which is rounded for other callers on a hidden split.

        Raises:
            NotFound: if there is no such run that the caller may see.
            Conflict: if its leaderboard is frozen, and the run may be another caller's (see `Caller.may_see_withheld`).
        """
        run, progress = self.visible_run(caller, run_id), self.progress(run_id)
        if caller.may_see_withheld(run, published=progress.published):
            return run, progress
        self.closing.check_shown(run.split)
        if self._is_hidden(run):
            return replace(run, bank_left=None), coarse_progress(progress)
        return run, progress

    def progress(self, run_id: str) -> RunProgress:
        """Return the progress of a run."""
        return self._journal.progress(run_id)

    def progress_of(self, run_ids: Sequence[str]) -> dict[str, RunProgress]:
        """Return the progress of several runs, by run."""
        return self._journal.progress_of(run_ids)

    def runs_page(self, caller: Caller, size: int, before: str | None) -> list[Run]:
        """Return a page of the runs that the caller may list, latest first.

        Args:
            caller: hosts list all runs, others their own, anonymous callers on a public server none.
            size: maximum number of runs, 1 to MAX_PAGE.
            before: id of the last run on the previous page; None for the first page.

        Raises:
            BadInput: if the size is out of range.
            NotFound: if there is no run `before` that the caller may see.
        """
        if not 1 <= size <= MAX_PAGE:
            raise BadInput(f"page_size is {size}, expected 1 to {MAX_PAGE}")
        if not caller.may_list:
            return []
        last = self.visible_run(caller, before) if before is not None else None
        if caller.role is Role.HOST:
            return self._journal.runs(size, last)
        return self._journal.runs_of(caller.account, size, last)

    def playable_run(self, caller: Caller, run_id: str) -> Run:
        """Return a run that a stream may join.

        Raises:
            NotFound: if there is no such run that the caller may see.
            Forbidden: if it is not the caller's own run: a host sees the runs of others, but does not play them.
            Conflict: if the data of the split has changed since the run was created; or if the run is on the
                leaderboard, and may be another caller's (see `Caller.may_see_withheld`).
        """
        run = self.visible_run(caller, run_id)
        if not caller.owns(run):
            raise Forbidden(
                f"run {run_id!r} belongs to {run.account or 'a caller without a token'}, and only its participant can "
                "play it; a host can cancel it"
            )
        split_as_played(run, self.splits)
        if run.state != RUNNING and not caller.may_see_withheld(run, published=self._journal.is_published(run_id)):
            raise Conflict(f"run {run_id!r} is {run.state.lower()} and on the leaderboard; there is nothing to play")
        return run

    async def cancel(self, caller: Caller, run_id: str) -> Run:
        """Forfeit the remaining episodes of a run, and return the run. Call it on the engine's event loop.

        Raises:
            NotFound: if there is no such run that the caller may see.
            Conflict: if the run has ended already.
        """
        await self._engine.cancel(self.visible_run(caller, run_id))
        return self.visible_run(caller, run_id)

    def report(self, caller: Caller, run_id: str) -> Report:
        """Return the scores of a run that has ended.

        Raises:
            NotFound: if there is no such run that the caller may see.
            Conflict: if the run is still being played, or the data of the split has changed since it was created; or
                if its leaderboard is frozen, and the run may be another caller's.
        """
        run, _ = self.progress_for(caller, run_id)
        report = report_of(run, self._journal, self.splits)
        if self._is_hidden(run) and not caller.may_see_withheld(run, published=report.progress.published):
            return replace(report, progress=coarse_progress(report.progress))
        return report

    def breakdown(self, caller: Caller, run_id: str) -> tuple[Report, Breakdown]:
        """Return the scores of an ended run and their breakdown. All callers may get those of published runs.

        Raises:
            NotFound: if there is no such run that the caller may see.
            Conflict: if the run is still being played, or the data of the split has changed since it was created; or
                if its leaderboard is frozen, and the run is another participant's.
        """
        published = self._journal.is_published(run_id)
        run = self._journal.run(run_id)
        if not (published or caller.may_see(run)):
            raise run_not_found(run_id)
        if not caller.may_see_withheld(run, published=published):
            self.closing.check_shown(run.split)
        report = report_of(run, self._journal, self.splits)
        if self._is_hidden(run):
            report = replace(report, progress=coarse_progress(report.progress))
        return report, self._breakdowns.of(run, self._journal.endings(run_id), report.voided)

    def _check_participant(self, caller: Caller, participant: str) -> None:
        if participant in ("", caller.account or ANONYMOUS_NAME):
            return
        if caller.account is not None:
            raise BadInput(
                f"the participant is {quoted(participant)}, expected the token's owner {caller.account!r} or none"
            )
        check_name(participant)
        if self._accounts.is_taken(participant):
            raise BadInput(
                f"the name {participant!r} is that of a participant who has a token, or can be confused with it; "
                "use the token, or another name"
            )

    def _is_hidden(self, run: Run) -> bool:
        split = self.splits.get(run.split)
        return split is not None and split.hidden

    def _split(self, name: str) -> Split:
        if name not in self.splits:
            raise NotFound(f"there is no split {quoted(name)}; this server has {', '.join(self.splits)}")
        return self.splits[name]


def _playing_order(split: Split, language: str) -> list[Episode]:
    """Return a split's episodes in a language, in playing order.

    Raises:
        NotFound: if there are none.
    """
    order = split.in_playing_order(language)
    if not order:
        there = ", ".join(split.languages) or "none"
        raise NotFound(f"split {split.name!r} has no episodes in {quoted(language)}; it has {there}")
    return order


def _chosen(
    split: Split, language: str, order: Sequence[str], episodes: int, episode_ids: Sequence[str]
) -> Sequence[str]:
    """Return the ids of the episodes to play, in order: all, the first `episodes`, or the given ids.

    Raises:
        NotFound: if the split does not have one of the ids in the language.
        BadInput: if the choice is not allowed for another reason.
    """
    if split.hidden and (0 < episodes < len(order) or episode_ids):
        # Two runs that differ by one episode would reveal its scores. No id is looked up: the error would reveal it.
        requested = "single episodes" if episode_ids else f"{episodes} of its episodes"
        raise BadInput(f"split {split.name!r} is hidden and can only be played whole; {requested} were requested")
    if episodes > len(order):
        raise BadInput(f"{episodes} episodes were requested; split {split.name!r} has {len(order)} in {language!r}")
    if not episode_ids:
        return order[: episodes or None]
    if episodes:
        raise BadInput(
            f"both a number of episodes ({episodes}) and a list of {len(episode_ids)} were given; expected one of them"
        )
    known, seen = frozenset(order), set[str]()
    for episode_id in episode_ids:
        shown = episode_id if len(episode_id) <= LONGEST_ID else episode_id[:LONGEST_ID] + "..."
        if episode_id not in known:
            raise NotFound(f"split {split.name!r} has no episode {shown!r} in {language!r}")
        if episode_id in seen:
            raise BadInput(f"the episode {shown!r} is given twice; a run plays each episode once")
        seen.add(episode_id)
    return tuple(episode_ids)


def _check_sensors(sensors: Sequence[str], split: Split) -> tuple[str, ...]:
    refused = [sensor for sensor in sensors if sensor not in split.sensors]
    if refused:
        offered = ", ".join(split.sensors)
        raise BadInput(f"split {split.name!r} does not offer the sensor {quoted(refused[0])}; it offers {offered}")
    return tuple(sensor for sensor in split.sensors if sensor in sensors)
