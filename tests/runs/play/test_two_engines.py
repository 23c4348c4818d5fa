"""Two processes that play one run: each is disconnected, has an outdated state, or dies in turn."""

import asyncio
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from arramon_server.errors import StorageError, TakenOver
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.play.events import Observed, RunEnded
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.records import COMPLETE, LEASE, Run
from tests import tiny
from tests.runs.engines import Backend, FakeStream, quick, until, wait_for_rounds

__all__ = ["quick"]


class Line(Database):
    """A process's own connection to the database, which a test can cut."""

    is_cut = False

    @contextmanager
    def _errors(self) -> Iterator[None]:
        if self.is_cut:
            raise StorageError("the line is cut")
        with super()._errors():
            yield


@pytest.fixture
def backend(database_url: str, tmp_path: Path) -> Iterator[Backend]:
    backend = Backend(tmp_path, url=database_url)
    with closing(backend.database):
        yield backend


@pytest.fixture
def line(backend: Backend) -> Iterator[Line]:
    with closing(Line(backend.url, clock=lambda: backend.wall)) as line:
        yield line


def check_played_to_the_end(backend: Backend) -> None:
    """Check that every episode has the steps of the ground truth, each once, and its scores."""
    assert backend.journal.run("run").state == COMPLETE
    assert backend.causes() == {"AGENT_FINISHED": 3}
    for ending in backend.journal.endings("run"):
        assert backend.journal.actions("run", ending.episode_id) == [*tiny.ACTIONS]
        assert [turn["PTC"] for turn in ending.scores] == [1.0, 1.0]


@pytest.mark.usefixtures("quick")
def test_disconnected_process_detects_that_its_episode_was_taken_over(backend: Backend, line: Line) -> None:
    async def body() -> None:
        run = backend.run()
        async with backend.engine(database=line) as one, backend.engine() as other:
            old = FakeStream(one, run)
            episode_id = (await old.observation()).episode.episode_id
            old.act(episode_id, 0, tiny.F)
            assert (await old.observation()).state.step == 1
            line.is_cut = True
            new = FakeStream(other, run)  # the same client, whose connection broke
            assert (await new.observation()).state.step == 1
            line.is_cut = False
            old.act(episode_id, 1, tiny.L)
            await until(lambda: bool(old.closed))
            assert isinstance(old.closed[0], TakenOver)
            new.act(episode_id, 1, tiny.F)
            assert (await new.observation()).state.step == 2
            assert backend.journal.actions("run", episode_id) == [tiny.F, tiny.F]
            (claim,) = backend.journal.open_claims("run")
            assert claim.worker == other.worker  # what the loser let go of was not its own
            new.act(episode_id, 2, tiny.ACTIONS[2])
            await new.play()
        check_played_to_the_end(backend)

    asyncio.run(body())


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize(("heir", "level"), [("me", "INFO"), ("another", "WARNING")])
def test_only_an_episode_lost_to_another_player_causes_a_warning(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, heir: str, level: str
) -> None:
    """A client that connects to another process takes its episodes along: no reason to warn the host."""
    backend = Backend(tmp_path)

    async def body() -> None:
        run = backend.run()
        with closing(Line(backend.url, clock=lambda: backend.wall)) as line:
            async with backend.engine(database=line) as one, backend.engine() as other:
                old = FakeStream(one, run, player="me")
                episode_id = (await old.observation()).episode.episode_id
                line.is_cut = True
                backend.wall += LEASE + 1.0  # now it is free for others too
                assert (await FakeStream(other, run, player=heir).observation()).episode.episode_id == episode_id
                line.is_cut = False
                old.act(episode_id, 0, tiny.L)
                await until(lambda: bool(old.closed))

    with caplog.at_level("INFO"), closing(backend.database):
        asyncio.run(body())
    taken_over = [record.levelname for record in caplog.records if "another process" in record.getMessage()]
    assert taken_over == [level]


