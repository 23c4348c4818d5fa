"""Where a training reads and writes."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

Report = Callable[[str], None]
"""Receives lines of progress."""


@dataclass(frozen=True)
class Workspace:
    """Where training reads and writes; nothing of it changes the outcome.

    Attributes:
        data: the data folder.
        cache: folder of the drawn demonstrations.
        output: folder of checkpoints, logs and weights.
        processes: number of processes that draw demonstrations.
        checkpoint_steps: updates between two checkpoints.
        device: of torch, for agents that are trained on another one than the processor.
    """

    data: Path
    cache: Path
    output: Path
    processes: int = 1
    checkpoint_steps: int = 100
    device: str = "cpu"
