"""Training recipe of `vl_map`."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class MapRecipe:
    """All settings of a training.

    Attributes:
        languages: in which instructions are read.
        episodes: of each split, the first ones in playing order; 0 for all.
        walks: of each episode, along its paths.
        rounds: number of rounds in which the policy walks by itself, evenly spaced after `first` of all steps.
        round_walks: share of all episodes that a round plays, drawn anew.
        first: share of the steps before the first round of its own walks.
        passes: through the decisions of the walks along paths.
        again: passes through all decisions after that, with those of a last round, and a learning rate that starts anew
            at half of the highest; 0 for none of this.
        batch: decisions of a step.
        learning_rate: the highest.
        precision: "float32", or "bfloat16", which takes two thirds of the time on a processor that has it.
        seed: of everything.
        validate: split for validation at the end.
        validate_episodes: number of its first episodes to play; 0 for none.
    """

    languages: tuple[str, ...] = ("en", "hi")
    episodes: int = 0
    walks: int = 1
    rounds: int = 2
    round_walks: float = 0.25
    first: float = 0.35
    passes: int = 14
    again: int = 0
    batch: int = 32
    learning_rate: float = 2e-3
    precision: str = "bfloat16"
    seed: int = 1
    validate: str = "val_seen"
    validate_episodes: int = 16


RECIPES = {"vl_map": MapRecipe()}


def smoke(recipe: MapRecipe) -> MapRecipe:
    """Return a recipe for smoke tests, which takes seconds and learns next to nothing."""
    return replace(recipe, episodes=2, walks=1, rounds=1, passes=2, again=1, batch=8, validate_episodes=1)
