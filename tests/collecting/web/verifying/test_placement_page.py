"""What comes before the first verification: the device, the screening test, the placement test."""

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest

from arramon_client.world import Action
from arramon_server.episodes.episode import Episode
from arramon_server.web.play.practice_split import practice_split
from tests.collecting.web.verify_site import DEVICE, NAME, VerifySite, browsers, hello, verify_site

HOME = f"/en/collect/{NAME}/"

RIGHT = {"q1": "b", "q2": "c", "q3": "a", "q4": "b"}

LAST = list(practice_split().episodes.values())[-1]


def actions_of(episode: Episode) -> list[Action]:
    return [action for turn in episode.turns for action in (*turn.actions, *turn.room_actions)]


@pytest.fixture
def site(tmp_path: Path) -> Iterator[VerifySite]:
    with verify_site(tmp_path, screening_attempts=2, device={"min_width": 800}) as site:
        yield site


def test_from_the_device_to_the_first_task(site: VerifySite) -> None:
    site.text(site.worker())

    async def play() -> None:
        async with browsers(site, site.worker(ready=False)) as (person,):

            async def take() -> str:
                status, address = await person.post("/take", stage="verify")
                assert status == 303
                return address.removeprefix(HOME)

            assert await take() == "device?stage=verify"
            chosen = '<input type="hidden" name="stage" value="verify">'
            for query, leads_on in (("?stage=verify", True), ("?stage=fly", False), ("", False)):
                status, page = await person.get(f"/device{query}")
                assert (status, chosen in page) == (200, leads_on)
            status, answer = await person.post_json("/device", {**DEVICE, "width": 700})
            assert (status, answer["problems"]) == (200, ["too_narrow"])
            assert "700 pixels wide, and 800 are needed" in answer["message"]
            assert await take() == "device?stage=verify"
            assert (await person.post_json("/device", {**DEVICE, "width": "wide"}))[0] == 400
            assert await person.post_json("/device", DEVICE) == (200, {"problems": [], "message": ""})

            assert await take() == "screening/verify"
            assert (await person.post("/screening/verify", **RIGHT)) == (303, f"{HOME}placement?passed")

            assert await take() == "placement"
            async with person.socket("/placement") as client:
                await hello(client, practice=True, new={"split": "practice", "language": "en", "episodes": 1})
                assert (await client.until("opened"))["episodes"] == 1
                for action in actions_of(LAST):
                    state = await client.until("state")
                    assert state["episode"] == LAST.episode_id
                    await client.key(state, action)
                await client.until("run_ended")
                assert site.store.workers.get(person.person.worker_id).placement_passed_at is None
                await client.say(type="scores", episode=LAST.episode_id)
                assert (await client.until("scores"))["placed"] == [True, True]
            assert site.store.workers.get(person.person.worker_id).placement_passed_at is not None
            assert (await take()).startswith("verify/")

    asyncio.run(play())


def test_the_placement_test_is_not_passed_by_another_s_run(site: VerifySite) -> None:
    async def play() -> None:
        async with browsers(site, site.worker(ready=False), site.worker(ready=False)) as (person, other):
            async with person.socket("/placement") as client:
                await hello(client, practice=True, new={"split": "practice", "language": "xx", "episodes": 1})
                opened = await client.until("opened")
                assert (opened["language"], opened["aids"]["landing_diagram"]) == ("en", True)
            async with other.socket("/placement") as client:
                await client.say(type="hello", player="c" * 32, size=224, practice=True, run=opened["run"])
                assert (await client.message())["code"] == "NotFound"
            async with other.socket("/placement") as client:
                await hello(client)  # no practice: a run of its own
                assert (await client.message())["code"] == "Conflict"

    asyncio.run(play())


def test_a_misplaced_object_does_not_pass(site: VerifySite) -> None:
    async def play() -> None:
        async with browsers(site, site.worker(ready=False)) as (person,), person.socket("/placement") as client:
            await hello(client, practice=True, new={"split": "practice", "language": "hi", "episodes": 1})
            state = await client.until("state")
            for action in (Action.FORWARD, Action.INTERACT, Action.INTERACT):  # placed where one begins
                await client.key(state, action)
                state = await client.until("state")
            await client.say(type="give_up", episode=state["episode"])
            await client.until("run_ended")
            await client.say(type="scores", episode=LAST.episode_id)
            assert (await client.until("scores"))["placed"] == [False, False]
            assert site.store.workers.get(person.person.worker_id).placement_passed_at is None

    asyncio.run(play())


def test_wrong_answers_are_explained_and_then_there_is_a_pause(site: VerifySite) -> None:
    async def play() -> None:
        async with browsers(site, site.worker(ready=False)) as (person,):
            status, page = await person.post("/screening/verify", **{**RIGHT, "q2": "a"})
            assert (status, "Attempts left: 1" in page, "Only what is near" in page) == (200, True, True)
            status, page = await person.post("/screening/verify", **{**RIGHT, "q3": "b"})
            assert (status, "you can try again from" in page, "<form" in page.split("<main")[1]) == (200, True, False)
            await person.post("/screening/verify", **RIGHT)  # during the pause
            assert site.store.workers.get(person.person.worker_id).screening["verify"]["passed_at"] is None

    asyncio.run(play())


def test_nobody_verifies_before_the_tests(site: VerifySite) -> None:
    site.text(site.worker())

    async def play() -> None:
        async with browsers(site, site.worker(ready=False)) as (person,):
            path = person.claim()  # as if the tests had been passed
            assert await person.get(path) == (303, f"{HOME}device")
            status, _ = await person.get(f"{path}/socket")
            assert status == 409

    asyncio.run(play())
