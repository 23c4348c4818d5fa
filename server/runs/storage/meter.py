"""Measurement hooks for the engine and the journal, which do nothing by default."""

from enum import Enum


class Stage(Enum):
    """Stages of a step that are timed."""

    QUEUE = "queue"
    """From the arrival of an action until the engine handles it."""

    RULES = "rules"
    """Application of all actions of a round by the rules."""

    COMMIT = "commit"
    """Commit of a round to the journal."""

    DRAW = "draw"
    """Drawing of one frame."""

    ENCODE = "encode"
    """Encoding of one delivery: its messages and images."""

    TOTAL = "total"
    """From the arrival of an action until everything that follows from it was delivered to its stream."""


class Meter:
    """Hooks that do nothing; subclasses measure. Hooks that are called with every step must be cheap."""

    def run_created(self) -> None:
        """Count a created run."""

    def run_ended(self, state: str) -> None:
        """Count a run that ended in a state, one of those in `records`."""

    def episode_ended(self, cause: str) -> None:
        """Count an episode that ended by a cause, one of those in `causes`."""

    def count_reoffers(self, episodes: int) -> None:
        """Count episodes that were offered again because their process had died."""

    def count_steps(self, steps: int) -> None:
        """Count committed steps."""

    def record_duration(self, stage: Stage, seconds: float) -> None:
        """Record the duration of a stage, in seconds."""

    def count_fault(self, kind: str) -> None:
        """Count a server fault; `kind` is the name of the error class."""

    def record_load(self, streams: int, episodes: int, waiting: int) -> None:
        """Record the numbers of open streams, of open episodes, and of queued messages."""


NO_METER = Meter()
