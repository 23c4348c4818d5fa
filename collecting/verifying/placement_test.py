"""The placement test: the play page's tutorial, whose last lesson a worker must pass before the first verification."""

from collections.abc import Callable
from dataclasses import dataclass

from arramon_server.errors import Conflict, NotFound
from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.storage.records import Run
from arramon_server.web.page_texts import DEFAULT_LANGUAGE, PageTexts
from arramon_server.web.play.play_ground import Practice
from arramon_server.web.play.practice_split import PRACTICE, practice_split
from arramon_server.web.play.requests import NewRun
from arramon_server.web.play.socket_ground import SocketRuns, SocketScores

LESSONS, TEST_ALONE = 0, 1
"""Numbers of episodes that the page asks for: the whole tutorial, or its last lesson, which is the test."""

Passed = Callable[[str], None]
"""Records that the worker of an id has passed the test."""


class PlacementTest:
    """Placement tests of all workers, on one tutorial. Use it on the engine's event loop.

    Args:
        practice: the tutorial.
        passed: records that a worker has passed.
    """

    def __init__(self, practice: Practice, passed: Passed) -> None:
        self._practice = practice
        self._passed = passed
        self._owners: dict[str, str] = {}
        split = practice_split()
        self._languages = frozenset(split.languages)
        self._last = list(split.episodes)[-1]

    def close(self) -> None:
        """End the tutorial's engine."""
        self._practice.close()

    def of_worker(self, worker_id: str) -> "WorkerTest":
        """Return the test of one worker (`web.play.socket_ground.PracticeGround`)."""
        return WorkerTest(self, worker_id)

    async def ground(self, worker_id: str) -> "LessonGround":
        """Return what a worker's test is played on.

        Raises:
            StorageError: if there is no space for the tutorial's journal.
        """
        ground = await self._practice.ground()
        return LessonGround(
            LessonRuns(ground.runs, self._owners, worker_id, self._languages),
            LessonScores(ground.scores, self._last, lambda: self._passed(worker_id)),
            ground.engine,
        )


@dataclass(frozen=True, slots=True)
class WorkerTest:
    """The test of one worker."""

    tests: PlacementTest
    worker_id: str

    async def ground(self) -> "LessonGround":
        """Return what the test is played on; see `PlacementTest.ground`."""
        return await self.tests.ground(self.worker_id)


@dataclass(frozen=True, slots=True)
class LessonRuns:
    """Runs of the test: each worker finds only their own.

    Attributes:
        runs: the tutorial's.
        owners: ids of workers by run.
        worker_id: the worker.
        languages: languages of the tutorial.
    """

    runs: SocketRuns
    owners: dict[str, str]
    worker_id: str
    languages: frozenset[str]

    def find_or_create(self, caller: Caller, run: str | NewRun) -> Run:
        """Return a run of the worker, or a new one, in English if the tutorial does not have the language.

        Raises:
            NotFound: if the run is another worker's.
        """
        if isinstance(run, str):
            if self.owners.get(run) != self.worker_id:
                raise NotFound(f"there is no run {run!r} of the placement test")
            return self.runs.find_or_create(caller, run)
        language = run.language if run.language in self.languages else DEFAULT_LANGUAGE
        episodes = run.episodes if run.episodes in (LESSONS, TEST_ALONE) else LESSONS
        created = self.runs.find_or_create(caller, NewRun(PRACTICE, language, episodes, "", ()))
        self.owners[created.run_id] = self.worker_id
        return created

    def is_hidden(self, run: Run) -> bool:
        """Return whether the tutorial is hidden."""
        return self.runs.is_hidden(run)

    def publish(self, caller: Caller, run: Run) -> None:  # noqa: ARG002, part of the contract
        """Refuse.

        Raises:
            Conflict: always.
        """
        raise Conflict("a placement test is not published")


@dataclass(frozen=True, slots=True)
class LessonScores:
    """Scores of the test, which record that it was passed.

    Attributes:
        scores: the tutorial's.
        last: id of the lesson that is the test.
        passed: records that the worker has passed.
    """

    scores: SocketScores
    last: str
    passed: Callable[[], None]

    async def html(self, caller: Caller, run: Run, episode_id: str, t: PageTexts) -> tuple[str, list[bool]]:
        """Return the scores of an episode; both objects of the test in their places pass it.

        Raises:
            ArraMonError: as the tutorial's scores.
        """
        html, placed = await self.scores.html(caller, run, episode_id, t)
        if episode_id == self.last and placed and all(placed):
            self.passed()
        return html, placed


@dataclass(frozen=True, slots=True)
class LessonGround:
    """What a test is played on (`web.play.socket_ground.SocketGround`)."""

    runs: LessonRuns
    scores: LessonScores
    engine: Engine
