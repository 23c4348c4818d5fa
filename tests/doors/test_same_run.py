"""One test, all doors: the same actions give the same scores, cause, hash chain and receipt."""

import asyncio
import json
import random
import re
import subprocess
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from arramon.v1.chain import episode_head
from arramon_client import AsyncRun, Run, Settings, connect, play
from arramon_client.adapters.lerobot import LeRobotEnv
from arramon_client.agent import Episode, Observation
from arramon_client.receipts import Receipt, read_receipt
from arramon_client.world import Action
from tests import tiny
from tests.api.player import create
from tests.client.mcp.conftest import tools_on
from tests.client.mcp.players import data_of
from tests.doors.installed import framework_python
from tests.serving import Server

STEPS = 8
"""The step limit: enough for `tiny.ACTIONS`."""

WANDERING = [random.Random(7).choice((0, 0, 0, 1, 2, 2, 3)) for _ in range(4 * STEPS)]
"""Ends some phases by itself, others at the step limit."""

PLAYED = {"truth": [int(action) for action in tiny.ACTIONS], "wandering": WANDERING}

EPISODE, PLAN = "1", 3

Actions = Sequence[int]
Result = dict[str, Any]
"""`run_id`, `cause` and `scores`; with `receipt`, the content of its file, where the door has it."""

PLAYS = Path(__file__).parent / "plays"


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    data = tmp_path_factory.mktemp("data")
    tiny.write(data)
    tiny.write(data, "secret", 2, hidden=True)
    server = Server(data, "127.0.0.1:0", "--steps", str(STEPS))
    yield server
    assert server.stop() == 0


@pytest.fixture(scope="module", params=[("truth", "hi"), ("wandering", "en")], ids="-".join)
def reference(request: pytest.FixtureRequest, server: Server) -> tuple[str, Actions, Result]:
    """What is played, and the result of `Run`, by single acts."""
    name, language = request.param
    return language, PLAYED[name], by_run(server.address, language, PLAYED[name])


def by_run(address: str, language: str, actions: Actions) -> Result:
    options: Any = {"server": address, "split": "tiny", "sensors": ("pose",), "episode_ids": [EPISODE]}
    with Run.create(language=language, agent="run", **options) as run:
        episode = next(run.episodes())
        while not episode.ended:
            seen = episode.look()
            episode.act(seen.step, actions[seen.step], note=f"step {seen.step}")
        return {"run_id": run.run_id, "cause": episode.cause, "scores": episode.scores()}


def by_async_run(address: str, language: str, actions: Actions) -> Result:
    async def main() -> Result:
        options: Any = {"server": address, "split": "tiny", "episode_ids": [EPISODE]}
        async with await AsyncRun.create(language=language, agent="async-run", **options) as run:
            async for episode in run.episodes():
                while not episode.ended:
                    step = (await episode.look()).step
                    await episode.act(step, actions[step : step + PLAN])
            return {"run_id": run.run_id, "cause": episode.cause, "scores": await episode.scores()}

    return asyncio.run(main())


class Scripted:
    """Agent that plays the actions."""

    sensors = ("depth",)

    def __init__(self, actions: Actions) -> None:
        self.actions = actions

    def begin(self, episode: Episode) -> None:
        pass

    def act(self, observations: Sequence[Observation]) -> list[int]:
        return [self.actions[seen.step] for seen in observations]


def by_play(address: str, language: str, actions: Actions) -> Result:
    with connect(address) as connected:
        run = create(connected.stub, language=language, episode_ids=[EPISODE])
        play(connected.stub, run, Scripted(actions), Settings(parallel=1))
    return ended(address, run.run_id)


def by_gymnasium(address: str, language: str, actions: Actions) -> Result:
    env = gymnasium.make("arramon/ArraMon-v0", lang=language, split="tiny", server=address, sensors=("rgb",))
    env.reset(options={"episode": EPISODE})
    run_id = env.unwrapped.player.run.run_id  # type: ignore[attr-defined]
    info: dict[str, Any] = {}
    for action in actions:
        _, _, terminated, _, info = env.step(np.int64(action))
        if terminated:
            break
    env.close()
    return {"run_id": run_id, "cause": info["cause"], "scores": info["scores"]}


def by_lerobot(address: str, language: str, actions: Actions) -> Result:
    env = LeRobotEnv(lang=language, split="tiny", server=address)
    observation, info = env.reset(options={"episode": EPISODE})
    for action in actions:
        assert observation["pixels"].shape == (224, 224, 3)
        observation, _, terminated, _, info = env.step(np.eye(4, dtype=np.float32)[action])
        if terminated:
            break
    env.close()
    assert info["is_success"] == (info["scores"]["total"]["PTC@CTC-3"] == 1.0)
    return {"run_id": info["run_id"], "cause": info["cause"], "scores": info["scores"]}


