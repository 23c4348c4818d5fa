"""The play page's WebSocket on a real server: play, exactly once, resuming, takeover, refusals."""

import asyncio
import json
import ssl
from collections.abc import Awaitable, Callable
from contextlib import closing
from pathlib import Path

import aiohttp
import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from tests import tiny
from tests.api.people import token_of
from tests.api.player import Player, create
from tests.proxy import Proxies
from tests.relay import Relay
from tests.serving import METADATA
from tests.web.play.page_client import PageClient, PageServer, page

F, L, R, P = tiny.F, tiny.L, tiny.R, tiny.P


def with_page(site: str, work: Callable[[PageClient], Awaitable[object]]) -> object:
    async def run() -> object:
        async with page(site) as client:
            return await work(client)

    return asyncio.run(run())


def test_a_page_that_pauses_asks_for_the_next_episode(server: PageServer) -> None:
    async def play(client: PageClient) -> None:
        new = {"split": "tiny", "language": "en", "episodes": 2}
        await client.say(type="hello", player="b" * 16, size=224, token="", new=new, pauses=True)
        first = await client.until("state")
        await client.say(type="give_up", episode=first["episode"])
        await client.until("episode_ended")
        await client.say(type="scores", episode=first["episode"])
        assert (await client.message())["type"] == "scores"
        await client.say(type="next")
        assert (await client.message())["type"] == "started"
        second = await client.until("state")
        assert (second["episode"] != first["episode"], second["step"]) == (True, 0)

    with_page(server.site, play)


def test_a_page_that_comes_back_between_two_episodes_is_still_there(server: PageServer) -> None:
    """The end of the latest episode comes again, and the next one, with its clock, begins only when it is asked for."""

    async def play() -> None:
        new = {"split": "tiny", "language": "en", "episodes": 2}
        hello = {"type": "hello", "player": "b" * 16, "size": 224, "token": "", "pauses": True}
        async with page(server.site) as client:
            await client.say(**hello, new=new)
            run = (await client.until("opened"))["run"]
            first = await client.until("state")
            await client.say(type="give_up", episode=first["episode"])
            ended = await client.until("episode_ended")
        for _ in range(2):
            async with page(server.site) as client:
                await client.say(**hello, run=run)
                assert (await client.until("opened"))["ended"] == 1
                assert await client.message() == ended
                await client.say(type="scores", episode=first["episode"])
                assert (await client.message())["type"] == "scores"
        with closing(Database(f"sqlite:///{server.data / 'journal.db'}")) as database:
            assert Journal(database).open_claims(run) == []
        async with page(server.site) as client:
            await client.say(**hello, run=run)
            await client.until("episode_ended")
            await client.say(type="next")
            second = await client.until("state")
            assert second["episode"] != first["episode"]
            await client.key(second, R)
            await client.until("state")
        async with page(server.site) as client:  # in the middle of an episode nothing waits
            await client.say(**hello, run=run)
            state = await client.until("state")
            assert (state["episode"], state["step"]) == (second["episode"], 1)
            await client.say(type="give_up", episode=state["episode"])
            assert (await client.until("run_ended"))["ended"] == 2
        async with page(server.site) as client:
            await client.say(**hello, run=run)
            await client.until("opened")
            assert (await client.message())["type"] == "run_ended"

    asyncio.run(play())


