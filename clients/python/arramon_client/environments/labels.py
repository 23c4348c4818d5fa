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
    names, numbers = [], []
    for part in zip(*((label.kind, label.colour, label.look) for label in labels), strict=True):
        known = sorted({"", *part})
        names.append(tuple(known))
        numbers.append(np.array([known.index(name) for name in part], np.int16))
    if not labels:
        names, numbers = [("",)] * 3, [np.zeros(0, np.int16)] * 3
    return FactoredLabels(*names, *numbers)
