"""Training recipe of the visual encoder."""

from dataclasses import dataclass, replace

from arramon_agents.perception.eyes.reach import REACHES

NETWORKS = ("blocks", "naming")
"""The encoder's two networks."""


@dataclass(frozen=True)
class EyesRecipe:
    """All training settings. Field names are command-line options.

    Attributes:
        frames: number of training frames of the block network; each is used once.
        naming_frames: number of training frames of the naming network; each is used once.
        size: side length of the frames, in pixels.
        cities: number of cities to generate from the plans of the training sections.
        seed: seed of frames and initial weights.
        only: name of the only network to train; empty for both.
        keep: file of weights from which the other network is taken; empty for the one trained before in the output
            folder. Only with `only`.
        reach: which things are cut out to be named: "near", or "far" for agents that keep a map.
    """

    frames: int = 60_000
    naming_frames: int = 60_000
    size: int = 224
    cities: int = 4
    seed: int = 0
    only: str = ""
    keep: str = ""
    reach: str = "near"

    def __post_init__(self) -> None:
        if self.only not in ("", *NETWORKS):
            raise ValueError(f"there is no network {self.only!r}; there are {', '.join(NETWORKS)}")
        if self.reach not in REACHES:
            raise ValueError(f"there is no reach {self.reach!r}; there are {', '.join(REACHES)}")
        if self.keep and not self.only:
            raise ValueError(f"keep is {self.keep!r}, but both networks are trained: name one of them in only")


RECIPES = {"eyes": EyesRecipe()}


def smoke(recipe: EyesRecipe) -> EyesRecipe:
    """Return a recipe for smoke tests, which takes seconds and learns next to nothing."""
    return replace(recipe, frames=16, naming_frames=24, cities=1)
