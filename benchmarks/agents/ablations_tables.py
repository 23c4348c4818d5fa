"""Markdown tables of ablations, from the scores of each variation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.agents.results_tables import shown_difference, three_decimals
from benchmarks.agents.study import LANGUAGES, METRICS, SPLITS, Scores
from benchmarks.common import markdown_table

BASE = "base"
"""The variation with which the others are compared."""

SHOWN = {metric: f"{metric} alone" if phase == "assembly" else metric for phase in METRICS for metric in METRICS[phase]}
"""Names of the metrics in the tables: placement is played after perfect navigation."""


@dataclass(frozen=True)
class PhaseScores:
    """The scores of a variation in one phase with one seed.

    Attributes:
        scores: by language of play and "split/episode", the phase's metrics.
        updates: number of gradient updates in the common training time; 0 without training.
    """

    name: str
    phase: str
    seed: int
    scores: Scores
    updates: int

    def of(self, metric: str, split: str, language: str) -> dict[str, float]:
        """Return a metric of each episode of a split, played in a language."""
        return {name: each[metric] for name, each in self.scores[language].items() if name.startswith(f"{split}/")}


def tables(
    trained: Sequence[PhaseScores], played: Sequence[PhaseScores], rows: Mapping[str, str], map_rows: Mapping[str, str]
) -> str:
    """Return all tables of `vl` and of `vl_map`.

    Args:
        trained: variations of `vl`.
        played: variations of `vl_map`.
        rows, map_rows: description of each variation.
    """
    parts = []
    for title, measured, names in (
        ("`vl`, all trained for the same CPU time", trained, rows),
        ("`vl_map`, with something left out at play", played, map_rows),
    ):
        for split in SPLITS if measured else ():
            parts += [f"## {split}: {title}", table(measured, split, names)]
    if trained:
        parts += ["## Updates in that time", updates_table(trained, rows)]
    return "\n\n".join(parts)


def table(measured: Sequence[PhaseScores], split: str, rows: Mapping[str, str]) -> str:
    """Return each variation's means over seeds and episodes, and its differences to the base, paired by episode."""
    lines = []
    for name, what in rows.items():
        for language in LANGUAGES if any(each.name == name for each in measured) else ():
            line = [f"`{name}`", what, language]
            for phase, metrics in METRICS.items():
                for metric in metrics:
                    own, base = (
                        metric_by_episode(measured, each, phase, metric, split, language) for each in (name, BASE)
                    )
                    line.append(three_decimals(float(np.mean(list(own.values()))) if own else None))
                    common = sorted(own.keys() & base.keys())
                    is_other = name != BASE and len(common) > 1
                    pair = [np.array([each[episode] for episode in common]) for each in (own, base)]
                    line.append(shown_difference(*pair) if is_other else "")
            lines.append(line)
    columns = [cell for shown in SHOWN.values() for cell in (shown, f"minus `{BASE}`")]
    return markdown_table(["", "", "language", *columns], lines)


def updates_table(measured: Sequence[PhaseScores], rows: Mapping[str, str]) -> str:
    """Return each variation's number of gradient updates, the mean over seeds."""
    lines = []
    for name in rows:
        found = [[each.updates for each in measured if (each.name, each.phase) == (name, phase)] for phase in METRICS]
        if any(found):
            lines.append([f"`{name}`", *(str(round(sum(each) / len(each))) if each else "" for each in found)])
    return markdown_table(["", *METRICS], lines)


def metric_by_episode(
    measured: Sequence[PhaseScores], name: str, phase: str, metric: str, split: str, language: str
) -> dict[str, float]:
    """Return a metric of each episode, the mean over seeds; empty if nothing was played."""
    seeds = [each.of(metric, split, language) for each in measured if (each.name, each.phase) == (name, phase)]
    return {episode: float(np.mean([each[episode] for each in seeds])) for episode in (seeds[0] if seeds else ())}
