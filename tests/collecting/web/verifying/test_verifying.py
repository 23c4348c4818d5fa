"""Verifying through the real WebSocket: kept or discarded, flags, restart, two tabs, forged ids; what is shown."""

import asyncio
import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import aiohttp
import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import leaderboard_pb2 as lb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon.v1.leaderboard_pb2_grpc import LeaderboardStub
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.callers import Role
from tests import tiny
from tests.api.player import create
from tests.collecting.web.verify_site import NAME, TEXTS, VerifySite, browsers, hello, verify_site
from tests.serving import METADATA
from tests.web.play.page_client import PageServer

AWAY = (tiny.L, tiny.L, tiny.F)
"""Walks away until the step limit."""


@pytest.fixture
def site(tmp_path: Path) -> Iterator[VerifySite]:
    with verify_site(tmp_path) as site:
        yield site


@pytest.mark.parametrize(
    ("walks", "state", "successes"),
    [([AWAY, tiny.ACTIONS, AWAY], "kept", [False, True, False]), ([AWAY, AWAY, AWAY], "discarded", [False] * 3)],
)
def test_three_verifiers_decide_about_a_text(
    site: VerifySite, walks: list[tuple[int, ...]], state: str, successes: list[bool]
) -> None:
    author = site.worker()
    text = site.text(author)

    async def play() -> None:
        async with browsers(site, *(site.worker() for _ in walks)) as people:
            for person, walk in zip(people, walks, strict=True):
                assert site.store.texts.get(text.text_id).state == "verifying"
                path = person.claim()
                assert (await person.get(path))[0] == 200
                messages = await person.follow(path, walk)
                assert messages[-1]["type"] == "run_ended"
                answer = await person.post(f"{path}/hand-in", **{"flag-1-navigation-unclear": "on"})
                assert answer == (303, f"/en/collect/{NAME}{path}")
                assert "Handed in" in (await person.get(path))[1]

    asyncio.run(play())
    assert site.store.texts.get(text.text_id).state == ("in_review" if state == "kept" else state)
    found = site.store.verifications.of_text(text.text_id)
    assert [min(one.ptc) == 1.0 and min(one.ndtw) > 0.9 for one in found] == successes
    assert {one.flags for one in found} == {("1-navigation-unclear",)}
    assert all(one.counts for one in found)
    assert [site.store.ledger.total_of(one.worker_id) for one in found] == [20, 20, 20]


def test_a_text_without_flags_is_kept_and_paid_once(site: VerifySite) -> None:
    author = site.worker()
    text = site.text(author)

    async def play() -> None:
        async with browsers(site, *(site.worker() for _ in range(3))) as people:
            for person in people:
                path = person.claim()
                await person.follow(path)
                for _ in range(2):  # the button was pressed twice
                    assert (await person.post(f"{path}/hand-in"))[0] == 303

    asyncio.run(play())
    assert site.store.texts.get(text.text_id).state == "kept"
    (verification, *_) = site.store.verifications.of_text(text.text_id)
    assert verification.path[0] == ((0.0, 0.0), (0.0, 1.0), (0.0, 2.0))
    assert verification.placed_cells == ((2, 1, 2), (2, 2, 2))
    assert site.store.ledger.total_of(author.worker_id) == 100 + 10
    assert site.store.ledger.total(NAME) == 110 + 3 * 20


def test_the_page_is_told_no_more_than_an_agent_of_a_hidden_split(site: VerifySite) -> None:
    site.text(site.worker())

    async def play() -> tuple[str, list[dict[str, Any]], str]:
        async with browsers(site, site.worker()) as (person,):
            path = person.claim()
            _, page = await person.get(path)
            async with person.socket(path) as client:
                await hello(client)
                state = await client.until("state")
                await client.say(type="look", episode=state["episode"], step=0, degrees=30)  # no aid of verifiers
                assert (await client.message())["code"] == "Conflict"
            messages = await person.follow(path)
            async with person.socket(path) as client:  # what it does not offer, asked for nevertheless
                await hello(client)
                await client.until("run_ended")
                for request in ({"type": "scores", "episode": ""}, {"type": "publish"}):
                    await client.say(**request)
                    refused = await client.message()
                    assert (refused["type"], refused["code"]) == ("problem", "Conflict")
            return path, messages, page

    path, messages, page = asyncio.run(play())
    opened, *_ = messages
    assert opened["is_hidden"] is True
    assert opened["aids"]["landing_diagram"] is True
    assert sum(opened["aids"].values()) == 1
    fields = {
        "opened": {
            "run", "split", "language", "is_hidden", "participant", "size", "aids", "episodes", "ended", "has_clocks",
        },
        "started": {"episode", "step"},
        "state": {
            "episode", "step", "turn", "phase", "instruction", "phase_step", "steps_left", "carries", "carried",
            "outcome", "landing",
        },
        "phase_ended": {"episode", "phase", "turn", "forced"},
        "episode_ended": {"episode", "cause", "ended"},
        "run_ended": {"run", "state", "ended"},
    }  # fmt: skip
    for message in messages:
        assert message.keys() - {"type"} <= fields[message["type"]], message
    assert {message["carried"] for message in messages if message["type"] == "state"} == {""}
    (episode,) = {message["episode"] for message in messages if "episode" in message}
    assert path == f"/verify/{episode}"  # not the id that the split has
    said = {message["instruction"] for message in messages if message["type"] == "state"}
    assert said == {text for pair in TEXTS for text in pair}
    for secret in ("tiny", "nDTW", "1.000", "<polyline", '"ndtw"'):
        assert secret not in json.dumps(messages)
        assert secret not in page


