"""Markdown tables of agents, from the scores of their episodes."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from arramon_server.scoring.seed_spread import seed_spread
from benchmarks.common import markdown_table

COLUMNS = ("nDTW", "CTC-0", "CTC-3", "CTC-5", "CTC-7", "rPOD@CTC-3", "PTC@CTC-3")
BY_TURN = ("nDTW", "CTC-3", "rPOD@CTC-3", "PTC@CTC-3")
ALONE = "PTC alone"
"""Placement after navigation by the ground truth."""

COMPARED_METRICS = ("nDTW", "CTC-3", ALONE)
"""Metrics in the tables of differences and of seeds."""

COMPARED_AGENTS = (
    ("vl", "vision_only"),
    ("vl", "language_only"),
    ("vision_only", "random_walk"),
    ("language_only", "random_walk"),
    ("vl", "random_walk"),
    ("vl_grounded", "vl"),
    ("vl_map", "vl_grounded"),
    ("vl_map", "seeing_follower"),
)
"""Pairs of agents whose difference is shown."""

ANY = "any"
"""Language of agents that do not read: they have one row."""

CONFIDENCE = 0.95

PAPER = {
    "val_seen": {
        "R/W": (0.045, 0.000, 0.030, 0.054, 0.092, 0.005, 0.001),
        "L/O": (0.110, 0.000, 0.044, 0.095, 0.147, 0.023, 0.017),
        "V/O": (0.055, 0.000, 0.043, 0.062, 0.087, 0.008, 0.001),
        "V/L": (0.135, 0.000, 0.098, 0.149, 0.200, 0.058, 0.044),
        "human workers": (0.671, 1.000, 1.000, 1.000, 1.000, 0.879, 0.861),
    },
    "val_unseen": {
        "R/W": (0.045, 0.000, 0.024, 0.043, 0.075, 0.005, 0.001),
        "L/O": (0.105, 0.000, 0.029, 0.068, 0.126, 0.017, 0.013),
        "V/O": (0.043, 0.000, 0.031, 0.057, 0.085, 0.007, 0.002),
        "V/L": (0.109, 0.000, 0.062, 0.108, 0.153, 0.036, 0.028),
        "human workers": (0.670, 1.000, 1.000, 1.000, 1.000, 0.869, 0.856),
    },
}
"""The paper's table 2: other data, English by people, in the original simulator."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class AgentScores:
    """The scores of one agent with one seed on one split in one language.

    Attributes:
        language: of the instructions; `ANY` for an agent that does not read them.
        turns: scores of each episode by id, those of both turns in order.
        alone: placement after navigation by the ground truth, of each episode by id, both turns' mean; empty if it was
            not played.
    """

    agent: str
    seed: int
    split: str
    language: str
    turns: Mapping[str, Sequence[Mapping[str, float]]]
    alone: Mapping[str, float]

    @classmethod
    def of_results(cls, agent: str, seed: int, split: str, language: str, results: Mapping[str, Any]) -> "AgentScores":
        """Return a run from the client's results; "alone" in them is the placement after perfect navigation."""
        turns = {each["episode_id"]: list(each["turns"].values()) for each in results["episodes"]}
        return cls(agent, seed, split, language, turns, results.get("alone", {}))

    def of(self, metric: str, turn: int | None = None) -> dict[str, float]:
        """Return a metric of each episode by id: of one turn, or both turns' mean."""
        if metric == ALONE:
            return dict(self.alone)
        chosen = slice(None) if turn is None else slice(turn - 1, turn)
        return {name: float(np.mean([each[metric] for each in turns[chosen]])) for name, turns in self.turns.items()}


@dataclass(frozen=True)
class SeedGroup:
    """The scores of all seeds of one agent on one split in one language."""

    agent: str
    language: str
    runs: Sequence[AgentScores]

    def scores(self, metric: str, turn: int | None = None) -> tuple[list[str], Floats]:
        """Return the episodes that all seeds have played, sorted, and their scores, (seeds, episodes)."""
        found = [run.of(metric, turn) for run in self.runs]
        common = sorted(set(found[0]).intersection(*found[1:]))
        return common, np.array([[each[name] for name in common] for each in found], np.float64)

    def by_episode(self, metric: str) -> dict[str, float]:
        """Return the mean over seeds of each episode by id."""
        names, scores = self.scores(metric)
        return dict(zip(names, scores.mean(0).tolist(), strict=True)) if names else {}

    def mean(self, metric: str, turn: int | None = None) -> float | None:
        """Return the mean over seeds and episodes; None where nothing was played."""
        names, scores = self.scores(metric, turn)
        return float(scores.mean()) if names else None


@dataclass(frozen=True)
class HiddenScores:
    """The aggregate scores of one agent with one seed on a hidden split in one language.

    Attributes:
        episodes: number of episodes played.
        metrics: of each turn and of both ("turn 1", "turn 2", "total"), by name: mean, low and high.
    """

    agent: str
    seed: int
    language: str
    episodes: int
    metrics: Mapping[str, Mapping[str, Mapping[str, float]]]

    def shown(self, row: str, metric: str) -> str:
        """Return a mean with its interval, formatted for the table."""
        found = self.metrics[row][metric]
        return f"{found['mean']:.3f} ({found['low']:.3f} to {found['high']:.3f})"


def groups_of(split: str, runs: Sequence[AgentScores]) -> list[SeedGroup]:
    """Return the runs on a split by agent and language, in their order."""
    found: dict[tuple[str, str], list[AgentScores]] = {}
    for run in runs:
        if run.split == split:
            found.setdefault((run.agent, run.language), []).append(run)
    return [SeedGroup(agent, language, each) for (agent, language), each in found.items()]


