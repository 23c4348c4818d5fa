"""What an episode is: its start, its two turns of ground truth and objects, and its instructions in each language."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from server.sim.geometry import Pose
from server.sim.room import Placement, Square
from server.sim.rules import Action, Collectible, Layout, PlacedObject


@dataclass(frozen=True, slots=True)
class Instructions:
    """What a turn's two phases say, exactly as it was written, typing errors included."""

    navigation: str
    assembly: str

    def __post_init__(self) -> None:
        for phase, text in (("navigation", self.navigation), ("assembly", self.assembly)):
            if not text.strip():
                raise ValueError(f"the {phase} instruction is empty")


@dataclass(frozen=True, slots=True)
class Turn:
    """One turn: navigate and pick up, then assemble.

    Attributes:
        path: the navigation's ground truth, distinct positions (x, z) in units.
        actions: the navigation's ground-truth actions, the pick-up included.
        room_path: the assembly's ground truth, distinct cells.
        room_actions: the assembly's ground-truth actions, the placement included.
        street: the objects in the street; the first is the target.
        target_cell: where the target belongs.
    """

    path: tuple[tuple[float, float], ...]
    actions: tuple[Action, ...]
    room_path: tuple[Square, ...]
    room_actions: tuple[Action, ...]
    street: tuple[Collectible, ...]
    target_cell: Placement

    def __post_init__(self) -> None:
        for name in ("path", "actions", "room_path", "room_actions", "street"):
            if not getattr(self, name):
                raise ValueError(f"{name} is empty")

    @property
    def target(self) -> Collectible:
        """The object that the navigation instruction names."""
        return self.street[0]


@dataclass(frozen=True, slots=True)
class Episode:
    """One episode of the task.

    Attributes:
        episode_id: unique in its split; the release's `mapId`.
        section: of the city.
        start: where turn 1 begins.
        turns: both.
        decoys: what stands in the room when the first assembly phase begins.
        instructions: for each language code the texts of both turns.
    """

    episode_id: str
    section: str
    start: Pose
    turns: tuple[Turn, Turn]
    decoys: tuple[PlacedObject, ...]
    instructions: Mapping[str, tuple[Instructions, Instructions]]

    def __post_init__(self) -> None:
        if not self.instructions:
            raise ValueError("there are no instructions in any language")

    @property
    def layout(self) -> Layout:
        """What the rules need to know."""
        return Layout(self.start, tuple(turn.street for turn in self.turns), self.decoys)

    def instruction(self, language: str, turn: int, phase: str) -> str:
        """The text of a phase ("navigation" or "assembly") of turn 1 or 2."""
        text: str = getattr(self.instructions[language][turn - 1], phase)
        return text


def with_languages(episode: Episode, more: Mapping[str, tuple[Instructions, Instructions]]) -> Episode:
    """The episode with the instructions of further languages, in the order of their codes."""
    merged = {**episode.instructions, **more}
    return replace(episode, instructions=dict(sorted(merged.items())))


def languages_of(episodes: Iterable[Episode]) -> dict[str, int]:
    """How many of the episodes hold instructions in each language."""
    counts: dict[str, int] = {}
    for episode in episodes:
        for language in episode.instructions:
            counts[language] = counts.get(language, 0) + 1
    return dict(sorted(counts.items()))
