"""Folders, processes and device of a training: settings that do not change its result."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

Report = Callable[[str], None]
"""Receives lines of progress."""

CHECKPOINT_STEPS = 100
"""Default number of updates between two checkpoints."""


@dataclass(frozen=True)
class Workspace:
    """Folders, processes and device of a training; none of them changes its result.

    Attributes:
        data: data folder.
        cache: cache folder of rendered demonstrations.
        output: folder of checkpoints, logs and weights.
        processes: number of processes that render demonstrations.
        checkpoint_steps: updates between two checkpoints.
        device: torch device; only some trainings can use another one than the CPU.
    """

    data: Path
    cache: Path
    output: Path
    processes: int = 1
    checkpoint_steps: int = CHECKPOINT_STEPS
    device: str = "cpu"
