"""Check of a navigation text against its episode's world: named street furniture that is not there."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from arramon_dataset.release.landmarks.agreement import WITHIN, landmarks_by_kind, mentions_of, placed_things
from arramon_dataset.release.landmarks.alignment import align
from arramon_dataset.release.landmarks.mentions import Event, events_of
from arramon_dataset.release.landmarks.rebuilt_section import KNOWN
from arramon_dataset.release.landmarks.recovery import LandmarkMap
from arramon_dataset.release.landmarks.turn_paths import paths_of_turns
from arramon_lang.quality import SUSPICIOUS, Failure
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import read_splits, split_with_episode
from arramon_server.errors import NotFound
from arramon_server.sim.own_furniture import furnished
from arramon_server.sim.section import Section

CHECK = "not_there"
"""Name of the check."""


def missing_furniture(text: str, language: str, episode: Episode, turn: int, section: Section) -> list[Failure]:
    """Return a failure for each piece of street furniture that a text names and that is not there, in its order.

    The text is aligned with the ground truth's path. A thing is there if one of its kind, in the colour, shape and on
    the side that the text says, stands within `agreement.WITHIN` of where the text puts it.

    Args:
        text: a navigation instruction.
        language: code of its language.
        episode: with its own furniture.
        turn: 1 or 2.
        section: of the episode.
    """
    return [
        Failure(CHECK, SUSPICIOUS, _message(thing.event, turn, thing.place, thing.at))
        for thing in absent_things(text, language, episode, turn, section)
    ]


@dataclass(frozen=True, slots=True)
class AbsentThing:
    """A thing that a text names and that is not there.

    Attributes:
        event: how the text names it.
        place: index of the place on the path from which it would be seen.
        at: that place, (x, z).
    """

    event: Event
    place: int
    at: tuple[float, ...]


def absent_things(text: str, language: str, episode: Episode, turn: int, section: Section) -> list[AbsentThing]:
    """Return the things of `missing_furniture`."""
    events = events_of(text, language)
    if not events:
        return []
    path = paths_of_turns(episode)[turn - 1]
    things = placed_things(furnished(section, episode.furniture).props)
    aligned = align(events, path, LandmarkMap.of(landmarks_by_kind(things, KNOWN)).fit)
    return [
        AbsentThing(event, place, tuple(path.places[place]))
        for event, place, thing in mentions_of(events, aligned, path, things)
        if thing < 0
    ]


def _message(event: Event, turn: int, place: int, at: tuple[float, ...]) -> str:
    name = " ".join(filter(None, (event.colour, event.look, event.kind.replace("_", " "))))
    where = "beside the object to pick up" if event.manner == "target" else "where it is named"
    side = f" on the {event.side}" if event.side else ""
    return (
        f"names a {name}{side}, but none stands within {WITHIN:g} units of {where}: "
        f"turn {turn}, after {place} steps forward, at ({at[0]:.1f}, {at[1]:.1f})"
    )


def check_in_world(
    data: Path, episode_id: str, split: str | None, turn: int | None, language: str, texts: Iterable[str] = ()
) -> Iterator[tuple[str, int, tuple[Failure, ...]]]:
    """Yield each navigation text, its turn and the failures of `missing_furniture`.

    Args:
        data: the data folder.
        episode_id: of the episode in whose world the texts are checked.
        split: its name; None for the first that has the episode.
        turn: 1 or 2; None for both.
        language: code of the language.
        texts: to check; if there are none, the episode's own navigation instructions.

    Raises:
        NotFound: if there is no such split or episode, or it has no instructions in the language.
    """
    chosen = split_with_episode(read_splits(data), episode_id, split)
    episode = chosen.episodes[episode_id]
    listed = list(texts)
    if not listed and language not in episode.instructions:
        there = ", ".join(episode.instructions)
        raise NotFound(f"episode {episode_id!r} has no instructions in {language!r}; it has {there}")
    for number in (1, 2) if turn is None else (turn,):
        for text in listed or [episode.instruction(language, number, "navigation")]:
            yield (
                text,
                number,
                tuple(missing_furniture(text, language, episode, number, chosen.sections[episode.section])),
            )
