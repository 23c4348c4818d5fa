"""Episode drafts: episodes before their instructions are written."""

from collections.abc import Mapping
from dataclasses import dataclass

from arramon_server.episodes.episode import Episode, Instructions, Turn
from arramon_server.sim.geometry import Pose
from arramon_server.sim.rules import EpisodeLayout, PlacedObject


@dataclass(frozen=True, slots=True)
class Draft:
    """An `Episode` without its instructions.

    Attributes:
        episode_id: unique in its split.
        section: id of the city section.
        start: pose at the beginning of turn 1.
        turns: both turns.
        decoys: objects in the room when the first assembly phase begins.
    """

    episode_id: str
    section: str
    start: Pose
    turns: tuple[Turn, Turn]
    decoys: tuple[PlacedObject, ...]

    @property
    def layout(self) -> EpisodeLayout:
        """The part of the episode that the rules depend on."""
        return EpisodeLayout(self.start, tuple(turn.street for turn in self.turns), self.decoys)

    def with_instructions(self, instructions: Mapping[str, tuple[Instructions, Instructions]]) -> Episode:
        """Return the episode with these instructions, by language code."""
        return Episode(
            self.episode_id, self.section, self.start, self.turns, self.decoys, dict(sorted(instructions.items()))
        )
