"""The server under test: calls, streams, and runs that are cancelled after each check."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import grpc

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client.conformance.assertions import Skipped, need
from arramon_client.conformance.raw_stream import Metadata, RawStream
from arramon_client.errors import UsageError
from arramon_client.transport.connection import METADATA, Server
from arramon_client.transport.incoming import details_of

AGENT = "conformance"
"""Agent's name in every run that the suite creates."""

MAX_EPISODES = 2000
"""Maximum number of episodes of a run that a check plays to its end; hidden splits are played whole."""


@dataclass
class Target:
    """A server under test, and the split and language of the runs that checks create.

    Attributes:
        server: the connected server.
        split: split of the runs.
        language: language of the runs.
        hidden: a hidden split of the server, for refusals; None if it has none.
        timeout: seconds to wait for each answer.
    """

    server: Server
    split: pb.Split
    language: str
    hidden: pb.Split | None
    timeout: float
    _created: list[str] = field(default_factory=list)

    @property
    def info(self) -> pb.ServerInfo:
        """The server's information."""
        return self.server.info

    @property
    def available(self) -> int:
        """Number of episodes of the split in the language."""
        return self.split.episodes[self.language]

    def call(self, method: str, request: Any, metadata: Metadata = METADATA) -> Any:
        """Make a unary call.

        Raises:
            grpc.RpcError: if it is refused.
        """
        return getattr(self.server.stub, method)(request, timeout=self.timeout, metadata=metadata)

    def create(self, episodes: int = 1, sensors: Sequence[str] = (), **fields: Any) -> pb.Run:
        """Create a run, which is cancelled after the check.

        Args:
            episodes: number of episodes to play; a hidden split is played whole.
            sensors: sensors of the run.
            fields: fields of the request that replace the defaults.

        Raises:
            Skipped: if the split has fewer episodes.
            grpc.RpcError: if it is refused.
        """
        needed = f"the split {self.split.name!r} has {self.available} episodes in {self.language!r}"
        need(episodes <= self.available, f"{needed}; a split with {episodes} would make it run")
        chosen = {
            "agent": AGENT,
            "split": self.split.name,
            "language": self.language,
            "sensors": sensors,
            "episodes": 0 if self.split.hidden else episodes,
            **fields,
        }
        return self.create_raw(pb.CreateRunRequest(**chosen))

    def create_raw(self, request: pb.CreateRunRequest) -> pb.Run:
        """Create a run as requested, which is cancelled after the check.

        Raises:
            grpc.RpcError: if it is refused.
        """
        run: pb.Run = self.call("CreateRun", request)
        self._created.append(run.run_id)
        return run

    def cancel(self, run: pb.Run) -> pb.Run:
        """Cancel a run.

        Raises:
            grpc.RpcError: if it is refused.
        """
        cancelled: pb.Run = self.call("CancelRun", pb.CancelRunRequest(run_id=run.run_id))
        return cancelled

    def get(self, run: pb.Run) -> pb.Run:
        """Return a run as it is now."""
        found: pb.Run = self.call("GetRun", pb.GetRunRequest(run_id=run.run_id))
        return found

    def play(self, run: pb.Run, max_episodes: int = 1, **fields: Any) -> RawStream:
        """Open a stream on a run."""
        opening = pb.Open(run_id=run.run_id, max_episodes=max_episodes, **fields)
        return self.play_raw(pb.PlayRequest(open=opening))

    def play_raw(self, first: pb.PlayRequest, metadata: Metadata = METADATA) -> RawStream:
        """Open a stream with this first message."""
        return RawStream(self.server.stub, first, timeout=self.timeout, metadata=metadata)

    def pose_sensors(self) -> list[str]:
        """Return one sensor that depends on the agent's pose, as a list; empty if the split offers none."""
        for sensor in ("pose", "rgb", "depth"):
            if sensor in self.split.sensors:
                return [sensor]
        return []

    def need_sensor(self, sensor: str) -> None:
        """Raise Skipped unless the split offers the sensor."""
        offers = f"the split {self.split.name!r} does not offer the sensor {sensor}"
        need(sensor in self.split.sensors, f"{offers}; an open split would make it run")

    def smallest(self) -> int:
        """Return the side length of the smallest images offered, in pixels."""
        return min(self.info.image_sizes, default=0)

    def check_bounded(self, run: pb.Run) -> None:
        """Check that a run can be played to its end in reasonable time.

        Raises:
            Skipped: if it has too many episodes.
        """
        if run.episodes > MAX_EPISODES:
            raise Skipped(
                f"a run on {self.split.name!r} has {run.episodes} episodes; a split that is not hidden, or has at most "
                f"{MAX_EPISODES}, would make it run"
            )

    def clean_up(self) -> list[str]:
        """Cancel the runs created since the last call; return descriptions of the failures."""
        problems = []
        created, self._created = self._created, []
        for run_id in created:
            try:
                self.call("CancelRun", pb.CancelRunRequest(run_id=run_id))
            except grpc.RpcError as error:
                if error.code() != grpc.StatusCode.FAILED_PRECONDITION:  # it has already ended
                    problems.append(f"run {run_id} could not be cancelled: {error.code().name}: {details_of(error)}")
        return problems


def choose_target(server: Server, split: str | None, language: str | None, timeout: float) -> Target:
    """Return the target with the requested split and language, or by default an open split with many sensors.

    Raises:
        UsageError: if there is no such split or language, or no split at all.
    """
    splits = [each for each in server.info.splits if language is None or language in each.episodes]
    if split is not None:
        splits = [each for each in splits if each.name == split]
    if not splits:
        offered = ", ".join(f"{each.name} ({', '.join(sorted(each.episodes))})" for each in server.info.splits)
        wanted = f"split {split or 'at all'!r}" + (f" in {language!r}" if language else "")
        raise UsageError(f"the server has no {wanted}; it has {offered or 'no splits'}")
    chosen = max(splits, key=lambda each: (not each.hidden, len(each.sensors), max(each.episodes.values(), default=0)))
    most = max(chosen.episodes, key=lambda code: (chosen.episodes[code], code == "en"), default="")
    hidden = next((each for each in server.info.splits if each.hidden), None)
    return Target(server, chosen, language or most, hidden, timeout)


FORWARD, LEFT = types_pb2.ACTION_FORWARD, types_pb2.ACTION_LEFT
RIGHT, INTERACT = types_pb2.ACTION_RIGHT, types_pb2.ACTION_INTERACT
