"""Backend of environments on a host: the client's play loop runs in a thread, with the environment as its agent."""

import threading
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from queue import SimpleQueue
from typing import Any

import numpy as np
import numpy.typing as npt

from arramon.v1 import evaluation_pb2, types_pb2
from arramon.v1.chain import episode_head
from arramon_client.agent import Episode, Label, Observation
from arramon_client.environments.backend import EpisodeEnd, Images, PlayerSettings, Scores, SplitInfo, Step, TextBounds
from arramon_client.errors import ArramonClientError, ProtocolError, UsageError
from arramon_client.play import Settings as LoopSettings
from arramon_client.play import play
from arramon_client.run_settings import choose_encoding, choose_image_size, choose_split
from arramon_client.transport.access import Access
from arramon_client.transport.connection import Server, call, connect
from arramon_client.transport.retry import PATIENCE
from arramon_client.world import IMAGE_SENSORS

AGENT = "environment"
"""Name of the agent on the leaderboard."""


class RemoteBackend:
    """Opens players on a host.

    Args:
        address: address of the host.
        access: token and encryption.
    """

    def __init__(self, address: str, access: Access) -> None:
        self._address, self._access = address, access

    def player(self, settings: PlayerSettings) -> "RemotePlayer":
        """Return a player with a connection of its own.

        Raises:
            UsageError: if the host does not have what the settings name.
            ArramonClientError: if the host does not answer, or refuses.
        """
        stack = ExitStack()
        server = stack.enter_context(connect(self._address, self._access))
        try:
            return RemotePlayer(server, stack, settings)
        except ArramonClientError:
            stack.close()
            raise

    def prepare(self) -> None:
        """Do nothing: the host renders."""

    def instructions(self, split: str, language: str) -> list[str]:
        """Raise UsageError: a host reveals its instructions one by one."""
        raise UsageError(
            f"the words of the split {split!r} in {language!r} are not known before they are played on a host: use "
            "tokenizer='bytes', or a tokenizer of your own"
        )


