"""Training recipe of `vl_grounded`."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class GroundedRecipe:
    """All training settings. Field names are command-line options and keys in files of weights.

    Attributes:
        languages: languages of the instructions.
        split: training split; with `train`, `train_extra` is used too if the data folder has it.
        every: take every n-th episode in playing order, from the n-th on, and leave the others for testing; 1 for all.
        episodes: number of these episodes, the first ones; 0 for all.
        init: weights to fine-tune, a file, or a folder with one named after the agent; empty for random weights. New
            words are added to a vocabulary of words.
        rooms: number of additional generated tasks in the assembly room.
        versions, room_versions: number of augmented instructions per walk and per room, in which things are exchanged.
        passes: number of epochs of the walks.
        batch: number of walks in a batch; it has twice as many rooms.
        learning_rate: peak learning rate.
        inflection: loss weight of the steps at which the expert's action changes; the others have weight 1.
        seed: seed of all random choices.
        validate: split for validation at the end.
        validate_episodes: number of episodes to validate on, the first in playing order; 0 for none.
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
