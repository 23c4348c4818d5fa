"""The splits of the data set: which sections, how many episodes, and their ids."""

from collections.abc import Iterator
from dataclasses import dataclass

from server.errors import BadInput

IDS_PER_SECTION, FIRST_ID = 10_000, 5_000
"""Section 1 has the ids from 5000, section 2 from 15000, and so on: ranges like the original's."""


@dataclass(frozen=True, slots=True)
class SplitPlan:
    """What a split is to hold.

    Attributes:
        name: such as "val_seen".
        sections: ids; episodes go round them in turn.
        size: episodes in the whole split (paper, section 4).
        hidden: whether targets, goals and paths must never leave the server. It is drawn from the host's secret.
        slots: which of every `period` ids of a section are this split's, so that splits that share sections share none.
        period: see `slots`.
    """

    name: str
    sections: tuple[str, ...]
    size: int
    hidden: bool
    slots: tuple[int, ...] = (0,)
    period: int = 1

    def count(self, scale: float) -> int:
        """How many episodes there are at a scale: at least one.

        Raises:
            BadInput: unless 0 < scale <= 1.
        """
        if not 0.0 < scale <= 1.0:
            raise BadInput(f"the scale is {scale}, expected more than 0 and at most 1")
        return max(1, round(self.size * scale))

    def episodes(self, scale: float = 1.0) -> Iterator[tuple[str, str]]:
        """(episode id, section) of each episode. A smaller scale gives the first of a larger one's."""
        for i in range(self.count(scale)):
            section = self.sections[i % len(self.sections)]
            turn = i // len(self.sections)
            slot = self.period * (turn // len(self.slots)) + self.slots[turn % len(self.slots)]
            yield str(FIRST_ID + IDS_PER_SECTION * (int(section) - 1) + _ID_STEP * slot), section


_ID_STEP = 8

_SEEN = ("1", "2", "3", "4", "5")

SPLITS = {
    plan.name: plan
    for plan in (
        SplitPlan("train", _SEEN, 4267, hidden=False, slots=(0, 1, 3, 4), period=5),
        SplitPlan("val_seen", _SEEN, 1065, hidden=False, slots=(2,), period=5),
        SplitPlan("val_unseen", ("6",), 1155, hidden=False),
        SplitPlan("test_unseen", ("7",), 1205, hidden=True),
    )
}
"""By name; the sizes are the paper's."""


def chosen(names: list[str] | None) -> list[SplitPlan]:
    """The splits of these names, all of them for None.

    Raises:
        BadInput: for an unknown name.
    """
    for name in names or ():
        if name not in SPLITS:
            raise BadInput(f"there is no split {name!r}; there are {', '.join(SPLITS)}")
    return [plan for name, plan in SPLITS.items() if not names or name in names]
