"""A run that is being played: a thread that owns each stream, and the open episodes that other threads play."""

import threading
import weakref
from collections import deque
from collections.abc import Callable, Sequence

import grpc

from arramon.v1 import evaluation_pb2, evaluation_pb2_grpc, types_pb2
from arramon_client.errors import RunClosedError
from arramon_client.open_episode import OpenEpisode
from arramon_client.player import MAX_EPISODES, Player
from arramon_client.player_streams import PlayerStreams
from arramon_client.runs.live_episode import LiveEpisode
from arramon_client.runs.waiting import Changes, Operation
from arramon_client.settings import Settings
from arramon_client.transport.stream import PlayStream

JOIN_SECONDS = 5.0
"""Longest wait for a stream's thread when a run is closed."""


class LiveRun:
    """A run that is being played over one or several streams. Thread-safe.

    Args:
        run: the run.
        replays: whether recorded steps of episodes that were played before are handed out.
        notify: called with messages for the participant, from other threads.
        was_over: whether the run was over before, so that it is not played.

    Attributes:
        lock: guards all state of the run and its episodes.
        changes: announced when an episode begins, when the run ends, and on an error.
    """

    def __init__(
        self, run: evaluation_pb2.Run, *, replays: bool, notify: Callable[[str], None], was_over: bool = False
    ) -> None:
        self.lock = threading.RLock()
        self.changes = Changes()
        self._run, self._was_over = run, was_over
        self._replays, self._notify = replays, notify
        self._lanes: list[_Lane] = []
        # Called at the end of a program, too, if it does not close its run: an open stream would keep its channel open.
        self._stop_lanes = weakref.finalize(self, _stop_all, self._lanes)
        self._new: deque[LiveEpisode] = deque()
        self._open: dict[str, LiveEpisode] = {}
        self._error: BaseException | None = None
        self._closed = False

    def start(
        self,
        stub: evaluation_pb2_grpc.EvaluationStub,
        settings: Settings,
        address: str,
        revive: Callable[[], None],
    ) -> None:
        """Start to play over a stream, in a thread of its own.

        Args:
            stub: stub of the server.
            settings: settings of the stream.
            address: address of the server, for messages.
            revive: called before each attempt to reconnect.
        """
        lane = _Lane(self, LivePlayer(self, self._run, self._notify, replays=self._replays))
        self._lanes.append(lane)
        lane.start(PlayerStreams(
            stub, lane.player, settings, address=address, notify=self._notify, revive=revive, reads_ahead=False
        ))  # fmt: skip

    @property
    def run(self) -> evaluation_pb2.Run:
        """The run as last described by the server."""
        with self.lock:
            players = [lane.player for lane in self._lanes]
            latest = max(players, key=lambda player: (player.ended, player.run.episodes_ended), default=None)
            return self._run if latest is None else latest.run

    @property
    def players(self) -> Sequence[Player]:
        """The players of the streams."""
        return [lane.player for lane in self._lanes]

    @property
    def episodes_ended(self) -> int:
        """Number of ended episodes of the run."""
        with self.lock:
            return max((lane.player.episodes_ended for lane in self._lanes), default=self._run.episodes_ended)

    @property
    def steps(self) -> int:
        """Number of actions taken by this client, not counting replayed history."""
        return sum(lane.player.steps for lane in self._lanes)

    @property
    def open_ids(self) -> Sequence[str]:
        """Ids of the open episodes that were handed out."""
        with self.lock:
            return [each for each, episode in self._open.items() if episode not in self._new]

    @property
    def reconnections(self) -> int:
        """Number of times that a stream was reopened."""
        return sum(lane.streams.reconnections for lane in self._lanes)

    @property
    def is_over(self) -> bool:
        """Whether all episodes of the run have ended."""
        with self.lock:
            return self._was_over or any(lane.player.ended for lane in self._lanes)

    def check(self) -> None:
        """Raise the error that ended a stream, or RunClosedError if the run was closed."""
        if self._error is not None:
            raise self._error
        if self._closed:
            raise RunClosedError(f"run {self._run.run_id} is closed in this program; it can be resumed")

    def next_episode(self) -> Operation[LiveEpisode | None]:
        """Return the next episode that the server assigned; None when the run is over."""
        while True:
            with self.lock:
                if self._new:
                    return self._new.popleft()
                if self.is_over:
                    return None
                self.check()
                changed = self.changes.next()
            yield changed

    def end_of_run(self) -> Operation[None]:
        """Wait until the run is over."""
        while True:
            with self.lock:
                if self.is_over:
                    return
                self.check()
                changed = self.changes.next()
            yield changed

    def begin(self, episode: LiveEpisode) -> None:
        """Take note of an episode that the server assigned; the caller holds the lock."""
        before = self._open.get(episode.episode_id)
        if before is not None:
            before.lose()
        self._open[episode.episode_id] = episode
        self._new.append(episode)
        self.changes.announce()

    def leave(self, episode: LiveEpisode) -> None:
        """Forget an episode that has ended or was taken over; the caller holds the lock."""
        if self._open.get(episode.episode_id) is episode:
            del self._open[episode.episode_id]
            if episode.lost and episode in self._new:
                self._new.remove(episode)

    def fail(self, error: BaseException) -> None:
        """Take note of an error that ended a stream, and stop the others; all calls raise it from now on."""
        with self.lock:
            if self._error is None and not self._closed:
                self._error = error
            self._wake_all()
        for lane in self._lanes:
            lane.streams.stop()

    def end(self) -> None:
        """Take note that a stream's thread has ended with the run."""
        with self.lock:
            self._wake_all()

    def close(self) -> None:
        """Close all streams; the run stays open on the server. A second call does nothing."""
        with self.lock:
            self._closed = True
            self._wake_all()
        self._stop_lanes()

    def _wake_all(self) -> None:
        self.changes.announce()
        for episode in self._open.values():
            episode.changes.announce()


