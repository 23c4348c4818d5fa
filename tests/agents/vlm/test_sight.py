"""The sight check, by the route on which the model will play."""

import asyncio
import random

import numpy as np
import pytest

from arramon_agents.vlm import sight
from arramon_agents.vlm.replies import Reply
from arramon_client.agent import Episode
from arramon_client.errors import StopRun
from benchmarks.agents.fake_endpoint import FakeEndpoint, Request, Response, completion, image_of
from tests.agents.vlm import helpers
from tests.agents.vlm.conftest import MakeAgent

BLIND = '{"shape": "circle", "colour": "red", "word": "HELLO"}'


def blind(request: Request, number: int) -> Response:
    """A route without frames: the model guesses."""
    return completion(request, None, tools=[("name", BLIND)]) if "tools" in request else completion(request, BLIND)


@pytest.mark.parametrize("answers", ["schema", "object", "plain", "tools"])
@pytest.mark.parametrize(("size", "image_format"), [(0, "png"), (128, "jpeg")])
def test_a_model_that_sees(answers: str, size: int, image_format: str, made: MakeAgent, fake: FakeEndpoint) -> None:
    agent = made(answers=answers, image_size=size, image_format=image_format, sight="check", detail="low")

    async def play() -> None:
        for _ in range(2):
            async with helpers.playing(agent):
                pass

    asyncio.run(play())
    (request,) = fake.requests  # It was paid for, and is not repeated.
    content = request["messages"][-1]["content"]
    assert content[1]["image_url"]["url"].startswith(f"data:image/{image_format};base64,")
    assert content[1]["image_url"]["detail"] == "low"
    assert image_of(request["messages"][-1]).shape == (size or 224, size or 224, 3)
    assert agent.run_report()["sight"] == "passed"


def test_a_blind_route_is_refused(made: MakeAgent, fake: FakeEndpoint) -> None:
    fake.behaviour = blind

    async def play() -> None:
        async with helpers.playing(made(sight="check")):
            pass

    with pytest.raises(StopRun, match="does not see: it named none of 2 cards rightly"):
        asyncio.run(play())
    assert len(fake.requests) == 2


@pytest.mark.parametrize(("setting", "result", "requests"), [("mark", "blind", 2), ("skip", "skipped", 0)])
def test_a_blind_route_is_marked(setting: str, result: str, requests: int, made: MakeAgent, fake: FakeEndpoint) -> None:
    """In the results and in the notes; and the setting itself is in the signature."""
    fake.behaviour = lambda request, number: (blind if number < requests else helpers.always("left"))(request, number)
    agent = made(sight=setting)

    async def play() -> str:
        async with helpers.playing(agent):
            note = await helpers.note_of(agent, helpers.seen(0))
            return str(note["sight"])

    assert asyncio.run(play()) == result
    assert agent.run_report()["sight"] == result
    assert agent.recorded_arguments["sight"] == setting
    assert len(fake.requests) == requests + 1


@pytest.mark.parametrize(
    ("text", "is_right"),
    [
        ('{"shape": "star", "colour": "red", "word": "APPLE"}', True),
        ('{"shape": " Star", "colour": "RED", "word": "apple"}', True),
        ('{"shape": "star", "colour": "red", "word": "APPLES"}', False),
        ('{"shape": "circle", "colour": "red", "word": "APPLE"}', False),
        ('{"shape": "star", "colour": "red"}', False),
        ("a red star, APPLE", False),
    ],
)
def test_answers(text: str, is_right: bool) -> None:
    assert sight.Card("star", "red", "APPLE").is_named_by(Reply(text), None) is is_right


def test_no_two_cards_look_alike() -> None:
    cards = [sight.Card(shape, colour, "APPLE") for shape in sight.SHAPES for colour in sight.COLOURS]
    cards += [sight.Card("star", "red", word) for word in sight.WORDS[1:]]
    pictures = [sight.picture(card).astype(int) for card in cards]
    apart = [np.abs(one - other).mean() for number, one in enumerate(pictures) for other in pictures[:number]]
    assert min(apart) > 0.5
    assert all(picture.shape == (sight.SIZE, sight.SIZE, 3) for picture in pictures)
    assert len({sight.draw_card(random.Random(seed)) for seed in range(50)}) > 25


def test_a_card_is_asked_for_in_the_language_of_the_run(made: MakeAgent, fake: FakeEndpoint) -> None:
    agent = made(sight="check")

    async def play() -> None:
        async with helpers.playing(agent, episode=Episode("e", "hi", "tiny")):
            pass

    asyncio.run(play())
    assert "चित्र एक कार्ड है" in str(fake.requests[0]["messages"][-1]["content"])