class RemotePlayer:
    """Player of runs on a host (implements `backend.Player`).

    Episodes come in the run's order, which is the split's; an episode that is reset early is forfeited. A named episode
    gets a run of its own. A new run is created when an episode begins and the previous run has ended.

    Args:
        server: the connected host.
        stack: exit stack that closes the connection.
        settings: settings of the player.

    Raises:
        UsageError: if the host does not have what the settings name.

    Attributes:
        run: the current run as created; None before the first episode.
    """

    def __init__(self, server: Server, stack: ExitStack, settings: PlayerSettings) -> None:
        self._server, self._stack, self._settings = server, stack, settings
        self._split = _split_info(server, settings)
        self._play_settings = LoopSettings(
            parallel=1,
            encoding=choose_encoding(server.info, None, server.address),
            image_size=choose_image_size(server.info, settings.image_size),
            keep_going=True,
            patience=PATIENCE,
        )
        self._relay: _Relay | None = None
        self._actions: list[int] = []
        self._labels: tuple[Label, ...] = ()
        self._seen: Observation | None = None
        self._episode_id = ""
        self._in_episode = False
        self.run: evaluation_pb2.Run | None = None

    @property
    def split(self) -> SplitInfo:
        """The split being played."""
        return self._split

    @property
    def labels(self) -> tuple[Label, ...]:
        """Label of each segmentation value, by index; empty without that sensor, and before the first episode."""
        return self._labels

    @property
    def episode_id(self) -> str:
        """Id of the current episode; empty before the first."""
        return self._episode_id

    @property
    def place(self) -> str:
        """Empty: a host does not reveal it."""
        return ""

    def begin(
        self,
        episode_id: str | None,
        seed: int,  # noqa: ARG002 - part of the interface
        into: Images | None = None,
        *,
        with_images: bool = True,
    ) -> Observation:
        """Begin the next episode of the run, or a named one; forfeit the current one if it has not ended.

        Args:
            episode_id: id of the episode; None for the next one.
            seed: unused, as no episode is drawn at random.
            into: arrays to write the images to.
            with_images: whether the returned observation has images.

        Raises:
            ArramonClientError: if the host refuses, or is away for too long.
        """
        if self._in_episode:
            self._give_up()
        if self._relay is not None and episode_id is not None:
            self._end_run()
        if self._relay is None:
            self._start_run(episode_id)
        item = self._next()
        assert self._relay is not None
        if not isinstance(item, Observation):
            raise ProtocolError("the server ended an episode before its first observation")
        item = self._check_observation(item)
        self._episode_id, self._actions, self._in_episode = item.episode_id, [], True
        self._labels, self._seen = self._relay.labels, item
        return _into(item, into) if with_images else self.latest_without_images()

    def step(self, action: int) -> Step:
        """Send an action, wait for its result, and return it with an observation.

        Raises:
            ArramonClientError: if the host is away for too long.
        """
        step = self.advance(action)
        return step if step.ending is not None else replace(step, observation=self._seen)

    def advance(self, action: int) -> Step:
        """Send an action, wait for its result, and return it without an observation.

        Raises:
            ArramonClientError: if the host is away for too long.
        """
        if self._relay is None or self._seen is None:
            raise UsageError("the run has ended; reset() begins a new one")
        self._actions.append(action)
        self._relay.answer(action)
        item = self._next()
        here = (self._seen.turn, self._seen.phase)
        if isinstance(item, Observation):
            item = self._check_observation(item)
            self._seen = item
            over = (here,) if (item.turn, item.phase) != here else ()
            return Step(None, item.steps_left, phases_ended=over)
        self._in_episode = False
        scores = self._scores() if self._relay.is_last else None
        return Step(None, 0, phases_ended=(here,), ending=EpisodeEnd(item, scores))

    def latest(self, into: Images | None = None) -> Observation:
        """Return the latest observation."""
        if self._seen is None:
            raise UsageError("no episode has begun")
        return _into(self._seen, into)

    def latest_without_images(self) -> Observation:
        """Return the latest observation without its images."""
        return replace(self.latest(), rgb=None, depth=None, segmentation=None)

    def draw(self, into: Images) -> None:
        """Write the images of the latest observation to arrays."""
        self.latest(into)

    def expert_action(self) -> int:
        """Raise UsageError: a host has no expert."""
        raise UsageError("there is no expert on a host: play in this process (server=None)")

    def map(self, size: int) -> npt.NDArray[np.uint8] | None:  # noqa: ARG002 - part of the interface
        """Return None: a host does not reveal its map."""
        return None

    def chain_head(self, run_id: str) -> bytes:
        """Return the head of the hash chain over the actions sent in the current episode, 32 bytes."""
        return episode_head(run_id, self._episode_id, self._split.data_hash, self._actions)

    def close(self) -> None:
        """Cancel the run, forfeiting its remaining episodes, and close the connection. A second call does nothing."""
        if self._relay is not None:
            self._end_run()
        self._stack.close()

    def _start_run(self, episode_id: str | None) -> None:
        request = evaluation_pb2.CreateRunRequest(
            agent=AGENT,
            split=self._split.name,
            language=self._settings.language,
            sensors=self._settings.sensors,
            episode_ids=[] if episode_id is None else [episode_id],
        )
        run = call(self._server.stub.CreateRun, request, self._server.address)
        self.run, self._relay = run, _Relay(run)
        # A daemon thread, so that a program that does not close its environment can exit.
        thread = threading.Thread(target=self._play, args=(run, self._relay), name="arramon-environment", daemon=True)
        thread.start()

    def _play(self, run: evaluation_pb2.Run, relay: "_Relay") -> None:
        """Play a run to its end, in a thread of its own."""
        end = _LoopEnded(None)
        try:
            play(
                self._server.stub,
                run,
                relay,
                self._play_settings,
                address=self._server.address,
                recording=_RelayRecorder(relay),
            )
        except ArramonClientError as error:
            end = _LoopEnded(error)
        finally:
            relay.finish(end)

    def _next(self) -> Observation | str:
        """Return the next observation, or the cause of the episode's end; an error ends the run here."""
        assert self._relay is not None
        try:
            return self._relay.get()
        except ArramonClientError:
            self._relay, self._in_episode = None, False
            raise

    def _give_up(self) -> None:
        """Forfeit the current episode."""
        assert self._relay is not None
        self._relay.answer(None)
        if isinstance(self._next(), Observation):
            raise ProtocolError("the server continued an episode that was given up")
        self._in_episode = False
        if self._relay.is_last:
            self._relay.wait()
            self._relay = None

    def _check_observation(self, seen: Observation) -> Observation:
        """Check that an observation has the requested data, and return it without any other."""
        side = self._settings.image_size
        for name in self._settings.sensors:
            value = getattr(seen, name, None)
            if name in IMAGE_SENSORS and (value is None or value.shape[:2] != (side, side)):
                shape = "nothing" if value is None else " x ".join(map(str, value.shape[:2]))
                raise ProtocolError(f"the server sent {shape} for the image {name}, expected {side} x {side}")
            if name == "pose" and value is None:
                raise ProtocolError("the server sent no pose, which was requested")
        texts = self._split.texts[self._settings.language]
        if not 0 < len(seen.instruction) <= texts.longest or not set(seen.instruction) <= set(texts.alphabet):
            raise ProtocolError(
                "the server sent an instruction that is longer, or has other characters, than announced"
            )
        if not seen.phase or seen.steps_left > self._split.steps_per_phase:
            raise ProtocolError(f"the server sent no known phase, or {seen.steps_left} steps left: more than its limit")
        others: dict[str, Any] = {name: None for name in (*IMAGE_SENSORS, "pose") if name not in self._settings.sensors}
        return replace(seen, **others)

    def _scores(self) -> Scores | None:
        """Wait for the end of the run, and return the scores of its last episode; None if the host hides them."""
        assert self._relay is not None
        assert self.run is not None
        self._relay.wait()
        self._relay = None
        request = evaluation_pb2.GetReportRequest(run_id=self.run.run_id)
        report = call(self._server.stub.GetReport, request, self._server.address)
        for episode in report.episodes:
            if episode.episode_id == self._episode_id:
                turns = {row.name: {score.metric: score.mean for score in row.scores} for row in episode.turns}
                first, second = turns.get("turn 1", {}), turns.get("turn 2", {})
                if turns.keys() != {"turn 1", "turn 2"} or first.keys() != second.keys():
                    raise ProtocolError(f"the scores of episode {self._episode_id} are not those of two turns")
                return {**turns, "total": {name: (first[name] + second[name]) / 2 for name in first}}
        return None

    def _end_run(self) -> None:
        """Cancel the current run, and wait until the play loop has ended."""
        assert self._relay is not None
        assert self.run is not None
        relay, self._relay, self._in_episode = self._relay, None, False
        request = evaluation_pb2.CancelRunRequest(run_id=self.run.run_id)
        call(self._server.stub.CancelRun, request, self._server.address)
        relay.answer(None)
        relay.wait()


