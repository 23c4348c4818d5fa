"""Things detected in frames, with the attribute probabilities that the naming network predicts."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import torch

from arramon_agents.perception.eyes.depth_segmentation import FrameParts, FrameThing, crop, find_parts
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


class NamedParts(NamedTuple):
    """The parts of a frame, with names.

    Attributes:
        things: the detected things, those of `parts` in the same order.
        parts: what the names are of.
    """

    things: list[DetectedThing]
    parts: FrameParts


def find_and_name_parts(
    network: NamingNetwork, rgb: npt.NDArray[np.uint8], depth: Floats, reach: Reach
) -> list[NamedParts]:
    """Return what is cut out of each frame.

    Args:
        network: trained network, in evaluation mode.
        rgb: (B, size, size, 3) uint8.
        depth: (B, size, size) units.
        reach: which things are cut out.
    """
    parts = [find_parts(each, reach) for each in depth]
    crops = [crop(rgb[number], depth[number], thing) for number, part in enumerate(parts) for thing in part.things]
    if not crops:
        return [NamedParts([], part) for part in parts]
    measures = torch.tensor([thing.measures for part in parts for thing in part.things])
    with torch.inference_mode():
        logits = network(to_network(np.stack(crops)), measures)
        found = probabilities(Predictions(logits))
    names = zip(*(part.numpy() for part in found), strict=True)
    return [NamedParts([DetectedThing(thing, *next(names)) for thing in part.things], part) for part in parts]
