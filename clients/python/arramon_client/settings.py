"""Settings of a play session."""

from dataclasses import dataclass
from pathlib import Path

from arramon.v1 import types_pb2
from arramon_client.errors import UsageError
from arramon_client.transport.retry import PATIENCE

RETRIES = 2
"""Default of `Settings.retries`."""

ON_FAILURE = ("stop", "give-up")
"""What can follow when an agent that waits fails."""


@dataclass(frozen=True)
class Settings:
    """Settings of a play session.

    Attributes:
        parallel: episodes to play in parallel.
        encoding: encoding of images.
        jpeg_quality: 1 to 100, with JPEG only; 0 for the server's default.
        image_size: side length of images in pixels; 0 for the server's first size.
        resume: take over the run's open episodes, and replay their histories to the agent.
        patience: seconds to keep reconnecting without receiving anything new from the server.
        keep_going: give up every episode in which the agent fails, however many. Otherwise the run stops if the agent
            fails before its first valid action, or in `failures.FAILURES_IN_A_ROW` episodes in a row.
        retries: how often a failed `act` of an agent that waits (`AsyncAgent`) is repeated for the same observation.
        on_failure: what follows when it still fails: "stop" the run, which can be resumed, or "give-up" the episode;
            None: "give-up" with `keep_going`, otherwise "stop". It does not concern other agents.
        output: folder of the run's results, which an agent that waits gets as `RunInfo.output`; None for none.
    """

    parallel: int
    encoding: types_pb2.Encoding.ValueType = types_pb2.ENCODING_UNSPECIFIED
    jpeg_quality: int = 0
    image_size: int = 0
    resume: bool = False
    patience: float = PATIENCE
    keep_going: bool = False
    retries: int = RETRIES
    on_failure: str | None = None
    output: Path | None = None

    def __post_init__(self) -> None:
        if self.on_failure not in (None, *ON_FAILURE):
            raise UsageError(f"on_failure is {self.on_failure!r}, expected one of {', '.join(ON_FAILURE)}")
        if self.retries < 0:
            raise UsageError(f"retries is {self.retries}, expected 0 or more")

    @property
    def gives_up(self) -> bool:
        """Whether an episode in which an agent that waits fails is given up, rather than the run stopped."""
        return self.on_failure == "give-up" or (self.on_failure is None and self.keep_going)
