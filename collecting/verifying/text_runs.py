"""The run of a verification: an ordinary run of a person on the split of one text, played by its worker alone."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

import sqlalchemy as sa

from arramon_collecting.storage.work.records import Task
from arramon_collecting.verifying.text_splits import split_name
from arramon_server.closing_times import NEVER_CLOSES
from arramon_server.errors import Conflict, TakenOver
from arramon_server.runs.accounts.accounts import COLLECTING_NAME, Accounts
from arramon_server.runs.accounts.callers import Caller, Role
from arramon_server.runs.accounts.quotas import NO_QUOTA, Quotas
from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.run_service import HUMAN, RunService
from arramon_server.runs.storage.causes import SERVER_FAULT
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import Run
from arramon_server.runs.storage.tables import participants
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.play.aids import Aids
from arramon_server.web.play.requests import NewRun
from arramon_server.web.play.socket_ground import SocketGround, SocketRuns
from arramon_server.web.web_parts import WebContext

VERIFIERS = Caller(Role.PARTICIPANT, COLLECTING_NAME, may_list=False)
"""Owner of all runs of verifications. It has no token, so that no other caller sees or plays them."""

AIDS = Aids(landing_diagram=True)
"""The paper's verifiers had the landing diagram (appendix "Interface")."""

SENSORS = ("rgb",)
"""What a person sees."""


def text_run_service(context: WebContext) -> RunService:
    """Return the service of the runs on texts, which have no clocks and no quotas."""
    quotas = Quotas(context.database, lambda caller, split: NO_QUOTA)  # noqa: ARG005, part of the contract
    accounts, limits = Accounts(context.database), context.runs.limits
    return RunService(
        context.splits, context.journal, context.engine, limits, ClockSettings(), accounts, quotas, NEVER_CLOSES
    )


def ensure_account(database: Database) -> None:
    """Make the account that owns the runs, unless there is one."""
    c = participants.c
    if database.read(sa.select(c.participant).where(c.participant == COLLECTING_NAME)):
        return
    row = {"participant": COLLECTING_NAME, "role": Role.PARTICIPANT.value, "created_at": datetime.now(UTC)}
    try:
        with database.write() as connection:
            connection.execute(participants.insert(), [row])
    except TakenOver:
        pass  # another process has just made it


class TextRuns:
    """The run of one task (`web.play.socket_ground.SocketRuns`). Thread-safe.

    Args:
        database: the journal's database.
        journal: storage of the runs.
        runs: creates runs on texts.
        task: returns the task as it is now; it raises if it is not open.
        set_run: stores the run of the task, if it still has the run of the first argument; returns the one that it has.
        language: language of the text.
    """

    def __init__(
        self,
        database: Database,
        journal: Journal,
        runs: RunService,
        task: Callable[[], Task],
        set_run: Callable[[str | None, str], str],
        language: str,
    ) -> None:
        self._database = database
        self._journal = journal
        self._runs = runs
        self._task = task
        self._set_run = set_run
        self._language = language

    def find_or_create(self, caller: Caller, run: str | NewRun) -> Run:  # noqa: ARG002, the task says which run it is
        """Return the run of the task. It is created at the first call, and again if a fault of the server ended it.

        Raises:
            Conflict: if the task is not open, or its text has changed since.
        """
        task = self._task()
        if task.run_id is not None and not self._is_void(task.run_id):
            return self._runs.playable_run(VERIFIERS, task.run_id)
        ensure_account(self._database)
        created = self._runs.create(
            VERIFIERS,
            participant="",
            agent=HUMAN,
            split=split_name(task.collection, task.task_id),
            language=self._language,
            sensors=SENSORS,
            episodes=0,
            agent_arguments=AIDS.as_arguments(),
            by_person=True,
        )
        # Another tab may have been quicker: its run is played, and this one stays empty.
        return self._runs.playable_run(VERIFIERS, self._set_run(task.run_id, created.run_id))

    def is_hidden(self, run: Run) -> bool:  # noqa: ARG002, part of the contract
        """Return that the split is hidden."""
        return True

    def publish(self, caller: Caller, run: Run) -> None:  # noqa: ARG002, part of the contract
        """Refuse.

        Raises:
            Conflict: always.
        """
        raise Conflict("a verification is not published")

    def _is_void(self, run_id: str) -> bool:
        return any(ending.cause == SERVER_FAULT for ending in self._journal.endings(run_id))


class NoScores:
    """Scores of verifications (`web.play.socket_ground.SocketScores`): workers see none."""

    async def html(self, caller: Caller, run: Run, episode_id: str, t: PageTexts) -> tuple[str, list[bool]]:  # noqa: ARG002
        """Refuse.

        Raises:
            Conflict: always.
        """
        raise Conflict("a verification shows no scores")


class NoRuns:
    """Runs of a page on which only the tutorial is played (`web.play.socket_ground.SocketRuns`)."""

    def find_or_create(self, caller: Caller, run: str | NewRun) -> Run:  # noqa: ARG002, part of the contract
        """Refuse.

        Raises:
            Conflict: always.
        """
        raise Conflict("only the placement test is played on this page")

    def is_hidden(self, run: Run) -> bool:  # noqa: ARG002, part of the contract
        """Return that nothing is shown."""
        return True

    def publish(self, caller: Caller, run: Run) -> None:  # noqa: ARG002, part of the contract
        """Refuse.

        Raises:
            Conflict: always.
        """
        raise Conflict("a placement test is not published")


class NoPractice:
    """The tutorial of a page that has none (`web.play.socket_ground.PracticeGround`)."""

    async def ground(self) -> SocketGround:
        """Refuse.

        Raises:
            Conflict: always.
        """
        raise Conflict("there is no practice on this page")


@dataclass(frozen=True, slots=True)
class TextGround:
    """What one verification is played on (`web.play.socket_ground.SocketGround`)."""

    runs: SocketRuns
    scores: NoScores
    engine: Engine
