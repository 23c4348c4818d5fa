"""Training recipe of `vl_map`."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class MapRecipe:
    """All training settings. Field names are command-line options and keys in files of weights.

    Attributes:
        languages: languages of the instructions.
        episodes: number of episodes of each split, the first in playing order; 0 for all.
        walks: number of simulated walks along the paths of each episode.
        rounds: number of DAgger rounds, spread evenly over the updates after `first`.
        rendered: number of DAgger rounds, the last ones, that walk in rendered streets and see them with the visual
            encoder; the others walk without images, with simulated errors of perception.
        round_walks: share of all episodes that a round plays, drawn anew for each round.
        first: share of the updates before the first DAgger round.
        passes: number of epochs, counted in decisions of the walks along paths.
        again: number of epochs of a second training on all decisions after one more round, with a new learning-rate
            schedule at half the peak; 0 for none.
        batch: number of decisions in a batch.
        learning_rate: peak learning rate.
        width: embedding size of the policy's tokens, a multiple of 16; the other sizes of a layer grow with it.
        layers: number of transformer layers of the policy.
        precision: "float32", or "bfloat16", which takes two thirds of the time on CPUs that support it.
        seed: seed of all random choices.
        join: files of weights of this agent, separated by commas, whose policies the new file has too; empty for none.
            The agent averages all policies of its file.
        validate: split for validation at the end.
        validate_episodes: number of episodes to validate on, the first in playing order; 0 for none.
    """

    languages: tuple[str, ...] = ("en", "hi")
    episodes: int = 0
    walks: int = 1
    rounds: int = 2
    rendered: int = 0
    round_walks: float = 0.25
    first: float = 0.35
    passes: int = 14
    again: int = 0
    batch: int = 32
    learning_rate: float = 2e-3
    width: int = 64
    layers: int = 3
    precision: str = "bfloat16"
    seed: int = 1
    join: str = ""
    validate: str = "val_seen"
    validate_episodes: int = 16


RECIPES = {"vl_map": MapRecipe()}


def smoke(recipe: MapRecipe) -> MapRecipe:
    """Return a recipe for smoke tests, which takes seconds and learns next to nothing."""
    return replace(recipe, episodes=2, walks=1, rounds=1, rendered=0, passes=2, again=1, batch=8, validate_episodes=1)
