"""Groups of turns by what they ask for, and those that a hidden split shows."""

import numpy as np

from arramon_server.runs.results.turn_groups import ASPECTS, TurnGroup, TurnGrouping, group_turns
from arramon_server.scoring.disclosure import MIN_EPISODES
from tests import demanding
from tests.scoring.test_disclosure import max_leverage


def of(found: TurnGrouping, aspect: str) -> list[TurnGroup]:
    return [group for group in found.groups if group.aspect == aspect]


def test_every_turn_is_in_one_range_of_each_number() -> None:
    found = group_turns(demanding.split("open", 90), "en", None)
    for aspect in ("length", "corners", "steps", "landmarks"):
        groups = of(found, aspect)
        assert len(groups) == 3
        assert np.array_equal(np.sum([group.turns for group in groups], axis=0), np.ones((90, 2)))
        assert [group.low for group in groups[1:]] == [(group.high or 0) + 1 for group in groups[:-1]]
        assert groups[-1].high is None
    assert all(group.high is None or group.high % 5 == 0 for group in of(found, "length"))


def test_groups_hold_what_they_say() -> None:
    split = demanding.split("open", 90)
    found = group_turns(split, "en", None)
    assert {group.aspect for group in found.groups} == set(ASPECTS) - {"object"}
    for row, name in enumerate(found.ids):
        episode = split.episodes[name]
        for number, (turn, asked) in enumerate(zip(episode.turns, split.demands[name], strict=True)):
            here = {(g.aspect, g.name) for g in found.groups if g.name and g.turns[row, number]}
            expected = {("turn", ("first", "second")[number])}
            expected |= {("step", kind) for kind in asked.steps} | {("landmark", kind) for kind in asked.landmarks}
            expected |= {("relation", kind) for kind in asked.relations}
            expected |= {("placement", kind) for kind in asked.placements}
            assert here == expected
            (length,) = (g for g in of(found, "length") if g.turns[row, number])
            assert length.low <= len(turn.path) - 1 <= (length.high or 99)
            (corners,) = (g for g in of(found, "corners") if g.turns[row, number])
            assert corners.low <= sum(action == 1 for action in turn.actions) // 2 <= (corners.high or 99)


def test_objects_are_told_apart_where_the_training_data_is_there() -> None:
    split, train = demanding.split("open", 60), demanding.split("train", 30, seed=1)
    seen, unseen = of(group_turns(split, "en", train), "object")
    known = {turn.target.type for episode in train.episodes.values() for turn in episode.turns}
    assert (seen.name, unseen.name) == ("seen", "unseen")
    assert np.array_equal(seen.turns, ~unseen.turns)
    for row, name in enumerate(sorted(split.episodes)):
        assert [turn.target.type in known for turn in split.episodes[name].turns] == seen.turns[row].tolist()
    assert of(group_turns(train, "en", train), "object") == []


def test_split_without_demands_has_the_groups_of_the_ground_truth() -> None:
    split = demanding.split("open", 6)
    plain = group_turns(type(split)("s", False, "tests", split.episodes, split.sections, "0"), "en", None)
    assert not plain.knows_demands
    assert {group.aspect for group in plain.groups} == {"turn", "length", "corners"}


def test_hidden_split_shows_groups_that_tell_of_no_episode() -> None:
    """A large one most of them; of few episodes hardly any."""
    shares = {}
    for count in (10, 60, 1205):
        whole = group_turns(demanding.split("open", count), "en", None)
        found = group_turns(demanding.split("secret", count, hidden=True), "en", None)
        assert len(found.groups) + found.withheld == len(whole.groups)
        for group in found.groups:
            assert group.turns.any(axis=1).sum() >= MIN_EPISODES
        if found.groups:
            assert max_leverage([group.turns for group in found.groups]) <= 1.0 / MIN_EPISODES + 1e-9
        shares[count] = len(found.groups) / len(whole.groups)
    assert shares[10] == 0.0
    assert shares[60] < 0.3
    assert shares[1205] > 0.7
