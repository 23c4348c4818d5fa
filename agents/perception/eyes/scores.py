"""Evaluation of the encoder against the simulator's labels: F1 of each channel, and accuracy of collectibles' names."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from arramon_agents.perception.encoder import GRID
from arramon_agents.perception.eyes.detected_things import DetectedThing
from arramon_agents.perception.eyes.grid import CHANNEL_NAMES, GROUND
from arramon_agents.perception.eyes.vocabulary import COLOURS, KINDS, LOOK_GROUPS, look_slices
from arramon_client.world import COLLECTIBLES, FURNITURE

MIN_LABEL_PIXELS = 16
"""Minimum number of pixels that show a label for it to be in a cell; a cell has 1,024 pixels at image size 224."""

NEARNESS = ("nearness of collectible", "nearness", "mean nearness")
"""Channels that hold distances."""


@dataclass(slots=True)
class Counts:
    """Numbers of true positive, false positive and false negative cells of a channel."""

    hits: int = 0
    false: int = 0
    missed: int = 0

    @property
    def f1(self) -> float:
        """F1 in [0, 1]; NaN if there are no cells."""
        cells = 2 * self.hits + self.false + self.missed
        return 2 * self.hits / cells if cells else float("nan")


@dataclass(slots=True)
class GridScores:
    """Counts by channel, over all added frames.

    Args:
        labels: (kind, colour, look) of each label, by index.
    """

    labels: Sequence[tuple[str, str, str]]
    counts: dict[str, Counts] = field(default_factory=dict)

    def add(self, features: npt.NDArray[np.float32], segmentation: npt.NDArray[np.uint16]) -> None:
        """Add a frame.

        Args:
            features: (7, 7, C) of the encoder.
            segmentation: (size, size) numbers of labels.
        """
        shown = cells_showing(segmentation, len(self.labels))
        least = MIN_LABEL_PIXELS * (len(segmentation) / 224.0) ** 2
        truth = (shown @ channels_of(self.labels)) >= least
        said = features >= 0.5
        for number, name in enumerate(CHANNEL_NAMES):
            if name in NEARNESS:
                continue
            counts = self.counts.setdefault(name, Counts())
            counts.hits += int((truth[..., number] & said[..., number]).sum())
            counts.false += int((~truth[..., number] & said[..., number]).sum())
            counts.missed += int((truth[..., number] & ~said[..., number]).sum())

    def groups(self) -> dict[str, float]:
        """Return the mean F1 of each group of channels, such as "kind", over channels that occur in the frames."""
        by_group: dict[str, list[float]] = {}
        for name, counts in self.counts.items():
            if counts.hits + counts.missed:
                by_group.setdefault(name.partition(":")[0], []).append(counts.f1)
        return {group: sum(values) / len(values) for group, values in by_group.items()}


PIXEL_RANGES = ((45, 100), (100, 400), (400, 1 << 30))
"""Ranges of a collectible's number of pixels; people recognise collectibles from 45 pixels on."""


@dataclass(slots=True)
class NameScores:
    """Accuracy of the names of collectibles, by their number of pixels.

    Args:
        labels: (kind, colour, look) of each label, by index.

    Attributes:
        counts: by range of pixels, the numbers of collectibles: all, cut out, with correct kind, colour, pattern, all
            three.
        false: number of other things named as collectibles.
    """

    labels: Sequence[tuple[str, str, str]]
    counts: dict[tuple[int, int], npt.NDArray[np.int64]] = field(default_factory=dict)
    false: int = 0

    def add(self, things: Sequence[DetectedThing], segmentation: npt.NDArray[np.uint16]) -> None:
        """Add a frame."""
        found: dict[int, tuple[int, DetectedThing]] = {}
        for named in things:
            pixels = segmentation[named.thing.rows, named.thing.columns][named.thing.mask]
            numbers, counts = np.unique(pixels, return_counts=True)
            number, most = int(numbers[counts.argmax()]), int(counts.max())
            if self.labels[number][0] in COLLECTIBLES:
                if most > found.get(number, (0, None))[0]:
                    found[number] = most, named
            elif KINDS[int(named.kinds.argmax())] in COLLECTIBLES:
                self.false += 1
        for number, count in zip(*np.unique(segmentation, return_counts=True), strict=True):
            bounds = next((bounds for bounds in PIXEL_RANGES if bounds[0] <= count < bounds[1]), None)
            if self.labels[number][0] in COLLECTIBLES and bounds is not None:
                said = self._right(number, found[number][1]) if number in found else (False,) * 3
                row = np.array([1, number in found, *said, all(said)], np.int64)
                self.counts[bounds] = self.counts.get(bounds, np.zeros_like(row)) + row

    def shares(self) -> dict[str, dict[str, float]]:
        """Return by range of pixels the shares cut out, and with correct kind, colour, pattern, all three."""
        names = ("found", "kind", "colour", "pattern", "all")
        return {
            f"{low} to {high - 1} pixels" if high < PIXEL_RANGES[-1][1] else f"{low} pixels and more": {
                "count": int(row[0]),
                **{name: round(float(value / row[0]), 3) for name, value in zip(names, row[1:], strict=True)},
            }
            for (low, high), row in sorted(self.counts.items())
        }

    def _right(self, number: int, named: DetectedThing) -> tuple[bool, bool, bool]:
        kind, colour, look = self.labels[number]
        return (
            KINDS[int(named.kinds.argmax())] == kind,
            COLOURS[int(named.colours.argmax())] == colour,
            LOOK_GROUPS[0].looks[int(named.looks[look_slices()["pattern"]].argmax())] == look,
        )


def cells_showing(segmentation: npt.NDArray[np.uint16], labels: int) -> npt.NDArray[np.int64]:
    """Return how many pixels of each cell show each label, (7, 7, labels)."""
    side = len(segmentation) // GRID
    cells = segmentation.reshape(GRID, side, GRID, side).transpose(0, 2, 1, 3).reshape(GRID * GRID, -1).astype(np.int64)
    numbers = cells + labels * np.arange(GRID * GRID)[:, None]
    return np.bincount(numbers.ravel(), minlength=GRID * GRID * labels).reshape(GRID, GRID, labels)


def channels_of(labels: Iterable[tuple[str, str, str]]) -> npt.NDArray[np.int64]:
    """Return which channels each label sets, (labels, C) of 0 and 1; a colour without a channel sets none."""
    listed = list(labels)
    label_channels = np.zeros((len(listed), len(CHANNEL_NAMES)), np.int64)
    for row, (kind, colour, look) in zip(label_channels, listed, strict=True):
        for name in _channels(kind, colour, look):
            if " colour:" not in name or name in CHANNEL_NAMES:
                row[CHANNEL_NAMES.index(name)] = 1
    return label_channels


def _channels(kind: str, colour: str, look: str) -> list[str]:
    if kind in COLLECTIBLES:
        return [f"kind:{kind}", f"colour:{colour}", f"pattern:{look}", "collectible"]
    if kind in GROUND:
        return ["ground"]
    if kind == "nothing":
        return ["sky"]
    names = ["start_tile"] if kind == "start_tile" else []
    if kind in FURNITURE:
        names.append(f"furniture:{kind}")
        if colour:
            names.append(f"{'banner' if kind == 'banner' else 'furniture'} colour:{colour}")
    names += [f"{group.name}:{look}" for group in LOOK_GROUPS[1:] if kind in group.kinds and look]
    return names