def by_mcp(address: str, language: str, actions: Actions) -> Result:
    async def main() -> str:
        async with tools_on(address) as client:
            options = {
                "language": language,
                "agent": "mcp",
                "split": "tiny",
                "episode_ids": [EPISODE],
                "sensors": ["rgb"],
            }
            seen = data_of(await client.call_tool("start", options))
            run: str = seen["run"]["id"]
            seen = data_of(await client.call_tool("look", {"run": run}))
            while not seen["episode"]["ended"]:
                step = seen["episode"]["step"]
                names = [Action(action).name for action in actions[step : step + PLAN]]
                act = {"run": run, "episode": EPISODE, "step": step, "actions": names}
                seen = data_of(await client.call_tool("act", act))
            return run

    return ended(address, asyncio.run(main()))


def ended(address: str, run_id: str) -> Result:
    """The result of a run of one episode that is over."""
    with Run.resume(run_id, server=address) as run:
        (episode,) = run.report()["episodes"]
    first, second = episode["turns"].values()
    total = {metric: (first[metric] + second[metric]) / 2 for metric in first}
    return {"run_id": run_id, "cause": episode["cause"], "scores": {**episode["turns"], "total": total}}


DOORS = (by_async_run, by_play, by_gymnasium, by_lerobot, by_mcp)


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.__name__)
def test_doors_of_this_package_agree(
    door: Callable[[str, str, Actions], Result], reference: tuple[str, Actions, Result], server: Server, tmp_path: Path
) -> None:
    language, actions, expected = reference
    check(door(server.address, language, actions), expected, actions, server, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("extra", ["inspect", "openenv", "verifiers"])
def test_doors_of_frameworks_agree(
    extra: str,
    reference: tuple[str, Actions, Result],
    server: Server,
    tmp_path: Path,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    """The framework's own client plays, in an environment of its own."""
    language, actions, expected = reference
    python, output = framework_python(tmp_path_factory, extra), tmp_path / "result.json"
    command = [str(python), str(PLAYS / f"{extra}_play.py"), server.address, language, EPISODE]
    environment = {"PATH": "/usr/bin:/bin", "HOME": str(tmp_path), "LANG": "C.UTF-8", "PYTHONPATH": str(PLAYS)}
    done = subprocess.run(
        [*command, "".join(map(str, actions)), str(output)],
        capture_output=True,
        text=True,
        env=environment,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    result = json.loads(output.read_text())
    check(result, expected, actions, server, tmp_path)
    headline = {metric: result["scores"]["total"][metric] for metric in ("nDTW", "CTC-3", "PTC@CTC-3")}
    if extra == "openenv":
        assert result["reward"] == pytest.approx(sum(headline.values()) / 3)
    else:
        assert result["headline"] == headline


def check(result: Result, expected: Result, actions: Actions, server: Server, folder: Path) -> None:
    """Compare a door's result with that of `Run`, and the receipts of both runs."""
    assert (result["cause"], result["scores"]) == (expected["cause"], expected["scores"])
    if "receipt" in result:
        path = folder / "door.receipt.json"
        path.write_text(json.dumps(result["receipt"]))
        assert read_receipt(path).content == receipt_of(server, result).content
    receipt, other = receipt_of(server, result), receipt_of(server, expected)
    assert receipt.public_key == other.public_key
    assert without_ids(receipt) == without_ids(other)
    (episode,) = receipt.episodes
    head = episode_head(result["run_id"], EPISODE, receipt.content["data_hash"], actions[: episode["steps"]])
    assert episode["head"] == head.hex()


def receipt_of(server: Server, result: Result) -> Receipt:
    with Run.resume(result["run_id"], server=server.address) as run:
        return run.receipt()


def without_ids(receipt: Receipt) -> dict[str, Any]:
    """The content of a receipt, apart from ids and times, the hashes that they are in, and what a door chooses.

    A door chooses the agent's name and the sensors; the runs are the participant's first, second, ... attempt.
    """
    content = json.loads(json.dumps(receipt.content))
    for name in ("run_id", "agent", "created_at", "ended_at", "sensors", "images"):
        del content["run"][name]
    del content["digest"], content["attempts"]
    content["score_signature"] = re.sub(r"sensors:[^|]*\|images:[^|]*", "", content["score_signature"])
    for episode in content["episodes"]:
        del episode["head"]
    return dict(content)
