"""Facts of a route on a writer's sheet: legs and bends of the path, and landmarks that the camera shows."""

import math

import pytest

from arramon_dataset.generation.site import GenerationSite
from arramon_dataset.paraphrases.route_facts import route_facts
from arramon_server.episodes.episode import Episode


@pytest.mark.parametrize(
    ("turn", "legs"), [(1, [(175, 14)]), (2, [(-90, 5), (90, 3), (-90, 20)])], ids=["turn 1", "turn 2"]
)
def test_legs_follow_the_path(site: GenerationSite, episode: Episode, turn: int, legs: list[tuple[int, int]]) -> None:
    facts = route_facts(episode, turn, site)
    assert [(round(leg.turn), round(leg.length)) for leg in facts.legs] == legs
    path = episode.turns[turn - 1].path
    walked = sum(math.dist(path[n], path[n + 1]) for n in range(len(path) - 1))
    assert sum(leg.length for leg in facts.legs) == pytest.approx(walked, rel=0.1)


def test_what_a_leg_goes_by_has_side_and_order(site: GenerationSite, episode: Episode) -> None:
    (leg,) = route_facts(episode, 1, site).legs
    assert "tyre stack (at 10, 3 to the left)" in map(str, leg.passed)
    assert "mailbox (at 6, on the way)" in map(str, leg.passed)
    assert [one.along for one in leg.passed] == sorted(one.along for one in leg.passed)
    assert leg.ahead[0].startswith("yellow barrel")


def test_what_surrounds_the_target_is_told_as_one_arrives(site: GenerationSite, episode: Episode) -> None:
    around = route_facts(episode, 1, site).around
    assert around[0] == "dotted red bowl: 0.7 in front of it and 1.2 to its left"
    assert "dotted red bowl" in route_facts(episode, 1, site).others
    assert str(episode.turns[0].target.type) not in route_facts(episode, 1, site).others
