"""Template variables of the part of a page on which an episode is watched, and the data of its scripts."""

from collections.abc import Mapping
from typing import Any
from urllib.parse import quote

from arramon_client.world import PHASES, TURNS
from arramon_server.errors import NotFound, quoted
from arramon_server.playback.moments import MomentMark
from arramon_server.runs.storage.journal import Journal
from arramon_server.sim.own_furniture import furnished
from arramon_server.visible_text import shown
from arramon_server.web.named_things import object_name
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.section_map import draw_section
from arramon_server.web.watch.moment_views import MomentViews, notable_steps
from arramon_server.web.watch.playbacks import Playbacks
from arramon_server.web.watch.stage import room_start, turn_stage
from arramon_server.web.watch.watched_runs import WatchedEpisode

SPEEDS = (1, 2, 4, 8, 16)
"""Frames a second to choose from."""

USUAL_SPEED = 4


class WatchPart:
    """Makes the part of the page, and the file of moments that its scripts read.

    Args:
        playbacks: replays the episodes.
        journal: source of the notes.
    """

    def __init__(self, playbacks: Playbacks, journal: Journal) -> None:
        self._playbacks = playbacks
        self._journal = journal

    def context(self, t: PageTexts, watched: WatchedEpisode, query: Mapping[str, str]) -> dict[str, Any]:
        """Return the variables of the template.

        Args:
            t: texts of the page's language.
            watched: the episode.
            query: query of the address: "step".

        Raises:
            NotFound: if there is no such step.
        """
        views = self.views(t, watched)
        moments = views.moments
        step = read_step(query.get("step", ""), views.last, views.last if watched.is_live else 0)
        episode, run = watched.episode, watched.run
        section = furnished(watched.watched.split.sections[episode.section], episode.furniture)
        turns = [[one for one in moments if one.state.turn == number] for number in range(1, TURNS + 1)]
        now = views.view(step)
        address = quote(episode.episode_id, safe="")
        files = f"/runs/{run.run_id}/episodes/{address}"
        return {
            "run": run,
            "agent": shown(run.agent),
            "episode": episode,
            "is_film": False,
            "is_live": watched.is_live,
            "shows_truth": watched.shows_truth,
            "shows_maps": not watched.is_played_by_person,
            "now": now,
            "note": views.note(now["note"]) if now["note"] >= 0 else None,
            "reading": views.note(now["reading"])["reading"] if now["reading"] >= 0 else (),
            "last": len(moments) - 1,
            "ground": draw_section(section),
            "stages": [
                turn_stage(t, episode, section, number, turns[number - 1], shows_truth=watched.shows_truth)
                for number in range(1, TURNS + 1)
            ],
            "room_start": room_start(),
            "texts": {
                "instructions": self._instructions(watched),
                "phases": phase_names(t),
                "events": {mark.value: t(f"events.{mark.value}") for mark in MomentMark},
                "play": t("watch.play"),
                "pause": t("watch.pause"),
                "frame": t("watch.frame", step="{step}"),
            },
            "trail": " ".join(f"{x:g},{y:g}" for x, y in views.trail(step)),
            "events": notable_steps(moments, shows_truth=watched.shows_truth),
            "speeds": SPEEDS,
            "usual_speed": USUAL_SPEED,
            "here": f"/{t.language}/runs/{run.run_id}/episodes/{address}",
            "link": f"/{t.language}/runs/{run.run_id}/episodes/{address}?step={step}",
            "files": files,
            "frame": f"{files}/frames/{step}.jpg",
            "object_name": lambda type_: object_name(t, type_),
            "pile_name": lambda pile: " + ".join(object_name(t, type_) for type_ in pile.types),
        }

    def data(self, t: PageTexts, watched: WatchedEpisode, first: int) -> dict[str, Any]:
        """Return the moments from step `first` on, for scripts.

        Keys: `first`, `last` (number of the last moment), `live` (whether more may come), `moments`
        (`MomentViews.view`), `notes` (`MomentViews.note`, by step), `next` (address of an episode of the run that is
        being played, once this one is not; empty for none).

        Raises:
            NotFound: if there is no such step.
        """
        views = self.views(t, watched)
        last = views.last
        if first > last:
            raise NotFound(f"there is no step {first}; expected 0 to {last}")
        return {
            "first": first,
            "last": last,
            "live": watched.is_live,
            "moments": [views.view(step) for step in range(first, last + 1)],
            "notes": views.notes_from(max(first - 1, 0)),
            "next": "" if watched.is_live else self._next(t, watched),
        }

    def _next(self, t: PageTexts, watched: WatchedEpisode) -> str:
        run = watched.run
        if run.ended_at is not None:
            return ""
        opened = self._journal.open_episodes(run.run_id)
        return f"/{t.language}/runs/{run.run_id}/episodes/{quote(opened[0], safe='')}" if opened else ""

    def views(self, t: PageTexts, watched: WatchedEpisode) -> MomentViews:
        """Return the views of an episode's moments."""
        return MomentViews(
            t,
            watched.episode,
            watched.watched.split.sections[watched.episode.section],
            self._playbacks.of(watched).playback,
            self._journal.notes_of(watched.run.run_id, watched.episode.episode_id),
            watched.run.steps_per_phase,
            shows_truth=watched.shows_truth,
            shows_places=not watched.is_played_by_person,
        )

    def _instructions(self, watched: WatchedEpisode) -> dict[str, str]:
        """Return the instructions by turn and phase, such as "1-navigation"."""
        language = watched.run.language
        return {
            f"{turn}-{phase}": watched.episode.instruction(language, turn, phase)
            for turn in range(1, TURNS + 1)
            for phase in PHASES
        }


def phase_names(t: PageTexts) -> dict[str, str]:
    """Return the names of all phases, by turn and phase, such as "1-navigation"."""
    return {
        f"{turn}-{phase}": t("watch.phase", turn=turn, phase=t(f"path.{phase}"))
        for turn in range(1, TURNS + 1)
        for phase in PHASES
    }


def read_step(text: str, last: int, default: int) -> int:
    """Return the number of a step in the query of an address.

    Args:
        text: the number; empty for the default.
        last: number of the last step.
        default: number of the step that is shown if none is named.

    Raises:
        NotFound: if it is no number of a step.
    """
    if not text:
        return default
    if not (text.isascii() and text.isdecimal() and len(text) < 8 and int(text) <= last):
        raise NotFound(f"there is no step {quoted(text)}; expected 0 to {last}")
    return int(text)