def test_an_episode_from_the_first_key_to_the_scores(server: PageServer) -> None:
    async def play(client: PageClient) -> None:
        await client.hello(size=448)
        opened, *messages = await client.play()
        assert {name for name, is_on in opened["aids"].items() if is_on} == {"landing_diagram", "compass"}
        assert (opened["split"], opened["language"], opened["size"], opened["episodes"]) == ("tiny", "en", 448, 1)
        states = [message for message in messages if message["type"] == "state"]
        assert [state["step"] for state in states] == list(range(13))
        assert [step for step, _ in client.frames] == list(range(13))
        assert [state["outcome"] for state in states] == [
            "", "moved", "moved", "picked_up", "moved", "placed", "turned", "turned", "turned", "moved", "moved",
            "picked_up", "moved",
        ]  # fmt: skip
        assert [state["carried"] for state in states if state["carries"]] == ["striped red mug"] * 2 + [
            "dotted blue TV"
        ] * 2
        assert [state["heading"] for state in states][5:9] == [0, 30, 60, 90]
        assert states[3]["landing"] == {"cell": [2, 0], "heading": 0, "landing": [2, 1]}
        assert "landing" not in states[0]
        assert [message["type"] for message in messages[-3:]] == ["phase_ended", "episode_ended", "run_ended"]
        ended = messages[-2]
        assert (ended["cause"], ended["ended"]) == ("AGENT_FINISHED", 1)
        await client.say(type="scores", episode=ended["episode"])
        scores = await client.until("scores")
        assert "<svg" in scores["html"]
        assert "1.000" in scores["html"]
        await client.say(type="scores")
        assert "args:compass=on+frame_strip=off+landing_diagram=on" in (await client.until("scores"))["html"]
        await client.say(type="publish")
        assert (await client.until("published"))["run"] == opened["run"]
        await client.key(states[-1], F)
        problem = await client.message()
        assert (problem["code"], problem["type"]) == ("Conflict", "problem")

    with_page(server.site, play)


def test_a_key_counts_once_however_often_it_is_sent(server: PageServer) -> None:
    async def play(client: PageClient) -> None:
        await client.hello()
        state = await client.until("state")
        for _ in range(5):
            await client.key(state, F)
        for _ in range(5):
            again = await client.until("state")
            assert (again["step"], again["outcome"]) == (1, "moved")
        await client.key(state, R)  # an answer to step 0 again, but another one
        assert (await client.message())["code"] == "STEP_BEHIND"
        assert (await client.until("state"))["step"] == 1
        await client.key(again, F, step=7)
        assert (await client.message())["code"] == "STEP_AHEAD"
        await client.say(type="key", episode="no such", step=1, action=0)
        assert (await client.message())["code"] == "NOT_YOUR_EPISODE"
        await client.key(again, L)
        turned = await client.until("state")
        assert (turned["step"], turned["outcome"]) == (2, "turned")

    with_page(server.site, play)


def test_a_page_comes_back_to_its_step(server: PageServer) -> None:
    async def play() -> None:
        async with page(server.site) as client:
            await client.hello()
            run = (await client.until("opened"))["run"]
            await client.key(await client.until("state"), R)
            before = await client.until("state")
        async with page(server.site) as client:
            await client.hello(run)
            state = await client.until("state")
            assert {**state, "outcome": "turned"} == {**before, "seconds_left": state["seconds_left"]}
            assert state["outcome"] == ""  # what the key did was said before
            await client.key(state, L)
            assert (await client.until("state"))["outcome"] == "turned"

    asyncio.run(play())


def test_a_second_page_of_the_same_browser_takes_over(server: PageServer) -> None:
    async def play() -> None:
        async with page(server.site) as first, page(server.site) as second:
            await first.hello()
            run = (await first.until("opened"))["run"]
            state = await first.until("state")
            await second.hello(run)
            assert (await second.until("state"))["step"] == 0
            closed = await first.message()
            assert (closed["type"], closed["code"]) == ("closed", "Replaced")
            assert await first.is_closed()
            await second.key(state, F)
            assert (await second.until("state"))["step"] == 1

    asyncio.run(play())


def test_a_page_comes_back_after_a_restart(tmp_path: Path) -> None:
    server = PageServer(tmp_path)

    async def play_one_step(run: str) -> tuple[str, int]:
        async with page(server.site) as client:
            await client.hello(run)
            run = (await client.until("opened"))["run"]
            state = await client.until("state")
            await client.key(state, R)
            assert (await client.until("state"))["step"] == state["step"] + 1
            return run, state["step"]

    run, step = asyncio.run(play_one_step(""))
    assert step == 0
    server.kill()
    server.start()
    assert asyncio.run(play_one_step(run)) == (run, 1)
    assert server.stop() == 0


