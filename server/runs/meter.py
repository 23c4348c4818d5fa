"""What the engine and the journal tell whoever measures. Nobody does, unless somebody is put in this one's place."""

from enum import Enum


class Stage(Enum):
    """Where the time of a step goes."""

    QUEUE = "queue"
    """From an answer's arrival until its turn."""

    RULES = "rules"
    """All answers of a round, by the rules."""

    COMMIT = "commit"
    """All that a round writes into the journal."""

    DRAW = "draw"
    """One frame."""

    ENCODE = "encode"
    """One delivery: its messages and images."""

    TOTAL = "total"
    """From an answer's arrival until its stream was told all that follows from it."""


class Meter:
    """Measures nothing. What is called with every step must be cheap."""

    def run_created(self) -> None:
        """A run was created."""

    def run_ended(self, state: str) -> None:
        """A run has ended in a state, one of `records`."""

    def episode_ended(self, cause: str) -> None:
        """An episode has ended by a cause, one of `causes`."""

    def reoffered(self, episodes: int) -> None:
        """Episodes were offered again, as their process had died."""

    def stepped(self, steps: int) -> None:
        """Steps were committed."""

    def took(self, stage: Stage, seconds: float) -> None:
        """A stage took so long."""

    def faulted(self, kind: str) -> None:
        """Something went wrong that no client can help: an error's class."""

    def loaded(self, streams: int, episodes: int, waiting: int) -> None:
        """So many streams and episodes are open now, and so many messages wait for their turn."""


NO_METER = Meter()
