"""Plans, the window of exchanges, what went wrong, and the way back from trace and notes."""

import asyncio
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arramon_client.agent import Action, Answer, Episode, Label, Observation
from benchmarks.agents.fake_endpoint import FakeEndpoint, Request, Response, completion, plan, text_of
from tests.agents.vlm import helpers
from tests.agents.vlm.conftest import MakeAgent

F, L, R, P = Action


def questions(fake: FakeEndpoint) -> list[str]:
    return [text_of(request["messages"][-1]) for request in fake.requests]


def play(agent: Any, *observations: Observation, run_id: str = "r") -> list[int]:
    async def played() -> list[int]:
        async with helpers.playing(agent, run_id):
            return [await helpers.action_of(agent, each) for each in observations]

    return asyncio.run(played())


def test_a_plan_is_carried_out_without_further_calls(made: MakeAgent, fake: FakeEndpoint) -> None:
    fake.behaviour = helpers.in_turn(helpers.always("forward", "left", "forward"), helpers.always("interact"))
    assert play(made(), *(helpers.seen(step) for step in range(4))) == [F, L, F, P]
    assert questions(fake)[1].splitlines() == [
        "Done since your last answer: forward, left, forward.",
        "Step 3 of this phase; 147 steps are left.",
        "What you see now:",
    ]


def test_a_plan_longer_than_asked_for_is_cut(made: MakeAgent, fake: FakeEndpoint) -> None:
    fake.behaviour = helpers.always("forward", "left", "forward")
    assert play(made(plan=2), *(helpers.seen(step) for step in range(4))) == [F, L, F, L]
    assert len(fake.requests) == 2


@pytest.mark.parametrize(
    "second",
    [
        {"look": 0},  # no pose: the frame has not changed
        {"look": 1, "pose": (0.0, 0.0, 0.0)},  # with a pose it alone counts
    ],
)
def test_a_blocked_move_drops_the_rest(second: dict[str, Any], made: MakeAgent, fake: FakeEndpoint) -> None:
    fake.behaviour = helpers.in_turn(helpers.always("forward", "left", "left"), helpers.always("right"))
    first: dict[str, Any] = {"pose": (0.0, 0.0, 0.0)} if "pose" in second else {}
    assert play(made(), helpers.seen(0, **first), helpers.seen(1, **second)) == [F, R]
    assert questions(fake)[1].splitlines()[:3] == [
        "Done since your last answer: forward.",
        "The last forward had no effect: something is in the way.",
        "Dropped from your plan: left, left.",
    ]


def test_a_turn_that_changes_nothing_in_view_is_not_blocked(made: MakeAgent, fake: FakeEndpoint) -> None:
    fake.behaviour = helpers.always("left", "left")
    assert play(made(), helpers.seen(0), helpers.seen(1, look=0)) == [L, L]
    assert len(fake.requests) == 1


def test_an_interaction_without_effect_is_reported(made: MakeAgent, fake: FakeEndpoint) -> None:
    fake.behaviour = helpers.in_turn(helpers.always("interact", "forward"), helpers.always("right"))
    assert play(made(), helpers.seen(0), helpers.seen(1)) == [P, R]
    assert "The last interact had no effect" in questions(fake)[1]


def test_the_next_phase_begins_without_plan_and_exchanges(made: MakeAgent, fake: FakeEndpoint) -> None:
    fake.behaviour = helpers.in_turn(helpers.always("interact", "forward"), helpers.always("left"))
    room = helpers.seen(1, phase="assembly", phase_step=0, instruction="Put it down.")
    assert play(made(), helpers.seen(0), room) == [P, L]
    system, question = fake.requests[1]["messages"]
    assert text_of(system).endswith("Turn 1 of 2, in the room. You carry the object. The instruction:\nPut it down.")
    assert text_of(question).startswith("Step 0 of this phase")


