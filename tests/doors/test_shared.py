"""What the adapters share: runs of single episodes, hidden splits, an embedded server, and what a model reads."""

import asyncio
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from arramon_client import Run
from arramon_client.adapters.episode_runs import AdapterEpisode, EpisodeRuns
from arramon_client.adapters.host import Host
from arramon_client.adapters.model_view import actions_of, observation_text, picture
from arramon_client.adapters.results import headline, run_result
from arramon_client.agent import Observation
from arramon_client.errors import UsageError
from tests import tiny
from tests.serving import Server

PERFECT = {"nDTW": 1.0, "CTC-3": 1.0, "PTC@CTC-3": 1.0}


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data = tmp_path_factory.mktemp("data")
    tiny.write(data, count=3)
    tiny.write(data, "secret", 3, hidden=True)
    return data


@pytest.fixture(scope="module")
def server(data: Path) -> Iterator[Server]:
    server = Server(data, "127.0.0.1:0")
    yield server
    assert server.stop() == 0


async def finish(played: AdapterEpisode, actions: tuple[int, ...]) -> dict[str, Any]:
    """Play some actions, and end the episode."""
    for step, action in enumerate(actions):
        await played.episode.act(step, action)
    return await played.finish("enough")


def test_an_episode_of_an_open_split_has_a_run_of_its_own(server: Server) -> None:
    host = Host(language="en", split="tiny", agent="a", server=server.address, sensors=())
    sections = host.episodes()
    assert (set(sections.values()), host.episode_count, host.is_hidden) == ({"1"}, 3, False)

    async def main() -> list[dict[str, Any]]:
        runs = EpisodeRuns(host)
        both = [await runs.open(episode_id) for episode_id in list(sections)[:2]]
        return [await finish(both[0], tiny.ACTIONS), await finish(both[1], tiny.ACTIONS[:4])]

    first, second = asyncio.run(main())
    host.close()
    assert [first["episode_id"], second["episode_id"]] == list(sections)[:2]
    assert first["run_id"] != second["run_id"]
    assert (first["cause"], headline(first["scores"])) == ("AGENT_FINISHED", PERFECT)
    assert (second["cause"], second["scores"]["turn 2"]["CTC-3"]) == ("FORFEITED", 0.0)
    with Run.resume(first["run_id"], server=server.address) as run:
        assert run_result(run.report(), run.receipt()) == first


def test_a_hidden_split_is_one_run_whose_last_episode_has_its_scores(server: Server) -> None:
    host = Host(language="en", split="secret", agent="a", server=server.address, sensors=())
    with pytest.raises(UsageError, match="split 'secret' is hidden"):
        host.episodes()

    async def main() -> list[dict[str, Any]]:
        runs = EpisodeRuns(host, parallel=2)
        two = [await runs.open("1"), await runs.open("2")]
        results = [await finish(played, tiny.ACTIONS) for played in two]
        last = await runs.open("3")
        results.append(await finish(last, tiny.ACTIONS))
        with pytest.raises(UsageError, match="the hidden split 'secret' has no more episodes in this run"):
            await runs.open("4")
        return results

    *early, last = asyncio.run(main())
    host.close()
    (run_id,) = {result["run_id"] for result in (*early, last)}
    assert [result["scores"] for result in (*early, last)] == [None] * 3
    assert ["run_scores" in result for result in early] == [False] * 2
    assert last["run_scores"]["total"]["nDTW"] > 0.9
    with Run.resume(run_id, server=server.address) as run:
        assert run_result(run.report(), run.receipt())["episode_id"] is None


def test_an_embedded_server_is_shared_by_all_runs(data: Path) -> None:
    host = Host(language="en", split="tiny", agent="a", data=data, sensors=())
    other = host.with_choice("hi", "tiny")
    assert host.server_options() == other.server_options()
    assert (len(host.episodes()), len(other.episodes())) == (3, 2)
    other.close()
    with Run.create(language="en", agent="a", **host.run_options("1")) as run:
        assert next(run.episodes()).look().step == 0
        run.cancel()
    host.close()


SEEN = Observation("1", 2, "assembly", 7, "Put it there.", 2, 5, rgb=np.full((4, 6, 3), 200, np.uint8))


def test_a_model_reads_step_phase_instruction_and_why_an_act_stopped() -> None:
    text = "Step 7: turn 2 of 2, assembly phase, 5 steps left in it.\nInstruction: Put it there."
    assert observation_text(SEEN) == text
    assert observation_text(SEEN, "blocked") == f"Your act stopped early: blocked.\n{text}"
    png = picture(SEEN)
    assert png is not None
    assert np.asarray(Image.open(io.BytesIO(png))).tolist() == np.full((4, 6, 3), 200).tolist()


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ([], "actions are [], expected 1 to 10 of forward, left, right, interact"),
        (["left"] * 11, "expected 1 to 10 of"),
        ("left", "actions are 'left', expected"),
        (["left", "jump"], "there is no action 'jump', expected"),
    ],
)
def test_other_actions_are_refused(names: Any, message: str) -> None:
    with pytest.raises(UsageError) as caught:
        actions_of(names)
    assert message in str(caught.value)
    assert actions_of(["forward", "left", "right", "interact"]) == [0, 1, 2, 3]
