"""Specifications of the data set's splits: sections, sizes and episode ids."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from arramon_server.episodes.epoch_statement import epoch_split_name, parse_epoch_name
from arramon_server.errors import BadInput, quoted

IDS_PER_SECTION, FIRST_ID = 10_000, 5_000
"""Ids of section 1 start at 5000, those of section 2 at 15000, and so on: ranges like the original's."""


@dataclass(frozen=True, slots=True)
class SplitSpec:
    """The specification of a split to generate.

    Attributes:
        name: for example "val_seen".
        sections: ids of the sections, to which episodes are assigned in rotation.
        size: number of episodes at full scale (paper, section 4).
        hidden: whether targets, goals and paths must never leave the server. The host's secret seeds a hidden split.
        slots: the ids of a section that belong to this split, out of every `period` ids; splits in the same sections
            have different slots.
        period: see `slots`.
        training: whether the split is for training only, so that runs on it are not ranked.
    """

    name: str
    sections: tuple[str, ...]
    size: int
    hidden: bool
    slots: tuple[int, ...] = (0,)
    period: int = 1
    training: bool = False

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
        SplitSpec("train", _SEEN, 4267, hidden=False, slots=(0, 1, 3, 4), period=5),
        SplitSpec("val_seen", _SEEN, 1065, hidden=False, slots=(2,), period=5),
        SplitSpec("val_unseen", ("6",), 1155, hidden=False),
        SplitSpec("test_unseen", ("7",), 1205, hidden=True),
    )
}
"""Specifications by split name; the sizes are the paper's."""

EXTRA = "train_extra"
"""The training split in sections with random street plans."""

FIRST_EXTRA, MAX_EXTRA = 101, 1000
"""Id of the first section of `train_extra`, and its maximum number of sections."""

EXTRA_PER_SECTION = 853
"""Episodes in each section of `train_extra` at full scale, as many as in `train`."""


def extra_spec(sections: int) -> SplitSpec:
    """Return the specification of `train_extra` with the given number of sections.

    Raises:
        BadInput: if the number is out of range.
    """
    if not 1 <= sections <= MAX_EXTRA:
        raise BadInput(f"the number of sections is {sections}; expected 1 to {MAX_EXTRA}")
    ids = tuple(str(FIRST_EXTRA + number) for number in range(sections))
    return SplitSpec(EXTRA, ids, EXTRA_PER_SECTION * sections, hidden=False, training=True)


def epoch_spec(base: str, number: int) -> SplitSpec:
    """Return the specification of an epoch of a hidden split.

    Args:
        base: name of the hidden split.
        number: of the epoch, from 1.

    Raises:
        BadInput: if there is no hidden split of that name.
    """
    hidden = [name for name, plan in SPLITS.items() if plan.hidden]
    if base not in hidden:
        raise BadInput(f"there are no epochs of {quoted(base)}: expected a hidden split, {', '.join(hidden)}")
    return replace(SPLITS[base], name=epoch_split_name(base, number))


def select_specs(names: list[str] | None, sections: int | None = None) -> list[SplitSpec]:
    """Return the specifications of the named splits, or of the paper's four for None.

    Args:
        names: of splits, and of epochs of hidden ones.
        sections: number of sections of `train_extra`.

    Raises:
        BadInput: if a name is unknown, or the number of sections is missing, out of range, or given without need.
    """
    epochs = {name: epoch_spec(*found) for name in names or () if (found := parse_epoch_name(name))}
    for name in names or ():
        if name not in (*SPLITS, EXTRA, *epochs):
            raise BadInput(f"there is no split {name!r}; there are {', '.join((*SPLITS, EXTRA))}")
    wants_extra = EXTRA in (names or ())
    if wants_extra and sections is None:
        raise BadInput(f"the split {EXTRA!r} needs a number of sections: give it with --sections")
    if sections is not None and not wants_extra:
        raise BadInput(f"--sections applies to the split {EXTRA!r} only; expected --split {EXTRA}")
    extra = [] if sections is None else [extra_spec(sections)]
    own = [plan for name, plan in SPLITS.items() if not names or name in names]
    return [*own, *epochs.values(), *extra]
