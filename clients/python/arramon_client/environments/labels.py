"""Labels of a segmentation as arrays: kind, colour and look of every label by number, for learners."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from arramon_client.agent import Label

Numbers = npt.NDArray[np.int16]


@dataclass(frozen=True, eq=False)
class FactoredLabels:
    """Labels, factored: `factored.kind[segmentation]` is the kind of what each pixel shows, as a number.

    Attributes:
        kinds, colours, looks: names by number, sorted; "" is 0, for labels that have none.
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
        """All three, (labels, 3) int16: `factored.table[segmentation]` has a kind, a colour and a look a pixel."""
        return np.stack((self.kind, self.colour, self.look), axis=1)


def factored(labels: Sequence[Label]) -> FactoredLabels:
    """Return labels, such as `env.unwrapped.labels` or `Episode.labels`, as arrays; all are empty for no labels."""
    kinds, kind = _numbered([label.kind for label in labels])
    colours, colour = _numbered([label.colour for label in labels])
    looks, look = _numbered([label.look for label in labels])
    return FactoredLabels(kinds, colours, looks, kind, colour, look)


def _numbered(names: Sequence[str]) -> tuple[tuple[str, ...], Numbers]:
    """Return the distinct names, sorted, "" among them, and the number of each given one."""
    known = sorted({"", *names})
    return tuple(known), np.array([known.index(name) for name in names], np.int16)
