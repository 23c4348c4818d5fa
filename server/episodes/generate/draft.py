"""An episode without words: what is drawn first, and what instructions are then written for."""

from collections.abc import Mapping
from dataclasses import dataclass

from server.episodes.episode import Episode, Instructions, Turn
from server.sim.geometry import Pose
from server.sim.rules import Layout, PlacedObject


@dataclass(frozen=True, slots=True)
class Draft:
    """All of an `Episode` but its instructions.

    Attributes:
        episode_id: unique in its split.
        section: of the city.
        start: where turn 1 begins.
        turns: both.
        decoys: what stands in the room when the first assembly phase begins.
    """

    episode_id: str
    section: str
    start: Pose
    turns: tuple[Turn, Turn]
    decoys: tuple[PlacedObject, ...]

    @property
    def layout(self) -> Layout:
        """What the rules need to know."""
        return Layout(self.start, tuple(turn.street for turn in self.turns), self.decoys)

    def spoken(self, instructions: Mapping[str, tuple[Instructions, Instructions]]) -> Episode:
        """The episode with these instructions, by language code."""
        return Episode(
            self.episode_id, self.section, self.start, self.turns, self.decoys, dict(sorted(instructions.items()))
        )
