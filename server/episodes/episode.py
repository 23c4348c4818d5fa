"""Definition of an episode: start pose, two turns with ground truth and objects, instructions in each language."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from arramon_client.world import Action
from arramon_server.sim.geometry import Pose
from arramon_server.sim.own_furniture import NO_FURNITURE, OwnFurniture
from arramon_server.sim.room import RoomCell, RoomPosition
from arramon_server.sim.rules import Collectible, EpisodeLayout, PlacedObject


@dataclass(frozen=True, slots=True)
class Instructions:
    """The instruction texts of a turn's two phases, verbatim, including typing errors."""

    navigation: str
    assembly: str

    def __post_init__(self) -> None:
        for phase, text in (("navigation", self.navigation), ("assembly", self.assembly)):
            if not text.strip():
                raise ValueError(f"the {phase} instruction is empty")


@dataclass(frozen=True, slots=True)
class Turn:
    """One turn: a navigation phase that ends with a pick-up, then an assembly phase.

    Attributes:
        path: distinct positions (x, z) of the navigation's ground truth, in units.
        actions: ground-truth actions of the navigation, the pick-up included.
        room_path: distinct cells of the assembly's ground truth.
        room_actions: ground-truth actions of the assembly, the placement included.
        street: the objects in the street; the first is the target.
        target_cell: where the target is to be placed.
    """

    path: tuple[tuple[float, float], ...]
    actions: tuple[Action, ...]
    room_path: tuple[RoomCell, ...]
    room_actions: tuple[Action, ...]
    street: tuple[Collectible, ...]
    target_cell: RoomPosition

    def __post_init__(self) -> None:
        for name in ("path", "actions", "room_path", "room_actions", "street"):
            if not getattr(self, name):
                raise ValueError(f"{name} is empty")

    @property
    def target(self) -> Collectible:
        """The object to pick up."""
        return self.street[0]


@dataclass(frozen=True, slots=True)
class Episode:
    """Definition of one episode, with its ground truth. `arramon_client.agent.Episode` is the part that agents get.

    Attributes:
        episode_id: unique in its split; the release's `mapId`.
        section: id of the city section.
        start: pose at the beginning of turn 1.
        turns: both turns.
        decoys: objects in the room when the first assembly phase begins.
        instructions: texts of both turns, by language code.
        furniture: how its street furniture differs from its section's.
    """

    episode_id: str
    section: str
    start: Pose
    turns: tuple[Turn, Turn]
    decoys: tuple[PlacedObject, ...]
    instructions: Mapping[str, tuple[Instructions, Instructions]]
    furniture: OwnFurniture = NO_FURNITURE

    def __post_init__(self) -> None:
        if not self.instructions:
            raise ValueError("there are no instructions in any language")

    @property
    def layout(self) -> EpisodeLayout:
        """The part of the episode that the rules depend on."""
        return EpisodeLayout(self.start, (self.turns[0].street, self.turns[1].street), self.decoys)

    def instruction(self, language: str, turn: int, phase: str) -> str:
        """Return the instruction of a phase ("navigation" or "assembly") of turn 1 or 2."""
        text: str = getattr(self.instructions[language][turn - 1], phase)
        return text


def with_languages(episode: Episode, further_instructions: Mapping[str, tuple[Instructions, Instructions]]) -> Episode:
    """Return the episode with the instructions of further languages added, ordered by language code."""
    merged = {**episode.instructions, **further_instructions}
    return replace(episode, instructions=dict(sorted(merged.items())))


def languages_of(episodes: Iterable[Episode]) -> dict[str, int]:
    """Return the number of episodes with instructions in each language, by code."""
    counts: dict[str, int] = {}
    for episode in episodes:
        for language in episode.instructions:
            counts[language] = counts.get(language, 0) + 1
    return dict(sorted(counts.items()))