@pytest.mark.usefixtures("quick")
def test_only_the_stream_that_lost_an_episode_is_closed(backend: Backend, line: Line) -> None:
    async def body() -> None:
        run = backend.run()
        async with backend.engine(database=line) as one, backend.engine() as other:
            old, beside = FakeStream(one, run), FakeStream(one, run, player="beside")
            lost, kept = [(await fake.observation()).episode.episode_id for fake in (old, beside)]
            new = FakeStream(other, run)
            assert (await new.observation()).episode.episode_id == lost
            # Both act in the same turn, and so in the same commit.
            old.act(lost, 0, tiny.L)
            beside.act(kept, 0, tiny.F)
            assert (await beside.observation()).state.step == 1
            await until(lambda: bool(old.closed))
            assert isinstance(old.closed[0], TakenOver)
            assert not beside.closed
            assert (backend.journal.actions("run", lost), backend.journal.actions("run", kept)) == ([], [tiny.F])

    asyncio.run(body())


@pytest.mark.usefixtures("quick")
def test_a_disconnected_process_does_not_answer_actions(backend: Backend, line: Line) -> None:
    async def body() -> None:
        run = backend.run()
        async with backend.engine(database=line) as one, backend.engine() as other:
            old = FakeStream(one, run)
            episode_id = (await old.observation()).episode.episode_id
            line.is_cut = True
            delivered = len(old.events)
            old.act(episode_id, 0, tiny.L)
            await until(lambda: bool(old.closed))
            assert isinstance(old.closed[0], StorageError)
            assert len(old.events) == delivered
            await FakeStream(other, run).play()
            line.is_cut = False
            await until(lambda: backend.journal.run("run").state == COMPLETE)
        check_played_to_the_end(backend)

    asyncio.run(body())


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("seconds", [LEASE + 1.0, -3600.0, 86_400.0], ids=["waits", "jumps back", "jumps on"])
def test_dead_process_frees_its_episodes_despite_clock_jumps(tmp_path: Path, seconds: float) -> None:
    backend = Backend(tmp_path)

    async def body() -> None:
        run = backend.run()
        with closing(Line(backend.url, clock=lambda: backend.wall)) as line:
            async with backend.engine(database=line) as one, backend.engine() as other:
                dead = FakeStream(one, run, episodes=3)
                await dead.observation()
                line.is_cut = True  # nothing more is heard of it
                heir = FakeStream(other, run, episodes=3, player="heir")
                await wait_for_rounds(other)
                assert not any(isinstance(event, Observed) for event in heir.events)
                backend.wall += seconds
                await heir.play()
        check_played_to_the_end(backend)

    with closing(backend.database):
        asyncio.run(body())


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("seconds", [-3600.0, 3600.0])
def test_clock_jumps_do_not_affect_two_playing_processes(tmp_path: Path, seconds: float) -> None:
    backend = Backend(tmp_path)

    async def body() -> None:
        run = backend.run()
        with closing(Database(backend.url, clock=lambda: backend.wall)) as own:
            async with backend.engine(database=own) as one, backend.engine() as other:
                playing = [
                    asyncio.create_task(keep_playing(engine, run, name)) for engine, name in ((one, "a"), (other, "b"))
                ]
                await until(lambda: backend.journal.progress("run").steps > 5)
                backend.wall += seconds
                await asyncio.gather(*playing)
        check_played_to_the_end(backend)

    with closing(backend.database):
        asyncio.run(body())


@pytest.mark.usefixtures("quick")
def test_client_connected_to_two_processes_takes_every_step_once(backend: Backend, line: Line) -> None:
    async def body() -> None:
        run = backend.run()
        async with backend.engine(database=line) as one, backend.engine() as other:
            lost = await asyncio.gather(*(keep_playing(engine, run, "the same", episodes=3) for engine in (one, other)))
            assert sum(lost) > 0
        check_played_to_the_end(backend)

    asyncio.run(body())


async def keep_playing(engine: Engine, run: Run, player: str, episodes: int = 2) -> int:
    """Play the ground truth like a client that joins again when its stream is closed; return how often it was.

    It is sent away for one reason alone: another process has taken one of its episodes over.
    """
    lost = 0
    while True:
        fake, taken = FakeStream(engine, run, episodes, player), 0
        while not fake.closed:
            await asyncio.sleep(0.001)
            for event in fake.events[taken:]:
                taken += 1
                if isinstance(event, Observed) and event.taken is None and not fake.closed:
                    fake.act(event.episode.episode_id, event.state.step, tiny.ACTIONS[event.state.step])
        over = any(isinstance(event, RunEnded) for event in fake.events)
        assert [type(error) for error in fake.closed] == [type(None) if over else TakenOver], fake.closed
        if over:
            return lost
        lost += 1
        await asyncio.sleep(0.005 * lost)  # or the two might send each other away for ever
