"""Template variables of the list of a run's episodes and of the page of one episode, for open splits only."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any
from urllib.parse import quote, urlencode

from arramon_server.board.board import Board
from arramon_server.board.standings import Entry
from arramon_server.errors import NotFound, quoted
from arramon_server.runs.storage.corrections import voided_by
from arramon_server.runs.storage.records import EpisodeEnding
from arramon_server.scoring.episode_scores import Scores
from arramon_server.web.episode_replays import EpisodeReplays, PlayedEpisode
from arramon_server.web.map_labels import MapLabel, place_labels
from arramon_server.web.named_things import named_things, object_name
from arramon_server.web.page_texts import PageTexts, all_texts
from arramon_server.web.room_map import ObjectStack
from arramon_server.web.section_map import place_on_map
from arramon_server.web.standings_page import columns
from arramon_server.web.standings_query import METRICS

ALL = "all"

NAVIGATION, OBJECT, PLACEMENT, NOTHING = "navigation", "object", "placement", "nothing"
"""The first thing at which a turn failed: it ended more than 3 units from its target; it ended there with a wrong
object; it placed the right object in a wrong cell; it failed at nothing."""

FAILURES = (ALL, NAVIGATION, OBJECT, PLACEMENT, NOTHING)

TURNS = (ALL, "1", "2")

PAGE_SIZE = 100
"""Episodes on one page."""


@dataclass(frozen=True, slots=True)
class EpisodeFilter:
    """Filter of the list of episodes.

    Attributes:
        failed: one of FAILURES.
        turn: "1" or "2", the turn that failed; ALL for either turn or, with NOTHING, for both.
        cause: cause of the episode's end; ALL for any.
    """

    failed: str = ALL
    turn: str = ALL
    cause: str = ALL

    @classmethod
    def read(cls, query: Mapping[str, str], causes: Sequence[str]) -> "EpisodeFilter":
        """Parse the filter in the query of an address.

        Raises:
            NotFound: if it has a value that does not exist.
        """
        allowed = {"failed": FAILURES, "turn": TURNS, "cause": (ALL, *causes)}
        chosen = {name: query.get(name, ALL) for name in allowed}
        for name, value in chosen.items():
            if value not in allowed[name]:
                raise NotFound(f"there is no {name} {quoted(value)}")
        return cls(**chosen)

    def fits(self, ending: EpisodeEnding) -> bool:
        """Return whether an episode passes the filter."""
        if self.cause not in (ALL, ending.cause):
            return False
        found = [failure_of(turn) == self.failed for turn in ending.scores]
        if self.failed == ALL:
            return True
        if self.turn != ALL:
            return found[int(self.turn) - 1]
        return all(found) if self.failed == NOTHING else any(found)

    def link(self, **more: object) -> str:
        """Return the query for the filter, without fields that have their defaults; empty if all have."""
        named = {"failed": self.failed, "turn": self.turn, "cause": self.cause, **more}
        query = urlencode({name: value for name, value in named.items() if value not in (ALL, 1)})
        return f"?{query}" if query else ""


def failure_of(turn: Scores) -> str:
    """Return the first thing at which a turn failed, one of FAILURES."""
    if not turn["CTC-3"]:
        return NAVIGATION
    if not turn["CTC-0"]:
        return OBJECT
    return NOTHING if turn["PTC"] else PLACEMENT


class EpisodesPage:
    """Builds the variables of the list of episodes and of one episode's page.

    Args:
        board: the leaderboard, with the published runs.
        replays: draws episodes.
    """

    def __init__(self, board: Board, replays: EpisodeReplays) -> None:
        self._board = board
        self._replays = replays

    def context(self, t: PageTexts, run_id: str, query: Mapping[str, str]) -> dict[str, Any]:
        """Return the template variables of the list of episodes.

        Args:
            t: texts of the page's language.
            run_id: id of the run.
            query: query of the address: "failed", "turn", "cause", "page".

        Raises:
            NotFound: if the run is not published, its episodes may not be shown, or the query has an unknown value.
        """
        entry, endings = self._endings(run_id)
        causes = sorted({ending.cause for ending in endings})
        chosen = EpisodeFilter.read(query, causes)
        fitting = [ending for ending in endings if chosen.fits(ending)]
        page = query.get("page", "1")
        if not (page.isascii() and page.isdecimal() and 0 < int(page[:6]) <= max(1, -(-len(fitting) // PAGE_SIZE))):
            raise NotFound(f"there is no page {quoted(page)}")
        first = (int(page[:6]) - 1) * PAGE_SIZE
        split = self._replays.split(entry)
        assert split is not None  # as in `_endings`
        here = fitting[first : first + PAGE_SIZE]
        return {
            "entry": entry,
            "chosen": chosen,
            "rows": [(ending, split.episodes[ending.episode_id].section, _failures(ending)) for ending in here],
            "void": voided_by(self._board.corrections(entry.run.split)),
            "address": lambda episode_id: _address(t, entry, episode_id, chosen),
            "fitting": len(fitting),
            "all": len(endings),
            "page": int(page[:6]),
            "pages": -(-len(fitting) // PAGE_SIZE),
            "failures": [(name, t(f"episodes.{name}")) for name in FAILURES],
            "turns": [(ALL, t("episodes.any_turn")), *((name, t(f"turns.{name}")) for name in TURNS[1:])],
            "causes": [(ALL, t("episodes.any_cause")), *((name, t.named("causes", name)) for name in causes)],
        }

    def episode_context(self, t: PageTexts, run_id: str, episode_id: str, query: Mapping[str, str]) -> dict[str, Any]:
        """Return the template variables of one episode's page.

        Args:
            t: texts of the page's language.
            run_id: id of the run.
            episode_id: id of the episode.
            query: query of the address: the filter of the list that linked here.

        Raises:
            NotFound: if the run is not published, has no such episode, or its episodes may not be shown.
        """
        entry, endings = self._endings(run_id)
        played = self._replays.played(entry, episode_id)
        chosen = EpisodeFilter.read(query, sorted({ending.cause for ending in endings}))
        ids = [ending.episode_id for ending in endings if chosen.fits(ending)]
        if episode_id not in ids:
            chosen, ids = EpisodeFilter(), [ending.episode_id for ending in endings]
        at = ids.index(episode_id)
        return {
            "entry": entry,
            "played": played,
            "spoken": entry.run.language,
            "metrics": METRICS,
            "columns": columns(t),
            "list": f"/{t.language}/runs/{run_id}/episodes{chosen.link()}",
            "number": (at + 1, len(ids)),
            "previous": _address(t, entry, ids[at - 1], chosen) if at else "",
            "next": _address(t, entry, ids[at + 1], chosen) if at + 1 < len(ids) else "",
            "failures": _failures(played.ending),
            "void": episode_id in voided_by(self._board.corrections(entry.run.split)),
            "labels": [map_labels(t, entry.run.language, played, turn) for turn in range(2)],
            "path_text": partial(t.in_groups, ("path",)),
            "object_name": lambda type_: object_name(t, type_),
            "pile_name": lambda pile: pile_name(t, pile),
        }

    def _endings(self, run_id: str) -> tuple[Entry, list[EpisodeEnding]]:
        """Return a published run and the endings of its episodes, sorted by id."""
        entry = self._board.entry(run_id)
        if self._replays.split(entry) is None:
            raise NotFound(f"run {run_id!r} has no episodes to show")
        return entry, sorted(self._replays.endings(entry), key=lambda ending: _natural(ending.episode_id))


def _failures(ending: EpisodeEnding) -> list[str]:
    return [failure_of(turn) for turn in ending.scores]


def _address(t: PageTexts, entry: Entry, episode_id: str, chosen: EpisodeFilter) -> str:
    return f"/{t.language}/runs/{entry.run.run_id}/episodes/{quote(episode_id, safe='')}{chosen.link()}"


def map_labels(t: PageTexts, language: str, played: PlayedEpisode, number: int) -> tuple[MapLabel, ...]:
    """Return the labels on the map of a turn: the target, and things near the path that the instruction mentions.

    They cover neither the reference path nor the one played.

    Args:
        t: texts of the page's language.
        language: language of the instructions.
        played: the episode.
        number: index of the turn.
    """
    turn = played.episode.turns[number]
    target = turn.target
    named = [(object_name(t, target.type), (target.position.x, target.position.z))]
    instruction_words = all_texts().get(language)
    if instruction_words is not None:
        text = played.episode.instructions[language][number].navigation
        found = named_things(t, instruction_words, played.section, text, turn.path)
        named += [(thing.name, thing.position) for thing in found]
    ground, track = played.ground, played.tracks[number]
    places = [(name, place_on_map(played.section, point)) for name, point in named]
    return place_labels((0.0, 0.0, ground.width, ground.height), places, track.ways)


def pile_name(t: PageTexts, pile: ObjectStack) -> str:
    """Return the names of the objects on a cell, from below."""
    return " + ".join(object_name(t, type_) for type_ in pile.types)


def _natural(text: str) -> list[tuple[int, str]]:
    """Return a sort key for natural order, in which 9 comes before 10."""
    return [(int(part) if part.isdecimal() else -1, part) for part in re.split(r"([0-9]+)", text)]
