"""Template variables of the page on which two runs of one episode are watched side by side."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any
from urllib.parse import quote, urlencode

from arramon_client.world import PHASES, TURNS
from arramon_server.errors import NotFound
from arramon_server.playback.alignment import align
from arramon_server.playback.moments import Moment
from arramon_server.sim.own_furniture import furnished
from arramon_server.sim.room import RoomCell
from arramon_server.sim.rules import Placed
from arramon_server.visible_text import shown
from arramon_server.web.named_things import object_name
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.room_map import cell_centre, object_stacks
from arramon_server.web.section_map import draw_section
from arramon_server.web.watch.moment_views import MomentViews, notable_steps
from arramon_server.web.watch.playbacks import Playbacks
from arramon_server.web.watch.stage import turn_stage
from arramon_server.web.watch.watch_part import SPEEDS, USUAL_SPEED, phase_names, read_step
from arramon_server.web.watch.watched_runs import WatchedEpisode

NAMES = ("A", "B")
"""Names of the two runs on the page."""


@dataclass(frozen=True, slots=True)
class RunPlacement:
    """Where a run placed its object in a turn, on the map of the room.

    Attributes:
        side: 0 or 1, the run.
        x, y: centre of the cell.
        level: level in the cell, from 1.
    """

    side: int
    x: float
    y: float
    level: int


class PairPart:
    """Makes the variables.

    Args:
        playbacks: replays the episodes.
    """

    def __init__(self, playbacks: Playbacks) -> None:
        self._playbacks = playbacks

    def context(
        self, t: PageTexts, first: WatchedEpisode, second: WatchedEpisode, query: Mapping[str, str]
    ) -> dict[str, Any]:
        """Return the variables of the template.

        Args:
            t: texts of the page's language.
            first: the episode in the run of the address.
            second: the same episode in another run, on the same data.
            query: query of the address: "step", a position on the slider of both.

        Raises:
            NotFound: if there is no such step, or one of them has not ended: until then its path is compared with
                nothing, as that would show where the reference leads.
        """
        both = first, second
        if first.ending is None or second.ending is None:
            raise NotFound(f"episode {first.episode.episode_id!r} has not ended in both runs")
        episode = first.episode
        section = furnished(first.watched.split.sections[episode.section], episode.furniture)
        views = [self._views(t, watched) for watched in both]
        pairs = align(episode, views[0].moments, views[1].moments)
        step = read_step(query.get("step", ""), len(pairs) - 1, 0)
        now = [view.view(place) for view, place in zip(views, pairs[step], strict=True)]
        leader = max(now, key=lambda one: (one["turn"], PHASES.index(one["phase"])))
        here = f"{_address(t, first)}?{urlencode({'with': second.run.run_id})}"
        return {
            "run": first.run,
            "episode": episode,
            "sides": [
                self._side(t, side, both[side], views[side], now[side], pairs[step][side]) for side in range(len(both))
            ],
            "key": f"{leader['turn']}-{leader['phase']}",
            "pairs": pairs,
            "step": step,
            "last": len(pairs) - 1,
            "ground": draw_section(section),
            "stages": [
                replace(
                    turn_stage(t, episode, section, number, _of_turn(views, number), shows_truth=True),
                    piles=object_stacks(episode.decoys),
                )
                for number in range(1, TURNS + 1)
            ],
            "placed": [_placed(views, number) for number in range(1, TURNS + 1)],
            "instructions": _instructions(both),
            "events": _events(views, pairs),
            "texts": {
                "phases": phase_names(t),
                "play": t("watch.play"),
                "pause": t("watch.pause"),
                "frame": t("pair.frame", name="{name}", step="{step}"),
            },
            "speeds": SPEEDS,
            "usual_speed": USUAL_SPEED,
            "here": here,
            "link": f"{here}&step={step}",
            "is_film": False,
            "swapped": f"{_address(t, second)}?{urlencode({'with': first.run.run_id})}",
            "object_name": lambda type_: object_name(t, type_),
            "pile_name": lambda pile: " + ".join(object_name(t, type_) for type_ in pile.types),
        }

    def _views(self, t: PageTexts, watched: WatchedEpisode) -> MomentViews:
        return MomentViews(
            t,
            watched.episode,
            watched.watched.split.sections[watched.episode.section],
            self._playbacks.of(watched).playback,
            {},
            watched.run.steps_per_phase,
            shows_truth=True,
        )

    def _side(
        self, t: PageTexts, side: int, watched: WatchedEpisode, views: MomentViews, now: dict[str, Any], step: int
    ) -> dict[str, Any]:
        """Return what the page shows of one run."""
        address = _address(t, watched)
        assert watched.ending is not None  # see `context`
        scores = watched.ending.scores
        return {
            "name": NAMES[side],
            "agent": shown(watched.run.agent),
            "participant": shown(watched.run.participant),
            "language": watched.run.language,
            "ndtw": t.score(sum(turn["nDTW"] for turn in scores) / len(scores)),
            "now": now,
            "last": len(views.moments) - 1,
            "trail": " ".join(f"{x:g},{y:g}" for x, y in views.trail(step)),
            "address": address,
            "moments": f"{address}/moments.json",
            "frames": f"/runs/{watched.run.run_id}/episodes/{quote(watched.episode.episode_id, safe='')}/frames/",
        }


def _address(t: PageTexts, watched: WatchedEpisode) -> str:
    return f"/{t.language}/runs/{watched.run.run_id}/episodes/{quote(watched.episode.episode_id, safe='')}"


def _of_turn(views: Sequence[MomentViews], number: int) -> list[Moment]:
    """Return the moments of a turn in both runs."""
    return [moment for view in views for moment in view.moments if moment.state.turn == number]


def _placed(views: Sequence[MomentViews], number: int) -> list[RunPlacement]:
    """Return where the runs placed their objects in a turn."""
    return [
        RunPlacement(side, *cell_centre(RoomCell(event.placement.column, event.placement.row)), event.placement.level)
        for side, view in enumerate(views)
        for moment in view.moments
        for event in moment.events
        if isinstance(event, Placed) and moment.state.turn == number
    ]


def _instructions(both: Sequence[WatchedEpisode]) -> list[tuple[str, dict[str, str]]]:
    """Return the language and the instructions of each run, by turn and phase; one entry if both had the same."""
    languages = dict.fromkeys(watched.run.language for watched in both)
    return [
        (
            language,
            {
                f"{turn}-{phase}": both[0].episode.instruction(language, turn, phase)
                for turn in range(1, TURNS + 1)
                for phase in PHASES
            },
        )
        for language in languages
    ]


def _events(views: Sequence[MomentViews], pairs: Sequence[tuple[int, int]]) -> list[tuple[int, int, int, str]]:
    """Return what stands out in both runs: position on the slider, run (0 or 1), its step, and the mark."""
    found = list[tuple[int, int, int, str]]()
    for side, view in enumerate(views):
        positions = dict[int, int]()
        for position, pair in enumerate(pairs):
            positions.setdefault(pair[side], position)
        found += [(positions[step], side, step, mark.value) for step, mark in notable_steps(view.moments)]
    return sorted(found)
