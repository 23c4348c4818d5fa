"""Backend of environments on a host, which play runs step by step."""

import logging
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from arramon.v1 import evaluation_pb2
from arramon.v1.chain import episode_head
from arramon_client.agent import Label, Observation
from arramon_client.environments.backend import EpisodeEnd, Images, PlayerSettings, Scores, SplitInfo, Step, TextBounds
from arramon_client.errors import ArramonClientError, ProtocolError, UsageError
from arramon_client.run_settings import choose_encoding, choose_image_size, choose_split
from arramon_client.runs.live import LiveRun
from arramon_client.runs.live_episode import LiveEpisode
from arramon_client.runs.results import scores_of
from arramon_client.runs.waiting import Operation, Result, wait_for
from arramon_client.settings import Settings
from arramon_client.transport.access import Access
from arramon_client.transport.connection import Server, call, connect
from arramon_client.transport.retry import PATIENCE
from arramon_client.world import IMAGE_SENSORS

AGENT = "environment"
"""Name of the agent on the leaderboard."""

RESET_REASON = "the environment was reset or closed before the episode's end"
"""Reason for giving up an episode, for the host's log."""

RUN_ENDED = "the run was ended by its host or by another client; reset() begins a new one"

_log = logging.getLogger(__name__)


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
        self._play_settings = Settings(
            parallel=1,
            encoding=choose_encoding(server.info, None, server.address),
            image_size=choose_image_size(server.info, settings.image_size),
            patience=PATIENCE,
        )
        self._live: LiveRun | None = None
        self._episode: LiveEpisode | None = None
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
        if self._live is not None and episode_id is not None:
            self._end_run()
        if self._live is None:
            self._start_run(episode_id)
        episode = self._wait_for(self._running.next_episode())
        if episode is None:
            self._close_run()
            raise UsageError(RUN_ENDED)
        seen = self._wait_for(episode.present())
        if seen is None:
            raise ProtocolError("the server ended an episode before its first observation")
        seen = self._check_observation(seen)
        self._episode, self._episode_id, self._actions, self._in_episode = episode, episode.episode_id, [], True
        self._labels, self._seen = episode.episode.labels, seen
        return _into(seen, into) if with_images else self.latest_without_images()

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
        if self._live is None or self._seen is None or self._episode is None:
            raise UsageError("the run has ended; reset() begins a new one")
        self._actions.append(action)
        seen = self._wait_for(self._episode.act(self._seen.step, action))
        here = (self._seen.turn, self._seen.phase)
        if seen is not None:
            self._seen = seen = self._check_observation(seen)
            over = (here,) if (seen.turn, seen.phase) != here else ()
            return Step(None, seen.steps_left, phases_ended=over)
        self._in_episode = False
        scores = self._scores() if self._is_last else None
        return Step(None, 0, phases_ended=(here,), ending=EpisodeEnd(self._episode.cause, scores))

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
        if self._live is not None:
            self._end_run()
        self._stack.close()

    @property
    def _running(self) -> LiveRun:
        """The run that is being played.

        Raises:
            UsageError: if it has ended.
        """
        if self._live is None:
            raise UsageError(RUN_ENDED)
        return self._live

    @property
    def _is_last(self) -> bool:
        """Whether all episodes of the run have ended."""
        live = self._running
        return live.episodes_ended >= live.run.episodes

    def _start_run(self, episode_id: str | None) -> None:
        request = evaluation_pb2.CreateRunRequest(
            agent=AGENT,
            split=self._split.name,
            language=self._settings.language,
            sensors=self._settings.sensors,
            episode_ids=[] if episode_id is None else [episode_id],
        )
        run = call(self._server.stub.CreateRun, request, self._server.address)
        self.run, self._live = run, LiveRun(run, replays=False, notify=_log.warning)
        self._live.start(self._server.stub, self._play_settings, self._server.address, lambda: None)

    def _wait_for(self, operation: Operation[Result]) -> Result:
        """Run an operation of the run; an error ends the run here."""
        try:
            return wait_for(operation)
        except ArramonClientError:
            self._close_run()
            raise

    def _close_run(self) -> None:
        """Close the run's stream."""
        live, self._live, self._in_episode = self._live, None, False
        if live is not None:
            live.close()

    def _give_up(self) -> None:
        """Forfeit the current episode."""
        assert self._episode is not None
        self._wait_for(self._episode.give_up(RESET_REASON))
        self._in_episode = False
        if self._is_last:
            self._wait_for(self._running.end_of_run())
            self._close_run()

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
        run = self._running.run
        self._wait_for(self._running.end_of_run())
        self._close_run()
        request = evaluation_pb2.GetReportRequest(run_id=run.run_id)
        report = call(self._server.stub.GetReport, request, self._server.address)
        return scores_of(report, self._episode_id)

    def _end_run(self) -> None:
        """Cancel the current run, and wait until it is over."""
        live = self._running
        request = evaluation_pb2.CancelRunRequest(run_id=live.run.run_id)
        try:
            call(self._server.stub.CancelRun, request, self._server.address)
            self._wait_for(live.end_of_run())
        finally:
            self._close_run()


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