def test_hidden_splits_tell_a_person_no_more_than_an_agent(server: PageServer) -> None:
    async def play(client: PageClient) -> None:
        await client.hello(split="secret", episodes=0)
        messages = await client.play()
        states = [message for message in messages if message["type"] == "state"]
        assert len(states) == 13 * 3
        assert {state["carried"] for state in states} == {""}
        assert any(state["carries"] for state in states)
        await client.say(type="scores", episode=states[0]["episode"])
        assert (await client.message())["code"] == "Conflict"
        await client.say(type="scores")
        assert "<table>" in (await client.until("scores"))["html"]

    with_page(server.site, play)


def test_giving_up_scores_the_episode_and_goes_on(server: PageServer) -> None:
    async def play(client: PageClient) -> None:
        await client.hello(episodes=2)
        state = await client.until("state")
        await client.say(type="give_up", episode=state["episode"])
        ended = await client.until("episode_ended")
        assert (ended["cause"], ended["ended"]) == ("FORFEITED", 1)
        assert (await client.until("state"))["episode"] != state["episode"]

    with_page(server.site, play)


def test_a_person_gets_new_episodes_first(server: PageServer) -> None:
    async def episode(earlier: list[str]) -> tuple[str, str]:
        async with page(server.site) as client:
            await client.hello(earlier=earlier)
            run = (await client.until("opened"))["run"]
            return run, (await client.until("state"))["episode"]

    runs: list[str] = []
    seen: list[str] = []
    for _ in range(3):
        run, episode_id = asyncio.run(episode([*runs, "f" * 32]))
        runs.append(run)
        seen.append(episode_id)
    assert len(set(seen)) == 3


@pytest.mark.parametrize(
    ("hello", "code", "said"),
    [
        ({"run": "0" * 32}, "NotFound", "there is no run"),
        ({"size": 300}, "BadInput", "size is 300, expected one of 448, 224"),
        ({"split": "none"}, "NotFound", "there is no split 'none'"),
        ({"language": "te"}, "NotFound", "has no episodes in 'te'"),
        ({"episodes": 0}, "BadInput", "episodes is 0, expected 1 to 100"),
        ({"episodes": 50}, "BadInput", "50 episodes were requested"),
        ({"participant": "a\nb"}, "BadInput", "name"),
        ({"token": "arramon_no_token"}, "Unauthenticated", "token"),
        ({"player": "x"}, "BadInput", "player is 'x'"),
    ],
)
def test_first_messages_that_are_refused(server: PageServer, hello: dict[str, object], code: str, said: str) -> None:
    async def play(client: PageClient) -> None:
        await client.hello(**hello)  # type: ignore[arg-type]
        closed = await client.message()
        assert (closed["type"], closed["code"]) == ("closed", code)
        assert said in closed["message"]
        assert await client.is_closed()

    with_page(server.site, play)


def test_an_agents_run_is_no_persons_run(server: PageServer) -> None:
    with grpc.insecure_channel(server.address) as channel:
        run = create(EvaluationStub(channel)).run_id

    async def play(client: PageClient) -> None:
        await client.hello(run)
        closed = await client.message()
        assert (closed["code"], closed["message"]) == (
            "NotFound",
            f"run {run!r} is of the agent 'test', not of a person",
        )

    with_page(server.site, play)


@pytest.mark.parametrize("agent", ["human", " Human "])
def test_agents_cannot_call_themselves_human(server: PageServer, agent: str) -> None:
    with grpc.insecure_channel(server.address) as channel, pytest.raises(grpc.RpcError) as refused:
        create(EvaluationStub(channel), agent=agent)
    assert refused.value.code() is grpc.StatusCode.INVALID_ARGUMENT
    assert "which only runs have that people play on the server's pages" in str(refused.value.details())


@pytest.mark.parametrize("origin", ["", "https://example.org", "http://127.0.0.1:1"])
def test_pages_of_other_sites_are_refused(server: PageServer, origin: str) -> None:
    async def play() -> None:
        async with page(server.site, origin=origin):
            raise AssertionError("not refused")

    with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
        asyncio.run(play())
    assert refused.value.status == 403


