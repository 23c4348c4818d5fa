"""Training examples of the placement networks: contents of the room, parsed instructions, and the target cell."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from random import Random

from arramon_agents.perception.eyes.vocabulary import LOOK_GROUPS
from arramon_agents.reading.reader.reader import LearnedReader
from arramon_agents.reading.reader.slots import Row, rows_of
from arramon_agents.simulated.courses import true_meaning
from arramon_client.world import ASSEMBLY, COLLECTIBLE_COLOURS, COLLECTIBLES
from arramon_lang.cell_grading import Cell, Room, RoomObject
from arramon_server.episodes.episode import Episode

WALLS = {"brick": 0, "wood": 1, "striped": 2, "spotted": 3}
"""Direction of each wall of the room, by its look."""

NAMING_ERROR_RATE = 0.05
"""Share of wrong kinds, colours and patterns in a room, to simulate errors of the visual encoder."""


@dataclass(frozen=True)
class RoomExample:
    """One assembly phase as a training example.

    Attributes:
        room: contents of the room before the object is placed.
        readings: the instruction as rows, alternatives: the true meaning, unless the grammar cannot parse the text, and
            the reader's output for each language.
        cell: target cell.
    """

    room: Room
    readings: Sequence[Sequence[Row]]
    cell: Cell


def room_examples_of(
    episodes: Sequence[Episode], languages: Sequence[str], reader: LearnedReader
) -> Iterator[RoomExample]:
    """Yield the examples of both turns of each episode.

    Args:
        episodes: the episodes.
        languages: languages of the instructions.
        reader: reader of instructions.
    """
    for episode in episodes:
        things = [
            RoomObject(each.type.kind, each.type.colour, each.type.pattern, each.placement.column, each.placement.row,
                     each.placement.level)
            for each in episode.decoys
        ]  # fmt: skip
        for number, turn in enumerate(episode.turns, start=1):
            texts = [episode.instruction(language, number, "assembly") for language in languages]
            meanings = true_meaning(texts[0], languages[0], ASSEMBLY)
            meanings += [reader.read(text, ASSEMBLY) for text in texts]
            cell = turn.target_cell
            yield RoomExample(Room(tuple(things), WALLS), [rows_of(each) for each in meanings], (cell.column, cell.row))
            target = turn.target.type
            things.append(RoomObject(target.kind, target.colour, target.pattern, cell.column, cell.row, cell.level))


def with_naming_errors(room: Room, random: Random) -> Room:
    """Return a room with random errors in kinds, colours and patterns."""
    things = []
    for thing in room.things:
        kind, colour, look = thing.kind, thing.colour, thing.look
        if random.random() < NAMING_ERROR_RATE:
            kind = random.choice(COLLECTIBLES)
        if random.random() < NAMING_ERROR_RATE:
            colour = random.choice(COLLECTIBLE_COLOURS)
        if random.random() < NAMING_ERROR_RATE:
            look = random.choice(LOOK_GROUPS[0].looks)
        things.append(RoomObject(kind, colour, look, thing.column, thing.row, thing.level))
    return Room(tuple(things), room.walls)