@pytest.mark.parametrize(("window", "messages"), [(0, 2), (1, 4), (2, 6), (9, 8)])
def test_the_window_of_exchanges(window: int, messages: int, made: MakeAgent, fake: FakeEndpoint) -> None:
    play(made(window=window), *(helpers.seen(step) for step in range(4)))
    sent = fake.requests[3]["messages"]
    assert len(sent) == messages
    frames = [part for each in sent if isinstance(each["content"], list) for part in each["content"]]
    assert sum(part["type"] == "image_url" for part in frames) == messages // 2
    if window:
        assert sent[-2] == {"role": "assistant", "content": '{"thought": "I go on.", "actions": ["forward"]}'}


def test_the_window_with_tools(made: MakeAgent, fake: FakeEndpoint) -> None:
    play(made(answers="tools"), helpers.seen(0), helpers.seen(1))
    _, _, called, answered, _ = fake.requests[1]["messages"]
    assert called["tool_calls"][0]["function"]["name"] == "act"
    assert answered["tool_call_id"] == called["tool_calls"][0]["id"]


def prose(request: Request, number: int) -> Response:
    return completion(request, "I would go forward.")


def test_an_unusable_reply_is_asked_for_once_more(made: MakeAgent, fake: FakeEndpoint) -> None:
    fake.behaviour = helpers.in_turn(prose, helpers.always("left"))
    agent = made()
    assert play(agent, helpers.seen(0)) == [L]
    assert fake.requests[1]["messages"][-2:] == [
        {"role": "assistant", "content": "I would go forward."},
        {"role": "user", "content": "This answer cannot be used: it is not one JSON object and nothing else. "
                                    "Answer again, exactly in the form asked for."},
    ]  # fmt: skip
    assert agent.run_report()["noops"] == {}


def test_two_unusable_replies_are_a_counted_harmless_action(made: MakeAgent, fake: FakeEndpoint) -> None:
    fake.behaviour = helpers.in_turn(prose, prose, helpers.always("left"))
    agent = made()
    assert play(agent, helpers.seen(0), helpers.seen(1)) == [R, L]
    assert agent.run_report()["noops"] == {"json": 1}
    assert questions(fake)[2].startswith("Your last answers could not be used, so you turned right.")
    assert len(fake.requests[2]["messages"]) == 2  # what cannot be used is not kept in the window


def test_a_no_op_is_counted_once_though_the_client_was_killed_before_its_step_was_recorded(
    made: MakeAgent, fake: FakeEndpoint
) -> None:
    fake.behaviour = helpers.in_turn(prose, prose, helpers.always("left"))
    for _ in range(2):
        agent = made()
        assert play(agent, helpers.seen(0)) == [R]
        assert agent.run_report()["noops"] == {"json": 1}
    assert len(fake.requests) == 2


def test_notes(made: MakeAgent, fake: FakeEndpoint, tmp_path: Path) -> None:
    """The first step of a plan has one; the longest words are cut to what a note may hold."""
    prices = tmp_path / "prices.toml"
    prices.write_text("[models.m]\ninput = 1000\noutput = 1000\n")
    long = "मैं मग की ओर जाता हूँ। " * 100
    fake.behaviour = helpers.in_turn(lambda request, _: plan(request, ["forward", "left"], long), prose, prose)

    async def played() -> tuple[dict[str, Any], Any, dict[str, Any]]:
        async with helpers.playing(made(prices=str(prices))) as agent:
            first = await helpers.note_of(agent, helpers.seen(0))
            return first, await agent.act(helpers.seen(1)), await helpers.note_of(agent, helpers.seen(2))

    first, second, third = asyncio.run(played())
    assert second == L
    assert len(json.dumps(first, ensure_ascii=False, separators=(",", ":")).encode()) <= 2048
    assert first["thought"].startswith("मैं मग की ओर")
    assert first["plan"] == ["forward", "left"]
    assert first["usd"] == pytest.approx(sum(first["tokens"]) / 1000)
    assert first["sight"] == "skipped"
    assert third["noop"] == "json"
    assert third["calls"] == 2


