"""Tables of agents from known scores: means, turns, paired differences, and variation of seeds and episodes."""

from typing import Any

import numpy as np
import pytest

from benchmarks.agents import results_tables as tables


def results(scores: dict[str, tuple[float, float]], alone: dict[str, float]) -> dict[str, Any]:
    """Results of a client: each metric of both turns is the same number."""
    names = {*tables.COLUMNS, *tables.BY_TURN}
    episodes = [
        {"episode_id": episode_id, "turns": {str(turn + 1): dict.fromkeys(names, both[turn]) for turn in (0, 1)}}
        for episode_id, both in scores.items()
    ]
    return {"episodes": episodes, "alone": alone}


def run(agent: str, seed: int, first: float, language: str = "en") -> Any:
    scores = {"a": (first, 0.0), "b": (0.5, 0.25), "c": (0.0, 0.5)}
    alone = {"a": 0.5, "b": first, "c": 0.0}
    return tables.AgentScores.of_results(agent, seed, "val_seen", language, results(scores, alone))


def cells(table: str) -> list[list[str]]:
    """Rows of a table in Markdown without its header."""
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]


def test_means_are_over_seeds_and_episodes_and_the_papers_rows_follow() -> None:
    runs = [run("vl", 1, 1.0), run("vl", 2, 0.0)]
    table = tables.main_table([tables.SeedGroup("vl", "en", runs)], {"R/W": (0.1,) * 7})
    first, second = cells(table)
    # Episodes have (0.5, 0.375, 0.25) with the first seed, (0, 0.375, 0.25) with the second.
    assert first == ["`vl`", "en", "2", "3", *["0.292"] * 7, "0.333"]
    assert second == ["*the paper's R/W: other data*", "*en*", "", "", *["0.100"] * 7, ""]


def test_turns_stand_apart() -> None:
    (row,) = cells(tables.turn_table([tables.SeedGroup("vl", "en", [run("vl", 1, 1.0)])]))
    assert row == ["`vl`", "en", *["0.500", "0.250"] * 4]


@pytest.mark.parametrize(
    ("better", "worse", "expected"),
    [
        # Student's quantile for two degrees of freedom is 4.303.
        ([0.3, 0.4, 0.5], [0.1, 0.2, 0.3], (0.2, 0.2, 0.2)),
        ([0.1, 0.2, 0.6], [0.1, 0.1, 0.1], (0.2, 0.2 - 4.3027 * 0.26458 / 3**0.5, 0.2 + 4.3027 * 0.26458 / 3**0.5)),
    ],
)
def test_paired_differences(better: list[float], worse: list[float], expected: tuple[float, float, float]) -> None:
    assert tables.paired_difference(np.array(better), np.array(worse)) == pytest.approx(expected, abs=1e-4)


def test_differences_are_over_the_episodes_that_both_played() -> None:
    high = {"a": (0.9, 0.9), "b": (0.8, 0.8), "x": (0.0, 0.0)}
    low = {"b": (0.1, 0.1), "a": (0.2, 0.2), "y": (1.0, 1.0)}
    groups = [
        tables.SeedGroup(agent, "en", [tables.AgentScores.of_results(agent, 0, "s", "en", results(scores, {}))])
        for agent, scores in (("vl", high), ("vision_only", low))
    ]
    assert cells(tables.difference_table(groups)) == [
        ["`vl` - `vision_only`", "en", *["**+0.700 (+0.700 to +0.700)**"] * 2, ""]
    ]


def test_agents_that_do_not_read_have_one_row_and_are_compared_in_each_language_of_the_others() -> None:
    blind = [tables.SeedGroup(agent, tables.ANY, [run(agent, 1, 0.4)]) for agent in ("random_walk", "vision_only")]
    reading = [tables.SeedGroup("vl", language, [run("vl", 1, 0.4, language)]) for language in ("en", "hi")]
    assert [row[:2] for row in cells(tables.difference_table([*blind, *reading]))] == [
        ["`vl` - `vision_only`", "en"],
        ["`vl` - `vision_only`", "hi"],
        ["`vision_only` - `random_walk`", "any"],
        ["`vl` - `random_walk`", "en"],
        ["`vl` - `random_walk`", "hi"],
    ]


def test_only_differences_whose_interval_does_not_hold_0_are_bold() -> None:
    scores = {"a": (0.9, 0.9), "b": (0.1, 0.1)}
    below = {"a": (0.1, 0.1), "b": (0.8, 0.8)}
    groups = [
        tables.SeedGroup(agent, "hi", [tables.AgentScores.of_results(agent, 0, "s", "hi", results(each, {}))])
        for agent, each in (("vl", scores), ("random_walk", below))
    ]
    ((_, _, shown, *_),) = cells(tables.difference_table(groups))
    assert shown == "+0.050 (-9.480 to +9.580)"
    few, many = np.array([0.1, 0.2, 0.3]), np.array([0.6, 0.7, 0.9])
    assert tables.shown_difference(few, many) == "**-0.533 (-0.677 to -0.390)**"


def test_seeds_are_told_apart_from_episodes() -> None:
    """Seeds that differ by the same in every episode leave no rest."""
    shifted = [
        tables.AgentScores.of_results(
            "vl", seed, "s", "en", results({"a": (up, up), "b": (0.5 + up, 0.5 + up)}, {"a": up, "b": up})
        )
        for seed, up in ((1, 0.0), (2, 0.1), (3, 0.2))
    ]
    fixed = tables.AgentScores.of_results("random_walk", 0, "s", "en", results({"a": (0, 0), "b": (1, 1)}, {}))
    groups = [tables.SeedGroup("random_walk", "en", [fixed]), tables.SeedGroup("vl", "en", shifted)]
    rows = cells(tables.seed_table(groups))
    assert rows[0] == ["`vl`", "en", "nDTW", "0.250, 0.350, 0.450", "0.100", "0.354", "0.000"]
    assert [row[2] for row in rows] == list(tables.COMPARED_METRICS)
    assert rows[2][3:] == ["0.000, 0.100, 0.200", "0.100", "0.000", "0.000"]


def test_a_split_has_all_tables_of_its_own_runs() -> None:
    runs = [run(agent, 1, 0.4, language) for agent in ("random_walk", "vl") for language in ("en", "hi")]
    page = tables.section("val_seen", runs)
    assert page.startswith("## val_seen\n\n| agent | language |")
    assert page.count("\n| `vl` | hi | ") == 2
    assert "`vl` - `random_walk` | hi |" in page
    assert "`vl`" not in tables.section("val_unseen", runs)


def test_of_a_hidden_split_means_and_intervals_are_shown() -> None:
    metrics = {
        row: {metric: {"mean": mean, "low": mean - 0.1, "high": mean + 0.1} for metric in tables.COLUMNS}
        for row, mean in (("turn 1", 0.5), ("turn 2", 0.3), ("total", 0.4))
    }
    page = tables.hidden_section("test_unseen", [tables.HiddenScores("vl_map", 1, "hi", 72, metrics)])
    assert page.startswith("## test_unseen\n\n| agent | language | seed | episodes |")
    rows = cells(page.split("\n\n")[1])
    assert rows[2] == ["`vl_map`", "hi", "1", "72", "total", *["0.400 (0.300 to 0.500)"] * 7]
