"""Simulated walks by rules: both turns of a small episode; the table of scores, and the comparison by episode."""

from pathlib import Path

import pytest

pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from arramon_agents.reading.reader.reader import load
from arramon_agents.simulated.courses import courses_of
from arramon_server.episodes.splits import read_named_split
from benchmarks.agents.simulated_rules import Settings, WalkedTurn, comparison, summary, walk_episode
from tests import tiny


def turn(episode: str, number: int, score: float, picked: int | None = 0) -> WalkedTurn:
    scores = {"nDTW": score, "CTC-3": float(picked == 0), "picked": float(picked == 0)}
    return WalkedTurn(episode, number, scores, [(0.0, 0.0)], picked, [])


@pytest.mark.parametrize("heading", ["own", "estimate", "true"])
def test_rules_walk_both_turns(tmp_path: Path, heading: str) -> None:
    tiny.write(tmp_path, "train", 1)
    split = read_named_split(tmp_path, "train")
    episode = split.in_playing_order("en")[0]
    courses = list(courses_of(split, [episode], ["en"], load()))
    settings = Settings(heading, reading=0, errors=0.0, seed=1)
    walked = list(walk_episode(episode.episode_id, courses, settings))
    first, second = walked
    assert (first.turn, first.picked, first.scores["CTC-3"]) == (1, 0, 1.0)
    assert first.notes[-1].startswith("INTERACT")
    assert (second.turn, second.path[0]) == (2, first.path[-1])


def test_second_turns_are_counted_after_good_first_ones() -> None:
    table = summary([turn("a", 1, 0.8), turn("a", 2, 0.6), turn("b", 1, 0.2, None), turn("b", 2, 0.0, 1)])
    rows = {line.rsplit(maxsplit=4)[0]: line.split()[-4:] for line in table.splitlines()[1:]}
    assert rows == {
        "all": ["4", "0.400", "0.500", "0.500"],
        "first turns": ["2", "0.500", "0.500", "0.500"],
        "second turns": ["2", "0.300", "0.500", "0.500"],
        "second turns after a good first": ["1", "0.600", "1.000", "1.000"],
    }


def test_comparison_is_by_episode() -> None:
    before = [turn("a", 1, 0.5), turn("a", 2, 0.5), turn("b", 1, 0.5, None)]
    after = [turn("a", 1, 0.7), turn("a", 2, 0.7), turn("b", 1, 0.5), turn("c", 1, 0.9)]
    found = comparison(after, before)
    assert found.startswith("difference: nDTW +0.100 (-0.096 to +0.296), CTC-3 +0.500 (-0.480 to +1.480)")