SCRIPT = [
    helpers.always("forward", "left"), helpers.always("forward"), prose, prose, helpers.always("right", "interact"),
]  # fmt: skip
SEEN = [helpers.seen(0), helpers.seen(1), helpers.seen(2), helpers.seen(3, look=2), helpers.seen(4), helpers.seen(5)]


async def _live(agent: Any, run_id: str) -> list[tuple[int, Any]]:
    async with helpers.playing(agent, run_id):
        answers = [await agent.act(each) for each in SEEN]
    return [(int(a.action), a.note) if isinstance(a, Answer) else (int(a), None) for a in answers]


@pytest.mark.parametrize("kept", range(len(SEEN) + 1))
@pytest.mark.parametrize("source", ["trace", "notes"])
def test_replay_restores_the_history_without_calls(
    kept: int, source: str, made: MakeAgent, fake: FakeEndpoint, tmp_path: Path
) -> None:
    """With the trace nothing is asked again; with the notes alone only what no step was recorded for."""
    fake.behaviour = helpers.in_turn(*SCRIPT)
    live = asyncio.run(_live(made(), "r"))
    assert [action for action, _ in live] == [F, L, F, R, R, P]
    whole = list(fake.requests)
    trace = tmp_path / "r.vlm.jsonl"
    if source == "notes":
        trace.unlink()
        fake.behaviour = lambda request, _: SCRIPT[whole.index(request)](request, 0)

    async def resumed() -> list[int]:
        agent = made()
        async with helpers.playing(agent, "r"):
            for each, (action, note) in zip(SEEN[:kept], live[:kept], strict=True):
                text = None if note is None else json.dumps(note, ensure_ascii=False)
                agent.replay(replace(each, taken=action, taken_note=text), action)
            return [await helpers.action_of(agent, each) for each in SEEN[kept:]]

    assert asyncio.run(resumed()) == [action for action, _ in live[kept:]]
    again = fake.requests[len(whole) :]
    calls_by_then = (0, 1, 1, 2, 4, 5, 5)
    expected = 0 if source == "trace" else len(whole) - calls_by_then[kept]
    assert len(again) == expected
    assert again == whole[len(whole) - expected :]  # the very same questions, in the same words


def test_another_clients_steps_are_replayed_as_they_were(made: MakeAgent, fake: FakeEndpoint) -> None:
    fake.behaviour = helpers.always("forward")
    agent = made()

    async def played() -> int:
        async with helpers.playing(agent):
            agent.replay(helpers.seen(0, taken=1, taken_note="not ours"), 1)
            return await helpers.action_of(agent, helpers.seen(1))

    assert asyncio.run(played()) == F
    assert questions(fake)[0].startswith("Done since your last answer: left.")


def test_words_in_place_of_frames(made: MakeAgent, fake: FakeEndpoint) -> None:
    agent = made(images=False)
    assert agent.sensors == ("depth", "segmentation")
    segmentation, depth = np.zeros((224, 224), np.uint16), np.full((224, 224), 9.0, np.float32)
    segmentation[100:140, 150:190], depth[100:140, 150:190] = 1, 3.0
    labels = (Label("nothing"), Label("mug", "red", "striped"))
    episode = Episode("e", "hi", "tiny", labels=labels)

    async def played() -> None:
        async with helpers.playing(agent, episode=episode):
            await agent.act(helpers.seen(0, segmentation=segmentation, depth=depth))

    asyncio.run(played())
    (request,) = fake.requests
    assert isinstance(request["messages"][-1]["content"], str)
    assert questions(fake)[0].splitlines()[1:] == [
        "सामने ख़ाली: 20 अंश बाएँ 9.6 इकाई, ठीक सामने 9.0 इकाई, 20 अंश दाएँ 3.2 इकाई।",
        "क्या कहाँ है, सबसे पास वाला पहले:",
        "- धारीदार लाल मग, 3.0 इकाई दूर, 17 अंश दाएँ",
    ]
    assert agent.run_report()["sight"] == "none"