@dataclass(frozen=True)
class _LoopEnded:
    """The end of the play loop, with the error that ended it; None if it ended normally."""

    error: ArramonClientError | None

    def check(self) -> None:
        if self.error is not None:
            raise self.error


class _Relay:
    """The play loop's agent, which exchanges observations and actions with the environment's thread.

    Attributes:
        labels: segmentation labels of the latest episode.
        is_last: whether all episodes of the run have ended.
    """

    def __init__(self, run: evaluation_pb2.Run) -> None:
        self.labels: tuple[Label, ...] = ()
        self._inbox: SimpleQueue[Observation | str | _LoopEnded] = SimpleQueue()
        self._outbox: SimpleQueue[int | None] = SimpleQueue()
        self._left = run.episodes

    @property
    def is_last(self) -> bool:
        return self._left == 0

    def get(self) -> Observation | str:
        """Return the next observation, or the cause of the episode's end; raise the error that ended the loop."""
        item = self._inbox.get()
        if isinstance(item, _LoopEnded):
            item.check()
            raise UsageError("the run was ended by its host or by another client; reset() begins a new one")
        return item

    def answer(self, action: int | None) -> None:
        """Answer the latest observation with an action; None forfeits the episode."""
        self._outbox.put(action)

    def wait(self) -> None:
        """Wait until the play loop has ended; raise the error that ended it."""
        while True:
            item = self._inbox.get()
            if isinstance(item, _LoopEnded):
                item.check()
                return

    def finish(self, end: "_LoopEnded") -> None:
        """Notify the environment that the play loop has ended."""
        self._inbox.put(end)

    def begin(self, episode: Episode) -> None:
        """Store the labels of a new episode."""
        self.labels = episode.labels

    def act(self, observations: Sequence[Observation]) -> list[int]:
        """Pass the one observation to the environment, and return its action."""
        (observation,) = observations
        self._inbox.put(observation)
        action = self._outbox.get()
        if action is None:
            raise RuntimeError("the environment was reset or closed before the episode's end")
        return [action]

    def finish_episode(self, cause: str) -> None:
        """Notify the environment of the cause of the episode's end."""
        self._left -= 1
        self._inbox.put(cause)


class _RelayRecorder:
    """Recorder that passes the ends of episodes, with their causes, to the relay, and records nothing."""

    def __init__(self, relay: _Relay) -> None:
        self._relay = relay

    def begin(self, episode: Episode) -> None:
        """Record nothing."""

    def step(self, observation: Observation, action: int | None) -> None:
        """Record nothing."""

    def end(self, episode_id: str, cause: types_pb2.Cause.ValueType) -> None:  # noqa: ARG002 - there is only one
        """Pass on the end of the episode."""
        self._relay.finish_episode(types_pb2.Cause.Name(cause).removeprefix("CAUSE_"))


def _split_info(server: Server, settings: PlayerSettings) -> SplitInfo:
    info = server.info
    split = choose_split(info, settings.language, settings.split)
    limit = info.limits.steps_per_phase
    if settings.steps_per_phase not in (None, limit):
        raise UsageError(f"steps_per_phase is {settings.steps_per_phase}, but this host's step limit is {limit}")
    if settings.language not in split.texts:
        raise UsageError(
            f"the server at {server.address} ({info.version}) does not send the alphabet of its texts: it is too old"
        )
    return SplitInfo(
        name=split.name,
        hidden=split.hidden,
        sensors=tuple(name for name in split.sensors if name != "oracle"),
        steps_per_phase=limit,
        data_hash=split.data_hash,
        texts={
            code: TextBounds(texts.alphabet, texts.longest, texts.longest_utf8) for code, texts in split.texts.items()
        },
    )


def _into(seen: Observation, into: Images | None) -> Observation:
    """Return the observation, after writing its images to the arrays, if any are given."""
    for name, pixels in (into or {}).items():
        pixels[...] = getattr(seen, name)
    return seen
