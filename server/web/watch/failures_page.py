"""Template variables of the page on which a run's failures are sorted by how they ended."""

from collections.abc import Sequence
from typing import Any
from urllib.parse import quote

from arramon_server.scoring.turn_outcomes import NAVIGATION, OBJECT, PLACEMENT, TurnOutcome
from arramon_server.visible_text import shown
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.watch.failures import EpisodeOutcome
from arramon_server.web.watch.watched_runs import WatchedRun

GROUPS = {"navigation": NAVIGATION, "object": OBJECT, "placement": PLACEMENT, "nothing": (TurnOutcome.SOLVED,)}
"""Outcomes by the thing that failed first, as in `episodes_page.FAILURES`."""

LINKED = 12
"""Episodes that are linked for each outcome and turn."""

FEW = 5
"""Number of the best, middle and worst episodes."""


def failures_context(t: PageTexts, watched: WatchedRun, outcomes: Sequence[EpisodeOutcome]) -> dict[str, Any]:
    """Return the variables.

    Args:
        t: texts of the page's language.
        watched: the run.
        outcomes: outcomes of its episodes.
    """
    ranked = sorted(outcomes, key=lambda one: (-one.ndtw, one.ending.episode_id))
    middle = max((len(ranked) - FEW) // 2, 0)
    run = watched.run
    return {
        "run": run,
        "agent": shown(run.agent),
        "is_published": watched.entry is not None,
        "episodes": len(outcomes),
        "groups": [
            (name, [(kind.value, *(_episodes(outcomes, kind, turn) for turn in range(2))) for kind in kinds])
            for name, kinds in GROUPS.items()
        ],
        "chosen": [
            (name, [(one.ending.episode_id, one.ndtw) for one in few])
            for name, few in (
                ("worst", ranked[::-1][:FEW]),
                ("median", ranked[middle : middle + FEW]),
                ("best", ranked[:FEW]),
            )
        ],
        "linked": LINKED,
        "address": lambda episode_id: f"/{t.language}/runs/{run.run_id}/episodes/{quote(episode_id, safe='')}",
    }


def _episodes(outcomes: Sequence[EpisodeOutcome], kind: TurnOutcome, turn: int) -> list[str]:
    """Return the ids of the episodes with an outcome in a turn, the lowest nDTW of the turn first."""
    found = [one for one in outcomes if one.turns[turn] is kind]
    ordered = sorted(found, key=lambda one: (one.ending.scores[turn]["nDTW"], one.ending.episode_id))
    return [one.ending.episode_id for one in ordered]