def test_a_known_episode_looks_like_a_text(tmp_path: Path) -> None:
    with verify_site(tmp_path, gold_share=0.5) as site:
        site.text(site.worker(), "1")

        async def play() -> None:
            async with browsers(site, site.worker()) as (person,):
                task = site.store.tasks.claim_verify(site.collection, person.person, ["2"])
                assert task is not None
                assert task.is_gold
                messages = await person.follow(f"/verify/{task.task_id}")
                assert messages[0]["split"] == f"collecting/{NAME}/{task.task_id}"
                assert {one["episode"] for one in messages if "episode" in one} == {task.task_id}
                assert (await person.post(f"/verify/{task.task_id}/hand-in"))[0] == 303
                assert site.store.verifications.get(task.task_id).ptc == (1.0, 1.0)

        asyncio.run(play())


def test_a_restart_in_the_middle_loses_nothing(site: VerifySite) -> None:
    site.text(site.worker())

    async def play() -> None:
        async with browsers(site, site.worker()) as (person,):
            path = person.claim()
            async with person.socket(path) as client:
                await hello(client)
                run = (await client.until("opened"))["run"]
                await client.key(await client.until("state"), tiny.F)
                await client.until("state")
            assert (await person.post_json(f"{path}/flags", {"flags": ["1-navigation-wrong"]}))[0] == 200
            site.kill()
            site.start()
            assert 'value="1-navigation-wrong" checked' in (await person.get(path))[1]
            async with person.socket(path) as client:
                await hello(client)
                assert (await client.until("opened"))["run"] == run
                state = await client.until("state")
                assert state["step"] == 1
                for action in tiny.ACTIONS[1:]:
                    await client.key(state, action)
                    while (state := await client.message())["type"] not in ("state", "run_ended"):
                        pass
            assert (await person.post(f"{path}/hand-in"))[0] == 303

    asyncio.run(play())


def test_the_latest_of_two_tabs_plays(site: VerifySite) -> None:
    site.text(site.worker())

    async def play() -> None:
        async with browsers(site, site.worker()) as (person,):
            path = person.claim()
            async with person.socket(path) as first, person.socket(path) as second:
                await hello(first)
                run = (await first.until("opened"))["run"]
                await first.until("state")
                await hello(second)
                assert (await second.until("opened"))["run"] == run
                assert (await first.message())["code"] == "Replaced"
                await second.key(await second.until("state"), tiny.L)
                assert (await second.until("state"))["outcome"] == "turned"

    asyncio.run(play())


def test_nobody_else_has_the_task(site: VerifySite) -> None:
    site.text(site.worker())

    async def play() -> None:
        async with browsers(site, site.worker(), site.worker(), site.host) as (person, other, host):
            path = person.claim()
            await person.get(path)
            for stranger in (other, host):
                assert (await stranger.get(path))[0] == 404
                assert (await stranger.post(f"{path}/hand-in"))[0] == 404
                assert (await stranger.post_json(f"{path}/flags", {"flags": []}))[0] == 404
            assert (await person.get(f"/verify/{'0' * 32}"))[0] == 404
            # forged requests, and sockets of other sites
            assert (await person.post_json(f"{path}/flags", {"flags": []}, csrf="0" * 43))[0] == 403
            assert (await person.send(f"{path}/hand-in", data={"csrf": other.csrf}))[0] == 403
            with pytest.raises(aiohttp.WSServerHandshakeError, match="403"):
                await person.session.ws_connect(
                    f"{site.pages}{path}/socket",
                    headers={**person.headers, "Origin": "http://elsewhere.example"},
                )
            with pytest.raises(aiohttp.WSServerHandshakeError, match="401"):
                await person.session.ws_connect(f"{site.pages}{path}/socket", headers={"Origin": site.site})
            assert (await person.post_json(f"{path}/flags", {"flags": ["no such"]}))[0] == 400

    asyncio.run(play())


