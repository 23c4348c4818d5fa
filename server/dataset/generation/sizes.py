"""The splits of the data set: their sections, sizes and episode ids."""

from collections.abc import Iterator
from dataclasses import dataclass

from server.errors import BadInput

IDS_PER_SECTION, FIRST_ID = 10_000, 5_000
"""Ids of section 1 start at 5000, those of section 2 at 15000, and so on: ranges like the original's."""


@dataclass(frozen=True, slots=True)
class SplitPlan:
    """The specification of a split to generate.

    Attributes:
        name: such as "val_seen".
        sections: ids; episodes are assigned to them in turn.
        size: number of episodes at full scale (paper, section 4).
        hidden: whether targets, goals and paths must never leave the server. A hidden split is seeded by the host's
            secret.
        slots: which of every `period` ids of a section belong to this split, so that splits in the same sections share
            none.
        period: see `slots`.
    """

    name: str
    sections: tuple[str, ...]
    size: int
    hidden: bool
    slots: tuple[int, ...] = (0,)
    period: int = 1

    def count(self, scale: float) -> int:
        """Return the number of episodes at a scale, at least one.

        Raises:
            BadInput: unless 0 < scale <= 1.
        """
        if not 0.0 < scale <= 1.0:
            raise BadInput(f"the scale is {scale}; expected more than 0 and at most 1")
        return max(1, round(self.size * scale))

    def episodes(self, scale: float = 1.0) -> Iterator[tuple[str, str]]:
        """Yield (episode id, section) of each episode. A smaller scale yields a prefix of a larger one."""
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
"""Specifications by split name; the sizes are the paper's."""


def select_plans(names: list[str] | None) -> list[SplitPlan]:
    """Return the specifications of the named splits, or of all splits for None.

    Raises:
        BadInput: if a name is unknown.
    """
    for name in names or ():
        if name not in SPLITS:
            raise BadInput(f"there is no split {name!r}; there are {', '.join(SPLITS)}")
    return [plan for name, plan in SPLITS.items() if not names or name in names]
