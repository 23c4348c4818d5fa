"""Training recipe of `vl_grounded`."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class GroundedRecipe:
    """All settings of a training.

    Attributes:
        languages: in which instructions are read.
        split, every, episodes, init: as in `arramon_agents.vl.recipe.Recipe`. With `train`,
            `train_extra` is learned from as well if the data folder has it.
        rooms: number of generated tasks in the room alone, besides.
        versions, room_versions: number of variants of each walk's and each room's instruction, with other things.
        passes: number of passes over the walks.
        batch: number of walks in a step; twice as many rooms.
        learning_rate: the highest.
        inflection: weight of the steps at which the expert's action changes; the others have 1.
        seed: of everything.
        validate: split for validation at the end.
        validate_episodes: number of its first episodes to play; 0 for none.
    """

    languages: tuple[str, ...] = ("en", "hi")
    split: str = "train"
    every: int = 1
    episodes: int = 0
    init: str = ""
    rooms: int = 600
    versions: int = 2
    room_versions: int = 1
    passes: int = 24
    batch: int = 32
    learning_rate: float = 2e-3
    inflection: float = 2.5
    seed: int = 1
    validate: str = "val_seen"
    validate_episodes: int = 20


RECIPES = {"vl_grounded": GroundedRecipe()}


def smoke(recipe: GroundedRecipe) -> GroundedRecipe:
    """Return a recipe for smoke tests, which takes seconds and learns next to nothing."""
    return replace(recipe, episodes=4, rooms=0, versions=1, passes=2, batch=4, validate_episodes=1)
