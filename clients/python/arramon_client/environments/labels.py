"""Segmentation labels as arrays of numbers for kind, colour and look, for example to index embeddings."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from arramon_client.agent import Label

Numbers = npt.NDArray[np.int16]


@dataclass(frozen=True, eq=False)
class FactoredLabels:
    """Segmentation labels split into factors: `factored.kind[segmentation]` is the number of each pixel's kind.

    Attributes:
        kinds, colours, looks: names by number, sorted; number 0 is "", for labels without one.
        kind, colour, look: (labels,) int16, the number of each label's kind, colour and look.
    """

    kinds: tuple[str, ...]
    colours: tuple[str, ...]
    looks: tuple[str, ...]
    kind: Numbers
    colour: Numbers
    look: Numbers

    @property
    def table(self) -> Numbers:
        """Kind, colour and look of each label, (labels, 3) int16; index it with a segmentation."""
        return np.stack((self.kind, self.colour, self.look), axis=1)


def factored(labels: Sequence[Label]) -> FactoredLabels:
    """Return labels, such as `env.unwrapped.labels` or `Episode.labels`, as arrays; they are empty without labels."""
    kinds, kind = _numbered([label.kind for label in labels])
    colours, colour = _numbered([label.colour for label in labels])
    looks, look = _numbered([label.look for label in labels])
    return FactoredLabels(kinds, colours, looks, kind, colour, look)


def _numbered(names: Sequence[str]) -> tuple[tuple[str, ...], Numbers]:
    """Return the distinct names and "", sorted, and the index of each given name among them."""
    known = sorted({"", *names})
    return tuple(known), np.array([known.index(name) for name in names], np.int16)
