"""What can be done with runs, short of playing them: create, look, cancel, report."""

import uuid
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime

from server import __version__
from server.episodes.splits import Split
from server.errors import BadInput, NotFound
from server.runs.accounts import NOBODY, Accounts, check_name, is_visible
from server.runs.callers import Caller
from server.runs.clocks import Clocks
from server.runs.engine import Engine
from server.runs.journal import Journal, no_run
from server.runs.quotas import Quotas
from server.runs.records import LEASE, RUNNING, Progress, Run
from server.runs.reports import Report, report_of, split_of
from server.sim.rules import Limits

MAX_PAGE = 1000
"""Runs in one page of a listing."""

LONGEST_AGENT = 200
"""Characters in an agent's name."""


class Runs:
    """The runs of this server.

    Args:
        splits: by name.
        journal: where they are kept.
        engine: plays them.
        limits, clocks: given to a run that is created now.
        accounts: whose names nobody else may play under.
        quotas: how much each may.
    """

    def __init__(
        self,
        splits: Mapping[str, Split],
        journal: Journal,
        engine: Engine,
        limits: Limits,
        clocks: Clocks,
        accounts: Accounts,
        quotas: Quotas,
    ) -> None:
        self.splits = splits
        self.limits = limits
        self.clocks = clocks
        self.quotas = quotas
        self._journal = journal
        self._engine = engine
        self._accounts = accounts

    def addresses(self) -> list[str]:
        """Where the server's processes can be reached one by one; empty where they cannot, or where there is one."""
        found = self._journal.addresses(LEASE)
        return found if len(found) > 1 else []

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
    ) -> Run:
        """A new run.

        Args:
            caller: whose it will be.
            participant: who plays; empty for the caller's own name, or "anonymous" where they have none.
            agent: its name on the leaderboard.
            split: by name.
            language: by code.
            sensors: what the agent is given; none is allowed.
            episodes: how many of the split's, in its shuffled order; 0 for all.

        Raises:
            NotFound: for a split or a language that is not there.
            OverQuota: if the caller may have no further run on the split now.
            BadInput: for anything else.
        """
        chosen = self._split(split)
        order = chosen.in_playing_order(language)
        if not order:
            raise NotFound(
                f"split {split!r} has no episodes in {language!r}; it has {', '.join(chosen.languages) or 'none'}"
            )
        if len(agent) > LONGEST_AGENT:
            raise BadInput(f"the agent's name has {len(agent)} characters; at most {LONGEST_AGENT} are allowed")
        if not agent.strip() or not is_visible(agent):
            raise BadInput(f"the agent's name is {agent!r}, expected a text that can be seen")
        if episodes > len(order):
            raise BadInput(f"{episodes} episodes were asked for; split {split!r} has {len(order)} in {language!r}")
        if chosen.hidden and 0 < episodes < len(order):
            # Two runs whose parts differ by one episode would tell its scores.
            raise BadInput(f"split {split!r} is hidden and played whole; {episodes} of its episodes were asked for")
        self._check_participant(caller, participant)
        run = Run(
            run_id=uuid.uuid4().hex,
            participant=caller.account or participant or NOBODY,
            account=caller.account,
            agent=agent,
            split=split,
            language=language,
            sensors=_check_sensors(sensors, chosen),
            steps_per_phase=self.limits.steps_per_phase,
            data_hash=chosen.data_hash,
            server_version=__version__,
            state=RUNNING,
            created_at=datetime.now(UTC),
            step_seconds=self.clocks.step_seconds,
            first_step_seconds=self.clocks.first_step_seconds,
            bank_seconds=self.clocks.bank_seconds,
            bank_left=self.clocks.bank_seconds if self.clocks else None,
        )
        self._journal.create(
            run,
            [episode.episode_id for episode in order[: episodes or None]],
            lambda connection: self.quotas.admit_run(connection, caller, split),
        )
        return run

    def visible(self, caller: Caller, run_id: str) -> Run:
        """A run that a caller may see.

        Raises:
            NotFound: if there is none of that id, or it is not theirs: which of the two, nobody learns.
        """
        run = self._journal.run(run_id)
        if not caller.may_see(run):
            raise no_run(run_id)
        return run

    def progress(self, run_id: str) -> Progress:
        """How far a run is."""
        return self._journal.progress(run_id)

    def page(self, caller: Caller, size: int, before: str | None) -> list[Run]:
        """A caller's runs, the latest first: at most `size`, from behind run `before` on.

        Raises:
            BadInput: for a size out of range.
            NotFound: if there is no run `before`.
        """
        if not 1 <= size <= MAX_PAGE:
            raise BadInput(f"page_size is {size}, expected 1 to {MAX_PAGE}")
        if not caller.lists:
            return []
        last = self.visible(caller, before) if before is not None else None
        return self._journal.runs(size, last, caller=caller)

    def playable(self, caller: Caller, run_id: str) -> Run:
        """A run that a stream may join.

        Raises:
            NotFound: if there is none of that id that the caller may see.
            Conflict: if the split's data is not what the run began with.
        """
        run = self.visible(caller, run_id)
        split_of(run, self.splits)
        return run

    async def cancel(self, caller: Caller, run_id: str) -> Run:
        """Forfeits what is left of a run. To be called on the engine's event loop.

        Raises:
            NotFound: if there is none of that id that the caller may see.
            Conflict: if it is over already.
        """
        await self._engine.cancel(self.playable(caller, run_id))
        return self.visible(caller, run_id)

    def report(self, caller: Caller, run_id: str) -> Report:
        """The scores of a run.

        Raises:
            NotFound: if there is none of that id that the caller may see.
            Conflict: while it is being played, or if the split's data is not what the run began with.
        """
        return report_of(self.visible(caller, run_id), self._journal, self.splits)

    def _check_participant(self, caller: Caller, participant: str) -> None:
        if participant in ("", caller.account or NOBODY):
            return
        if caller.account is not None:
            raise BadInput(
                f"the token is that of {caller.account!r}, so that the participant cannot be {participant!r}"
            )
        check_name(participant)
        if self._accounts.is_name_of_another(participant):
            raise BadInput(
                f"{participant!r} is, or can be taken for, a participant who has a token; use that, or no name"
            )

    def _split(self, name: str) -> Split:
        if name not in self.splits:
            raise NotFound(f"there is no split {name!r}; this server has {', '.join(self.splits)}")
        return self.splits[name]


def _check_sensors(sensors: Sequence[str], split: Split) -> tuple[str, ...]:
    refused = [sensor for sensor in sensors if sensor not in split.sensors]
    if refused:
        raise BadInput(f"split {split.name!r} does not offer the sensor {refused[0]!r}, but {', '.join(split.sensors)}")
    return tuple(sensor for sensor in split.sensors if sensor in sensors)
