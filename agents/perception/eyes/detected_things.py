"""Things detected in frames, with the attribute probabilities that the naming network predicts."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import torch

from arramon_agents.perception.eyes.depth_segmentation import FrameThing, crop, find_things
from arramon_agents.perception.eyes.naming_network import NamingNetwork, to_network
from arramon_agents.perception.eyes.network import Predictions, probabilities
from arramon_agents.perception.eyes.reach import Reach

Floats = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class DetectedThing:
    """A thing detected in a frame, with attribute probabilities.

    Attributes:
        thing: the thing in the frame.
        kinds: probabilities, indexed as `vocabulary.KINDS`.
        colours: probabilities, indexed as `vocabulary.COLOURS`, given that it has a colour.
        looks: probabilities, indexed as `vocabulary.LOOKS`, which sum to 1 within each group; those of walls and
            facades are meaningless.
    """

    thing: FrameThing
    kinds: Floats
    colours: Floats
    looks: Floats

    @cached_property
    def kind(self) -> int:
        """The most likely kind, an index of `vocabulary.KINDS`."""
        return int(self.kinds.argmax())


def find_and_name_things(
    network: NamingNetwork, rgb: npt.NDArray[np.uint8], depth: Floats, reach: Reach
) -> list[list[DetectedThing]]:
    """Return the things detected in each frame, the nearest first.

    Args:
        network: trained network, in evaluation mode.
        rgb: (B, size, size, 3) uint8.
        depth: (B, size, size) units.
        reach: which things are cut out.
    """
    things = [find_things(each, reach) for each in depth]
    crops = [crop(rgb[number], depth[number], thing) for number, some in enumerate(things) for thing in some]
    if not crops:
        return [[] for _ in things]
    measures = torch.tensor([thing.measures for some in things for thing in some])
    with torch.inference_mode():
        logits = network(to_network(np.stack(crops)), measures)
        found = probabilities(Predictions(logits))
    names = zip(*(part.numpy() for part in found), strict=True)
    return [[DetectedThing(thing, *next(names)) for thing in some] for some in things]
