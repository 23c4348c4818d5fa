"""Demands of generated episodes: the kinds of steps, landmarks and relations that their instructions contain.

See `arramon_server.episodes.demands`. Reading a generated text gives back its meaning, the same in every language.
Texts by people are not counted, as the parser skips words that it does not know.
"""

from pathlib import Path

import arramon_lang as lang
from arramon_dataset.generation.split_maker import SOURCE
from arramon_lang.coreference import first_mentions, mentions, things_of
from arramon_lang.meaning import PLACES, Assembly, Face, Navigation, Rotate, Step, Thing, Where
from arramon_server.episodes.demands import Demands, TurnDemands, write_demands
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split, read_split, split_folder
from arramon_server.errors import BadInput, StorageError

WRITTEN = f"{SOURCE}, scale "
"""Prefix of the `source` of splits whose texts the grammar wrote, not paraphrases."""


def add_demands(data: Path, split: Split) -> Split:
    """Write the demands of a generated split beside its episodes, and return the split with them.

    Raises:
        BadInput: if the split was not generated: people's texts are not read in full.
        StorageError: if the file cannot be written.
    """
    if not split.source.startswith(WRITTEN):
        raise BadInput(
            f"split {split.name!r} is {split.source}; what instructions ask for can be counted only where they were "
            "generated, as others are not read in full"
        )
    folder = split_folder(data, split.name)
    try:
        write_demands(folder, split.data_hash, demands_of(split))
    except OSError as error:
        raise StorageError(f"cannot write to {folder}: {error.strerror}") from error
    return read_split(folder)


def demands_of(split: Split) -> Demands:
    """Return the demands of every episode of a generated split, read in the first language that it has."""
    return {name: episode_demands(episode, min(episode.instructions)) for name, episode in split.episodes.items()}


def episode_demands(episode: Episode, language: str) -> tuple[TurnDemands, TurnDemands]:
    """Return the demands of a generated episode, read in one of its languages.

    Raises:
        CannotRead: if nothing of a text is understood.
    """
    return _turn_demands(episode, language, 1), _turn_demands(episode, language, 2)


def _turn_demands(episode: Episode, code: str, turn: int) -> TurnDemands:
    language = lang.load(code)
    navigation = language.read(episode.instruction(code, turn, "navigation"), "navigation")
    assembly = language.read(episode.instruction(code, turn, "assembly"), "assembly")
    assert isinstance(navigation, Navigation)
    assert isinstance(assembly, Assembly)
    stated = [where for step in navigation.steps for thing in things_of(step) for where in _relations(thing)]
    stated += _relations(navigation.target)
    return TurnDemands(
        steps=tuple(map(_kind, navigation.steps)),
        landmarks=_landmarks(navigation),
        relations=tuple(where.relation for where in stated),
        placements=tuple(where.relation for where in assembly.where),
    )


def _kind(step: Step) -> str:
    if isinstance(step, Rotate):
        return f"turn_{step.at}" if step.at else "turn"
    return "face" if isinstance(step, Face) else step.way


def _relations(thing: Thing) -> list[Where]:
    """Return the relations of a thing and, recursively, of their landmarks."""
    return [found for where in thing.where for found in (where, *(w for t in where.things for w in _relations(t)))]


def _landmarks(navigation: Navigation) -> tuple[str, ...]:
    """Return the sort of each thing named besides the target; repeated mentions count once."""
    named = list(zip(first_mentions(navigation), mentions(navigation), strict=True))
    of_target = next(first for first, thing in named if thing is navigation.target)
    firsts = {first: thing for number, (first, thing) in enumerate(named) if first == number and first != of_target}
    return tuple(_sort(thing.kind) for thing in firsts.values() if thing.kind != "you")


def _sort(kind: str) -> str:
    if kind in PLACES:
        return "place"
    return kind if kind in ("building", "banner") else "object"
