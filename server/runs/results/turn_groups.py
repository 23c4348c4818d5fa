"""Groups of a split's turns by ground truth and by the meaning of their instructions."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
import numpy.typing as npt

from arramon_client.world import Action
from arramon_server.episodes.demands import TurnDemands
from arramon_server.episodes.episode import Turn
from arramon_server.episodes.splits import Split
from arramon_server.scoring.disclosure import PublishedSums

Mask = npt.NDArray[np.bool_]

ASPECTS = ("turn", "length", "corners", "object", "steps", "landmarks", "step", "landmark", "relation", "placement")
"""Aspects by which turns are grouped.

turn: the first or the second; length: moves forward on the ground truth; corners: changes of direction on it by 60
degrees or more; object: whether the target's kind, colour and pattern is that of a target of the split TRAIN ("seen")
or not ("unseen"); steps: number of steps in the navigation instruction; landmarks: number of different things that it
names; step, landmark, relation: the kinds that it contains; placement: relations in the assembly instruction.
"""

COUNTED = {"length": 5, "corners": 1, "steps": 1, "landmarks": 1}
"""Aspects that are numbers -> the step to which the ends of their groups are rounded."""

TRAIN = "train"

_RANGES = 3
"""Number of groups of about equal size for a numeric aspect."""


@dataclass(frozen=True, eq=False, slots=True)
class TurnGroup:
    """A group of turns.

    Attributes:
        aspect: one of ASPECTS.
        name: common property of the turns; empty for a range of numbers.
        low, high: the numbers, both included; high is None for the last group. Both are 0 if there is a name.
        turns: the turns in the group, (episodes, 2), in the order of `TurnGrouping.ids`.
    """

    aspect: str
    name: str
    low: int
    high: int | None
    turns: Mask

    @property
    def names(self) -> tuple[str, ...]:
        """Fields that identify the group in a split and language."""
        return self.aspect, self.name, str(self.low), "" if self.high is None else str(self.high)


@dataclass(frozen=True, eq=False, slots=True)
class TurnGrouping:
    """The groups of a split's turns in one language that can be shown.

    Attributes:
        ids: ids of the episodes, sorted.
        groups: groups in the order of ASPECTS.
        withheld: number of groups that are left out, as together with the others they would reveal few episodes.
        knows_demands: whether it is known what the instructions ask for.
    """

    ids: tuple[str, ...]
    groups: tuple[TurnGroup, ...]
    withheld: int
    knows_demands: bool


def group_turns(split: Split, language: str, train: Split | None) -> TurnGrouping:
    """Return the groups of a split's turns. On a hidden split, those that `PublishedSums` admits, in order.

    Args:
        split: the split.
        language: code of the language whose episodes are grouped.
        train: the training split; None if it is missing, which leaves out the groups by seen and unseen objects.
    """
    ids = tuple(sorted(name for name, episode in split.episodes.items() if language in episode.instructions))
    knows_demands = all(name in split.demands for name in ids)
    found = [group for group in _groups(split, ids, train, knows_demands=knows_demands) if group.turns.any()]
    if not split.hidden:
        return TurnGrouping(ids, tuple(found), 0, knows_demands)
    published = PublishedSums(len(ids))
    admitted = tuple(group for group in found if published.admit(group.turns))
    return TurnGrouping(ids, admitted, len(found) - len(admitted), knows_demands)


def _groups(split: Split, ids: Sequence[str], train: Split | None, *, knows_demands: bool) -> Iterator[TurnGroup]:
    turns = [split.episodes[name].turns for name in ids]
    places = np.broadcast_to(np.arange(2), (len(ids), 2))
    yield TurnGroup("turn", "first", 0, 0, places == 0)
    yield TurnGroup("turn", "second", 0, 0, places == 1)
    yield from _by_number("length", [[len(turn.path) - 1 for turn in pair] for pair in turns])
    yield from _by_number("corners", [[_corners(turn) for turn in pair] for pair in turns])
    if train is not None and train is not split:
        known = {turn.target.type for episode in train.episodes.values() for turn in episode.turns}
        seen = np.array([[turn.target.type in known for turn in pair] for pair in turns]).reshape(-1, 2)
        yield TurnGroup("object", "seen", 0, 0, seen)
        yield TurnGroup("object", "unseen", 0, 0, ~seen)
    if knows_demands:
        yield from _by_demands([split.demands[name] for name in ids])


def _by_demands(demands: Sequence[Sequence[TurnDemands]]) -> Iterator[TurnGroup]:
    yield from _by_number("steps", [[len(turn.steps) for turn in pair] for pair in demands])
    yield from _by_number("landmarks", [[len(turn.landmarks) for turn in pair] for pair in demands])
    kinds: dict[str, Callable[[TurnDemands], Iterable[str]]] = {
        "step": lambda turn: turn.steps,
        "landmark": lambda turn: turn.landmarks,
        "relation": lambda turn: turn.relations,
        "placement": lambda turn: turn.placements,
    }
    for aspect, of in kinds.items():
        sizes: dict[str, int] = {}
        for turn in (turn for pair in demands for turn in pair):
            for name in set(of(turn)):
                sizes[name] = sizes.get(name, 0) + 1
        for name in sorted(sizes, key=lambda name: (-sizes[name], name)):
            yield TurnGroup(aspect, name, 0, 0, np.array([[name in of(turn) for turn in pair] for pair in demands]))


def _by_number(aspect: str, values: Sequence[Sequence[int]]) -> Iterator[TurnGroup]:
    """Yield groups of about equal size by a number, with round limits."""
    numbers, step = np.array(values).reshape(-1, 2), COUNTED[aspect]
    shares = [part / _RANGES for part in range(1, _RANGES)]
    ends = sorted({round(end / step) * step for end in np.quantile(numbers, shares)} if numbers.size else set())
    low = 0
    for end in ends:
        yield TurnGroup(aspect, "", low, end, (numbers >= low) & (numbers <= end))
        low = end + 1
    yield TurnGroup(aspect, "", low, None, numbers >= low)


def _corners(turn: Turn) -> int:
    """Return the number of changes of direction by 60 degrees or more, two turn actions, on the ground truth."""
    signs = {Action.LEFT: -1, Action.RIGHT: 1}
    runs = (sum(signs.get(action, 0) for action in run) for _, run in groupby(turn.actions, lambda a: a in signs))
    return sum(abs(net) >= 2 for net in runs)