def test_hand_in_takes_what_was_followed_alone(site: VerifySite) -> None:
    site.text(site.worker())

    async def play() -> None:
        async with browsers(site, site.worker()) as (person,):
            path = person.claim()
            status, page = await person.post(f"{path}/hand-in")
            assert (status, "has not been followed yet" in page) == (409, True)
            async with person.socket(path) as client:
                await hello(client)
                state = await client.until("state")
                status, page = await person.post(f"{path}/hand-in")
                assert (status, "has not ended yet" in page) == (409, True)
                await client.say(type="give_up", episode=state["episode"])
                await client.until("run_ended")
            status, page = await person.post(f"{path}/hand-in")
            assert (status, "You ended before the last object was placed" in page) == (200, True)
            assert (await person.post(f"{path}/hand-in", **{"flag-1-navigation-unclear": "on"}))[0] == 303

    asyncio.run(play())


def test_what_is_too_quick_neither_counts_nor_pays(tmp_path: Path) -> None:
    with verify_site(tmp_path, min_seconds_verify=600) as site:
        text = site.text(site.worker())

        async def play() -> None:
            async with browsers(site, site.worker()) as (person,):
                path = person.claim()
                await person.follow(path)
                await person.post(f"{path}/hand-in")
                assert "faster than anybody" in (await person.get(path))[1]
                assert site.store.ledger.total_of(person.person.worker_id) == 0

        asyncio.run(play())
        assert [one.counts for one in site.store.verifications.of_text(text.text_id)] == [False]


def test_runs_of_verifications_are_nobody_else_s(site: VerifySite) -> None:
    """Over gRPC and on the public pages there is no trace of them; not even the host publishes one."""
    text = site.text(site.worker())

    async def play() -> tuple[str, str]:
        async with browsers(site, site.worker()) as (person,):
            path = person.claim()
            messages = await person.follow(path)
            for page in ("/en/", "/en/watch", "/en/people", "/standings.json"):
                async with person.session.get(site.site + page) as answer:
                    content = await answer.text()
                    assert answer.status in (200, 404)
                    assert "collecting" not in content
                    assert messages[0]["run"] not in content
            run = messages[0]["run"]
            for page in (f"/en/runs/{run}", f"/en/runs/{run}/episodes/{path[8:]}", f"/runs/{run}/receipt.json"):
                async with person.session.get(site.site + page) as answer:
                    assert answer.status == 404
            return run, messages[0]["split"]

    run, split = asyncio.run(play())
    with grpc.insecure_channel(site.listen) as channel:
        evaluation, board = EvaluationStub(channel), LeaderboardStub(channel)
        told = evaluation.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA)
        assert split not in {one.name for one in told.splits}
        assert run not in {one.run_id for one in evaluation.ListRuns(pb.ListRunsRequest(), metadata=METADATA).runs}
        for call in (
            partial(evaluation.GetRun, pb.GetRunRequest(run_id=run), metadata=METADATA),
            partial(create, evaluation, split=split, language="hi"),
            partial(create, evaluation, split=f"collecting/{NAME}/{text.text_id}", language="hi"),
            partial(board.Publish, lb.PublishRequest(run_id=run), metadata=METADATA),
        ):
            assert refusal(call) is grpc.StatusCode.NOT_FOUND
        as_host = (*METADATA, ("authorization", f"Bearer {Accounts(site.database).create_token('boss', Role.HOST)}"))
        publish = partial(board.Publish, lb.PublishRequest(run_id=run), metadata=as_host)
        assert refusal(publish) is grpc.StatusCode.FAILED_PRECONDITION
    rescored = subprocess.run(
        [sys.executable, "-m", "arramon_server", "rescore", "--all", "--data", str(site.data)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (rescored.returncode, rescored.stdout, rescored.stderr) == (0, "", "")


def refusal(call: Callable[[], object]) -> grpc.StatusCode:
    with pytest.raises(grpc.RpcError) as refused:
        call()
    code: grpc.StatusCode = refused.value.code()
    return code


def test_a_second_process_goes_on_with_the_task(site: VerifySite) -> None:
    site.text(site.worker())
    second = PageServer(site.data, "--steps", "20")

    async def play() -> None:
        async with browsers(site, site.worker()) as (person,):
            path = person.claim()
            async with person.socket(path) as client:
                await hello(client)
                await client.key(await client.until("state"), tiny.F)
                await client.until("state")
            person.pages = person.pages.replace(site.site, second.site)
            async with person.socket(path, site=second.site) as client:
                await hello(client)
                state = await client.until("state")
                assert state["step"] == 1
                for action in tiny.ACTIONS[1:]:
                    await client.key(state, action)
                    while (state := await client.message())["type"] not in ("state", "run_ended"):
                        pass
            assert (await person.post(f"{path}/hand-in"))[0] == 303

    asyncio.run(play())
    assert second.stop() == 0
