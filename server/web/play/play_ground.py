"""What a play page plays on: the host's runs and engine, or those of the tutorial, which are kept only in memory."""

import asyncio
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from arramon_server.board.entries import Entries
from arramon_server.board.publisher import Publisher
from arramon_server.closing_times import NEVER_CLOSES
from arramon_server.image_threads import ImageThreads
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.quotas import NO_QUOTA, Quotas
from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.results.receipts import Receipts
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.run_service import RunService
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.run_activity import RunActivity
from arramon_server.sim.rules import Limits
from arramon_server.web.play.aids import NO_AIDS, Aids
from arramon_server.web.play.people_runs import PeopleRuns
from arramon_server.web.play.played_scores import PlayedScores
from arramon_server.web.play.practice_split import PRACTICE, practice_split
from arramon_server.web.rendering import Renderer


@dataclass(frozen=True, slots=True)
class PlayGround:
    """What a play page plays on.

    Attributes:
        runs: creates and finds the runs of people.
        scores: draws the scores of what was played.
        engine: plays the runs.
    """

    runs: PeopleRuns
    scores: PlayedScores
    engine: Engine


class Practice:
    """The tutorial: an engine of its own, by the same rules, with a journal that is deleted at the end.

    Its runs have no clocks, belong to nobody, and cannot be published.

    Args:
        camera: one of `cameras.CAMERAS`.
        threads: in which frames are drawn and compressed.
        renderer: renders scores.
        aids: aids of the host's new runs. The landing diagram, which teaches where things land, is added.
    """

    def __init__(self, camera: str, threads: ImageThreads, renderer: Renderer, aids: Aids = NO_AIDS) -> None:
        self._camera = camera
        self._threads = threads
        self._renderer = renderer
        self._aids = replace(aids, landing_diagram=True)
        self._opening = asyncio.Lock()
        self._folder: TemporaryDirectory[str] | None = None
        self._database: Database | None = None
        self._playing: asyncio.Task[None] | None = None
        self._ground: PlayGround | None = None

    async def ground(self) -> PlayGround:
        """Return what the tutorial is played on; made at the first call.

        Raises:
            StorageError: if there is no space for its journal.
        """
        async with self._opening:
            if self._ground is None:
                self._folder = TemporaryDirectory(prefix="arramon-practice-")
                path = Path(self._folder.name)
                self._database = await asyncio.to_thread(Database, f"sqlite:///{path / 'journal.db'}", fsync=False)
                self._ground = self._make(self._database, path)
        return self._ground

    def close(self) -> None:
        """End the engine, and delete the journal."""
        if self._playing is not None:
            self._playing.cancel()
        if self._ground is not None:
            self._ground.engine.stop()
            self._ground.scores.close()
        if self._database is not None:
            self._database.close()
        if self._folder is not None:
            self._folder.cleanup()

    def _make(self, database: Database, folder: Path) -> PlayGround:
        splits, journal = {PRACTICE: practice_split()}, Journal(database)
        activity = RunActivity(database, close_unplayed=True)
        engine = Engine(splits, journal, activity, camera=self._camera, threads=self._threads)
        quotas = Quotas(database, lambda caller, split: NO_QUOTA)  # noqa: ARG005, part of the contract
        runs = RunService(splits, journal, engine, Limits(), ClockSettings(), Accounts(database), quotas, NEVER_CLOSES)
        receipts = Receipts(database, splits, SigningKey(folder / "key.pem"))
        publisher = Publisher(journal, splits, Entries(database), receipts)
        people = PeopleRuns(runs, journal, publisher, self._aids)
        scores = PlayedScores(runs, journal, splits, self._renderer)
        engine.start()
        self._playing = asyncio.create_task(engine.run())
        return PlayGround(people, scores, engine)
