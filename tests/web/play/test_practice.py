"""The tutorial: its ground truth is what its texts say, and it is played on an engine of its own."""

import asyncio
from contextlib import closing

import pytest

from arramon_client.world import Action
from arramon_server.episodes.episode import Episode
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.sim.city import city_scene
from arramon_server.sim.physics import physics_of
from arramon_server.sim.rules import Limits
from arramon_server.web.page_texts import all_texts
from arramon_server.web.play.practice_split import practice_split
from tests.web.play.page_client import PLAYER, PageServer, page

SPLIT = practice_split()
EPISODES = list(SPLIT.episodes.values())


def actions_of(episode: Episode) -> list[Action]:
    return [action for turn in episode.turns for action in (*turn.actions, *turn.room_actions)]


@pytest.mark.parametrize("episode", EPISODES, ids=lambda episode: episode.episode_id)
def test_the_ground_truth_is_perfect(episode: Episode) -> None:
    with closing(physics_of(city_scene(SPLIT.sections["1"]))) as ground:
        session = EpisodeSession(episode, ground, Limits())
        for action in actions_of(episode):
            session.apply(action)
    assert session.state.finished
    for turn in session.scores().turns:
        assert {turn[name] for name in ("nDTW", "CTC-0", "PTC")} == {1.0}


def test_every_language_of_the_pages_has_the_texts() -> None:
    for episode in EPISODES:
        assert set(episode.instructions) == set(all_texts())


def test_practice_is_played_in_order_and_counts_nowhere(server: PageServer) -> None:
    async def play() -> None:
        async with page(server.site) as client:
            new = {"split": "practice", "language": "hi", "episodes": 0}
            await client.say(type="hello", player=PLAYER, size=224, practice=True, new=new)
            opened = await client.until("opened")
            assert (opened["split"], opened["episodes"], opened["aids"]["landing_diagram"]) == ("practice", 3, True)
            for episode in EPISODES:
                for action in actions_of(episode):
                    state = await client.until("state")
                    assert state["episode"] == episode.episode_id
                    assert "seconds_left" not in state
                    await client.key(state, action)
                await client.until("episode_ended")
                await client.say(type="scores", episode=episode.episode_id)
            await client.until("run_ended")
            assert (await client.until("scores"))["placed"] == [True, True]
            await client.say(type="publish")
            while (refused := await client.message())["type"] == "scores":
                pass
            assert refused["type"] == "problem"
        async with page(server.site) as client:  # not among the host's runs
            await client.hello(opened["run"])
            assert (await client.message())["code"] == "NotFound"

    asyncio.run(play())