class LivePlayer(Player):
    """A player whose actions other threads choose; the run's lock guards all calls."""

    def __init__(self, live: LiveRun, run: evaluation_pb2.Run, notify: Callable[[str], None], *, replays: bool) -> None:
        super().__init__(run, notify, replays=replays)
        self._live = live
        self._episodes: dict[str, LiveEpisode] = {}
        self._received: set[str] = set()  # Episodes of which the current stream has sent an observation.
        self.stream: PlayStream | None = None

    def start_stream(self, *, history: bool, max_episodes: int = MAX_EPISODES, shared: bool = False) -> None:
        """Prepare for a new stream."""
        with self._live.lock:
            self._received.clear()
            super().start_stream(history=history, max_episodes=max_episodes, shared=shared)

    def begin_episode(self, episode: OpenEpisode) -> None:
        """Offer an episode."""
        live = self._episodes[episode.episode.episode_id] = LiveEpisode(self._live, self, episode)
        self._live.begin(live)

    def receive(self, episode: OpenEpisode) -> None:
        """Wake what waits for the observation."""
        self._received.add(episode.episode.episode_id)
        self._episodes[episode.episode.episode_id].receive()

    def leave_episode(self, episode: OpenEpisode, cause: types_pb2.Cause.ValueType | None, *, taken_over: bool) -> None:
        """End an episode."""
        live = self._episodes.pop(episode.episode.episode_id)
        live.leave(cause, taken_over=taken_over)
        self._live.leave(live)

    def lose(self, episode_id: str) -> None:
        """Drop an episode that was assigned to another stream of this run, and ask for a new stream.

        If this one was assigned the episode last after all, the server starts it again on the new stream.
        """
        self.drop([episode_id])
        if self.stream is not None:
            self.stream.cancel()

    def send(self, act: evaluation_pb2.Act) -> None:
        """Send an act, unless the stream does not have its episode yet: it is sent when the observation is repeated."""
        if self.stream is not None and act.episode_id in self._received:
            self.stream.send([act])


class _Lane:
    """One stream of a run, and the thread that reads it."""

    def __init__(self, live: LiveRun, player: LivePlayer) -> None:
        self.live, self.player = live, player

    def start(self, streams: PlayerStreams) -> None:
        self.streams = streams
        # A daemon thread, so that a program that does not close its run can exit.
        self._thread = threading.Thread(target=self._play, name="arramon-run", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        self.streams.stop()
        if self._thread is not threading.current_thread():
            self._thread.join(JOIN_SECONDS)

    def _play(self) -> None:
        try:
            self.streams.play(self._use)
        except BaseException as error:  # noqa: BLE001 - raised again by `LiveRun.check`
            self.live.fail(error)
        else:
            self.live.end()

    def _use(self, stream: PlayStream) -> None:
        """Pass events to the player until the run ends or a new stream is needed."""
        player, lock = self.player, self.live.lock
        with lock:
            player.stream = stream
        try:
            while not player.ended and not player.must_reopen:
                try:
                    events = stream.receive(wait=True)
                except grpc.RpcError:
                    if player.must_reopen:  # It was cancelled for that, see `LivePlayer.lose`.
                        return
                    raise
                with lock:
                    before = player.advances
                    for event in events:
                        player.take(event)
                    acts = player.take_resends()
                    if acts:
                        stream.send(acts)
                if player.advances > before:
                    self.streams.retry.succeeded()
        finally:
            with lock:
                player.stream = None


def _stop_all(lanes: Sequence[_Lane]) -> None:
    for lane in lanes:
        lane.stop()