def test_a_site_that_points_its_name_at_this_machine_is_refused(server: PageServer) -> None:
    async def play() -> int:
        headers = {"Host": "evil.example", "Origin": "http://evil.example"}
        async with aiohttp.ClientSession() as session:
            try:
                async with session.ws_connect(f"{server.site}/play/socket", headers=headers):
                    return 101
            except aiohttp.WSServerHandshakeError as error:
                return error.status

    assert asyncio.run(play()) == 403


def test_malformed_messages_change_nothing_and_end_in_a_refusal(server: PageServer) -> None:
    async def play(client: PageClient) -> None:
        await client.hello()
        state = await client.until("state")
        for text in ("", "{", "[]", '{"type": "key"}', json.dumps({"type": "fly"})):
            await client.connection.send_str(text)
            problem = await client.message()
            assert (problem["type"], problem["code"]) == ("problem", "BadInput")
        await client.key(state, F)
        assert (await client.until("state"))["step"] == 1
        for _ in range(45):
            await client.connection.send_str("x")
        last = [await client.message() for _ in range(45)][-1]
        assert (last["type"], last["code"]) == ("closed", "BadInput")
        assert last["message"].startswith("50 messages were refused")

    with_page(server.site, play)


@pytest.mark.parametrize("data", [b"\x00", "x" * 20_000])
def test_binary_and_oversized_messages_close_the_connection(server: PageServer, data: bytes | str) -> None:
    async def play(client: PageClient) -> str:
        await client.hello()
        run: str = (await client.until("opened"))["run"]
        await client.until("state")
        await (client.connection.send_bytes(data) if isinstance(data, bytes) else client.connection.send_str(data))
        while (got := await client.connection.receive(timeout=120)).type is aiohttp.WSMsgType.BINARY:
            pass
        if isinstance(data, bytes):
            assert json.loads(got.data)["message"] == "a message is binary, expected text"
        else:
            assert (got.type, got.data) == (aiohttp.WSMsgType.CLOSE, aiohttp.WSCloseCode.MESSAGE_TOO_BIG)
        return run

    run = with_page(server.site, play)

    async def again(client: PageClient) -> None:
        await client.hello(str(run))
        assert (await client.until("state"))["step"] == 0

    with_page(server.site, again)


def test_a_thousand_keys_in_one_burst_are_answered_in_order(server: PageServer) -> None:
    """Twenty for each of the first steps: each step is taken once, and nothing that was sent early is kept."""

    async def play(client: PageClient) -> None:
        await client.hello()
        state = await client.until("state")
        sent = [(step, 1 + step % 2) for step in range(10) for _ in range(100)]
        for step, action in sent:
            await client.key(state, action, step=step)
        answers = [await client.message() for _ in sent]
        steps = [answer["step"] for answer in answers if answer["type"] == "state"]
        assert steps == [step + 1 for step, _ in sent]
        assert len(answers) == len(sent)

    with_page(server.site, play)


def test_a_persons_run_played_again_over_grpc_is_the_same_play(server: PageServer) -> None:
    actions = (R, L, F, F, P, P, F, F, P, R, R, R, F, F, P, R, F, L, F, P)

    async def play(client: PageClient) -> tuple[str, list[str]]:
        await client.hello(episodes=3)
        opened, *messages = await client.play(actions)
        return opened["run"], [message["episode"] for message in messages if message["type"] == "started"]

    async def run() -> tuple[str, list[str]]:
        async with page(server.site) as client:
            return await play(client)

    run_id, episodes = asyncio.run(run())
    with grpc.insecure_channel(server.address) as channel:
        stub = EvaluationStub(channel)
        again = create(stub, agent="replay", episode_ids=episodes, sensors=["rgb"])
        with Player(stub, again.run_id) as player:
            player.play(actions)
        reports = [stub.GetReport(pb.GetReportRequest(run_id=one), metadata=METADATA) for one in (run_id, again.run_id)]
    person, agent = reports
    assert person.run.agent == "human"
    assert {argument.name: argument.value for argument in person.run.agent_arguments} == {
        "landing_diagram": "on", "frame_strip": "off", "compass": "on",
    }  # fmt: skip
    assert "landing_diagram" in person.signature
    assert [str(episode) for episode in person.episodes] == [str(episode) for episode in agent.episodes]
    assert str(person.rows) == str(agent.rows)
    with closing(Database(f"sqlite:///{server.data / 'journal.db'}")) as database:
        journal = Journal(database)
        digests = {journal.play_digest(journal.run(one)) for one in (run_id, again.run_id)}
    assert len(digests) == 1


