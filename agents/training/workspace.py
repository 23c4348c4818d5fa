"""Folders, processes and device of a training: settings that are not part of its recipe."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

Report = Callable[[str], None]
"""Receives lines of progress."""

CHECKPOINT_STEPS = 100
"""Default number of updates between two checkpoints."""


@dataclass(frozen=True)
class Workspace:
    """Folders, processes and device of a training. Only the device changes its result, by rounding.

    Attributes:
        data: data folder.
        cache: cache folder of rendered demonstrations.
        output: folder of checkpoints, logs and weights.
        processes: number of processes that render demonstrations and simulate walks.
        checkpoint_steps: updates between two checkpoints.
        device: torch device of the updates. Walks, rendering and validation are on the CPU.
    """

    data: Path
    cache: Path
    output: Path
    processes: int = 1
    checkpoint_steps: int = CHECKPOINT_STEPS
    device: str = "cpu"
