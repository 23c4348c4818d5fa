"""What a WebSocket of the play page is played on, as interfaces, which other pages with the game implement."""

from typing import Protocol

from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.storage.records import Run
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.play.requests import NewRun


class SocketRuns(Protocol):
    """Creates and finds the runs of people. Thread-safe."""

    def find_or_create(self, caller: Caller, run: str | NewRun) -> Run:
        """Return the run of an id, or a new one.

        Raises:
            ArraMonError: if the run cannot be played or created by the caller.
        """
        ...

    def is_hidden(self, run: Run) -> bool:
        """Return whether the split of a run is hidden: the page then learns no more than an agent."""
        ...

    def publish(self, caller: Caller, run: Run) -> None:
        """Put an ended run on the leaderboard.

        Raises:
            ArraMonError: if it cannot be published.
        """
        ...


class SocketScores(Protocol):
    """Draws the scores of what was played."""

    async def html(self, caller: Caller, run: Run, episode_id: str, t: PageTexts) -> tuple[str, list[bool]]:
        """Return scores as HTML, and for each turn of an episode whether the object was placed right.

        Raises:
            ArraMonError: if they are not shown.
        """
        ...


class SocketGround(Protocol):
    """Runs, scores and engine."""

    @property
    def runs(self) -> SocketRuns:
        """Creates and finds the runs."""
        ...

    @property
    def scores(self) -> SocketScores:
        """Draws the scores."""
        ...

    @property
    def engine(self) -> Engine:
        """Plays the runs."""
        ...


class PracticeGround(Protocol):
    """Provides what the tutorial is played on."""

    async def ground(self) -> SocketGround:
        """Return what the tutorial is played on.

        Raises:
            ArraMonError: if there is none.
        """
        ...