def test_people_need_a_token_where_agents_do(tmp_path: Path) -> None:
    server = PageServer(tmp_path, "--no-anonymous")
    token = token_of(tmp_path, "ann")

    async def play(token: str) -> dict[str, object]:
        async with page(server.site) as client:
            await client.hello(token=token)
            return await client.message()

    refused = asyncio.run(play(""))
    assert (refused["type"], refused["code"]) == ("closed", "Unauthenticated")
    opened = asyncio.run(play(token))
    assert (opened["type"], opened["participant"]) == ("opened", "ann")
    assert server.stop() == 0


def test_a_slow_reader_loses_nothing(server: PageServer) -> None:
    """Several megabytes of answers, which the page reads only later; meanwhile others play."""

    async def play() -> None:
        async with page(server.site) as slow, page(server.site) as other:
            await slow.hello(size=448)
            state = await slow.until("state")
            for _ in range(300):
                await slow.key(state, F)
            await other.hello(player="b" * 16)
            for step, action in enumerate(tiny.ACTIONS[:4]):
                seen = await other.until("state")
                assert seen["step"] == step
                await other.key(seen, action)
            answers = [await slow.until("state") for _ in range(300)]
            assert {answer["step"] for answer in answers} == {1}
            await slow.key(answers[-1], F)
            assert (await slow.until("state"))["step"] == 2

    asyncio.run(play())


def test_a_half_open_connection_is_given_up(tmp_path: Path) -> None:
    """Nothing comes through any more, in either direction: the server finds out by itself, the page comes back."""
    server = PageServer(tmp_path, "--keepalive-seconds", "1", "--streams-at-once", "1", "--anonymous")

    async def play(relay: Relay) -> None:
        async with page(f"http://{relay.address}") as frozen:
            await frozen.hello()
            run = (await frozen.until("opened"))["run"]
            await frozen.key(await frozen.until("state"), R)
            await frozen.until("state")
            relay.freeze()
            for _ in range(1000):
                async with page(server.site) as again:
                    await again.hello(run, player="c" * 16)
                    first = await again.message()
                    if first["type"] == "opened":
                        state = await again.until("state")
                        assert (state["step"], state["outcome"]) == (1, "turned")
                        break
                    assert first["code"] == "OverQuota"
                await asyncio.sleep(0.2)
            else:
                raise AssertionError("the server still counts the connection")
            relay.thaw()

    with Relay(server.site.removeprefix("http://")) as relay:
        asyncio.run(play(relay))
    assert server.stop() == 0


def test_play_through_nginx_needs_a_token(tmp_path: Path, proxies: Proxies) -> None:
    server = PageServer(tmp_path, "--trust-proxy")
    token = token_of(tmp_path, "ann")
    proxy = proxies.start([server.address], server.site.removeprefix("http://"))
    encryption = ssl.create_default_context(cafile=str(proxy.authority))

    async def play(token: str, origin: str | None = None) -> dict[str, object]:
        async with page(f"https://{proxy.address}", origin=origin, encryption=encryption) as client:
            await client.hello(token=token)
            first = await client.message()
            if first["type"] == "opened":
                await client.key(await client.until("state"), F)
                assert (await client.until("state"))["step"] == 1
            return first

    assert asyncio.run(play(""))["code"] == "Unauthenticated"
    assert asyncio.run(play(token))["participant"] == "ann"
    with pytest.raises(aiohttp.WSServerHandshakeError):
        asyncio.run(play(token, "https://example.org"))
    assert server.stop() == 0
