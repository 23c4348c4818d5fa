"""Template variables of the page with the episodes in which two runs differ most."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import quote, urlencode

from arramon_server.errors import NotFound, quoted
from arramon_server.runs.storage.records import EpisodeEnding, Run
from arramon_server.visible_text import shown
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.standings_query import METRICS
from arramon_server.web.watch.watched_runs import WatchedRun

SHOWN_EPISODES = 100
"""Maximum number of episodes in the table."""

SORTED_BY = "ndtw"
"""Metric by which episodes are compared unless the address names another."""


@dataclass(frozen=True, slots=True)
class EpisodeDifference:
    """An episode that two runs have ended.

    Attributes:
        episode_id: id of the episode.
        first, second: mean score over both turns in each run, in [0, 1].
    """

    episode_id: str
    first: float
    second: float

    @property
    def difference(self) -> float:
        """Score of the second run minus that of the first."""
        return self.second - self.first


def episode_differences(
    first: Sequence[EpisodeEnding], second: Sequence[EpisodeEnding], metric: str, without: Collection[str] = ()
) -> list[EpisodeDifference]:
    """Return the episodes that both runs have ended, those with the largest difference first.

    Args:
        first, second: endings of each run's episodes.
        metric: one of `episode_scores.METRICS`. Episodes with the same difference are sorted by that in nDTW.
        without: ids of episodes that are left out.
    """
    other = {ending.episode_id: ending for ending in second}
    both = [
        (ending, other[ending.episode_id])
        for ending in first
        if ending.episode_id in other and ending.episode_id not in without
    ]
    both.sort(key=lambda pair: (-_gap(pair, metric), -_gap(pair, "nDTW"), pair[0].episode_id))
    return [EpisodeDifference(one.episode_id, _mean(one, metric), _mean(two, metric)) for one, two in both]


def read_metric(query: Mapping[str, str]) -> str:
    """Return the name in addresses of the metric in a query.

    Raises:
        NotFound: if there is no such metric.
    """
    name = query.get("sort", SORTED_BY)
    if name not in METRICS:
        raise NotFound(f"there is no metric {quoted(name)}; expected one of {', '.join(METRICS)}")
    return name


def differences_context(
    t: PageTexts,
    watched: WatchedRun,
    other: Run | None,
    others: Sequence[Run],
    found: Sequence[EpisodeDifference],
    sort: str,
) -> dict[str, Any]:
    """Return the variables.

    Args:
        t: texts of the page's language.
        watched: the run of the address.
        other: the run with which it is compared; None if none is chosen.
        others: runs to choose from.
        found: the episodes, in the order in which they are listed.
        sort: name of the metric.
    """
    run = watched.run
    mean = sum(one.difference for one in found) / len(found) if found else 0.0
    return {
        "run": run,
        "is_published": watched.entry is not None,
        "other": other,
        "names": [shown(one.agent) if one is not None else "" for one in (run, other)],
        "choices": [("", t("differences.choose")), *run_choices(t, others)],
        "sort": sort,
        "metric_choices": [(name, metric.partition("@")[0]) for name, metric in METRICS.items()],
        "metric": METRICS[sort].partition("@")[0],
        "number": len(found),
        "mean": t.difference(mean),
        "rows": found[:SHOWN_EPISODES],
        "shown": SHOWN_EPISODES,
        "address": lambda episode_id: (
            f"/{t.language}/runs/{run.run_id}/episodes/{quote(episode_id, safe='')}?"
            + urlencode({"with": other.run_id if other is not None else ""})
        ),
    }


def run_choices(t: PageTexts, runs: Sequence[Run]) -> list[tuple[str, str]]:
    """Return id and description of each run, for a list to choose from."""
    return [
        (
            run.run_id,
            f"{shown(run.agent)} · {shown(run.participant)} · {t.named('languages', run.language)} · "
            f"{t.date(run.created_at)}",
        )
        for run in runs
    ]


def _gap(pair: tuple[EpisodeEnding, EpisodeEnding], metric: str) -> float:
    return abs(_mean(pair[0], metric) - _mean(pair[1], metric))


def _mean(ending: EpisodeEnding, metric: str) -> float:
    return sum(turn[metric] for turn in ending.scores) / len(ending.scores)