def section(split: str, runs: Sequence[AgentScores]) -> str:
    """Return a split's tables in Markdown; agents and languages in the order of their runs."""
    groups = groups_of(split, runs)
    return "\n\n".join(
        [
            f"## {split}",
            main_table(groups, PAPER.get(split, {})),
            "By turn:",
            turn_table(groups),
            "Differences, paired by episode:",
            difference_table(groups),
            "Seeds:",
            seed_table(groups),
        ]
    )


def hidden_section(split: str, runs: Sequence[HiddenScores]) -> str:
    """Return the tables of a hidden split in Markdown: each run's means, with the intervals that the server reports."""
    rows = [
        (f"`{run.agent}`", run.language, str(run.seed), str(run.episodes), row, *map(run.shown, [row] * 7, COLUMNS))
        for run in runs
        for row in ("turn 1", "turn 2", "total")
    ]
    return f"## {split}\n\n" + markdown_table(("agent", "language", "seed", "episodes", "", *COLUMNS), rows)


def main_table(groups: Sequence[SeedGroup], paper: Mapping[str, Sequence[float]]) -> str:
    """Return the means of all metrics, over seeds and episodes, and the paper's rows below them."""
    rows = []
    for group in groups:
        episodes = len(group.scores(COLUMNS[0])[0])
        means = [three_decimals(group.mean(metric)) for metric in (*COLUMNS, ALONE)]
        rows.append((f"`{group.agent}`", group.language, str(len(group.runs)), str(episodes), *means))
    for name, values in paper.items():
        rows.append((f"*the paper's {name}: other data*", "*en*", "", "", *map(three_decimals, values), ""))
    return markdown_table(("agent", "language", "seeds", "episodes", *COLUMNS, ALONE), rows)


def turn_table(groups: Sequence[SeedGroup]) -> str:
    """Return the means of each turn."""
    columns = [(metric, turn) for metric in BY_TURN for turn in (1, 2)]
    header = [f"{metric}, turn {turn}" for metric, turn in columns]
    rows = [
        (f"`{group.agent}`", group.language, *(three_decimals(group.mean(metric, turn)) for metric, turn in columns))
        for group in groups
    ]
    return markdown_table(("agent", "language", *header), rows)


def difference_table(groups: Sequence[SeedGroup]) -> str:
    """Return the differences of agents, each the mean of its seeds, with intervals over episodes."""
    rows = []
    for better, worse in COMPARED_AGENTS:
        for language, one, other in compared_groups(groups, better, worse):
            pairs = (paired_scores(one, other, metric) for metric in COMPARED_METRICS)
            shown = [shown_difference(*pair) if len(pair[0]) > 1 else "" for pair in pairs]
            rows.append((f"`{better}` - `{worse}`", language, *shown))
    return markdown_table(("difference", "language", *COMPARED_METRICS), rows)


def compared_groups(groups: Sequence[SeedGroup], better: str, worse: str) -> Iterator[tuple[str, SeedGroup, SeedGroup]]:
    """Yield each language in which both agents have played, with their scores; `ANY` if neither reads."""
    by_key = {(group.agent, group.language): group for group in groups}
    neither_reads = (better, ANY) in by_key and (worse, ANY) in by_key
    for language in dict.fromkeys(group.language for group in groups):
        if neither_reads != (language == ANY):
            continue
        one, other = (by_key.get((agent, language)) or by_key.get((agent, ANY)) for agent in (better, worse))
        if one and other:
            yield language, one, other


def seed_table(groups: Sequence[SeedGroup]) -> str:
    """Return the variation between the means of seeds, and between episodes."""
    rows = []
    for group in groups:
        for metric in COMPARED_METRICS:
            names, scores = group.scores(metric)
            if len(group.runs) > 1 and len(names) > 1:
                spread = seed_spread(scores)
                deviations = (spread.deviation, spread.episodes_deviation, spread.rest_deviation)
                each = ", ".join(three_decimals(float(value)) for value in scores.mean(1))
                rows.append((f"`{group.agent}`", group.language, metric, each, *map(three_decimals, deviations)))
    header = ("agent", "language", "metric", "mean of each seed", "between seeds", "between episodes", "rest")
    return markdown_table(header, rows)


def paired_difference(better: Floats, worse: Floats, confidence: float = CONFIDENCE) -> tuple[float, float, float]:
    """Return the mean difference of paired scores, (episodes,), and Student's interval for it."""
    return mean_interval(better - worse, confidence)


def mean_interval(scores: Floats, confidence: float = CONFIDENCE) -> tuple[float, float, float]:
    """Return the mean of scores, (episodes,), and Student's interval for it."""
    count, mean = len(scores), float(scores.mean())
    half = float(stdtrit(count - 1, 0.5 + confidence / 2.0) * scores.std(ddof=1) / count**0.5)
    return mean, mean - half, mean + half


def shown_difference(one: Floats, other: Floats) -> str:
    """Return a mean difference with its interval, paired by episode; bold if the interval excludes 0."""
    mean, low, high = paired_difference(one, other)
    shown = f"{mean:+.3f} ({low:+.3f} to {high:+.3f})"
    return f"**{shown}**" if low > 0 or high < 0 else shown


def paired_scores(better: SeedGroup, worse: SeedGroup, metric: str) -> tuple[Floats, Floats]:
    """Return the scores of the episodes that both agents have played, each the mean of its seeds, (episodes,) each."""
    first, second = better.by_episode(metric), worse.by_episode(metric)
    common = sorted(first.keys() & second.keys())
    return np.array([first[name] for name in common]), np.array([second[name] for name in common])


def three_decimals(value: float | None) -> str:
    """Return a number with three decimals; empty if it was not measured."""
    return "" if value is None else f"{value:.3f}"
