"""One player of a run, across all of its streams: the server's events in, acts out; neither agent nor connection.

Guarantee: each step of an episode is handed out once and in order, however often the stream breaks. Acts are kept, and
sent again when the server repeats an observation, so that no step is taken twice. When an episode ends or another
player takes it over, only its actions are kept.
"""

import time
from collections.abc import Callable, Iterable

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client.agent import Label
from arramon_client.errors import ProtocolError
from arramon_client.observations import episode_of, labels_of
from arramon_client.open_episode import OpenEpisode, ReceivedObservation
from arramon_client.transport.images import ImageDecoder
from arramon_client.transport.incoming import check_and_clean, check_observation, check_same_run
from arramon_client.transport.shared_memory import decoder_of

Problem = evaluation_pb2.Problem

MAX_EPISODES = 1024
"""Maximum number of open episodes on a stream, unless another number was requested."""

MAX_PROBLEMS = 1000
"""Maximum number of problems that a server may report in a run; each is shown to the participant."""


class Player:
    """State of one player of a run, across all of its streams.

    A subclass decides the actions, and overrides `begin_episode`, `receive` and `leave_episode` to learn what happened.

    Args:
        run: the run as created.
        notify: called with messages for the participant.
        replays: whether recorded steps of episodes that were played before are handed out, too. Otherwise only their
            actions are kept, and an episode begins with its latest observation.

    Attributes:
        run: the run as last described by the server.
        ended: whether every episode of the run has ended.
        episodes_ended: number of ended episodes of the run.
        steps: actions taken by this player, not counting replayed history.
        advances: number of new observations and episode ends received, to detect streams that make no progress.
        problems: descriptions of the problems that the server reported.
        actions: actions sent in episodes that ended here, by episode id, from the first step on. The last one may not
            have been applied, as an episode can end while an action is in transit.
        decoder: decoder of the current stream's images.
    """

    def __init__(self, run: evaluation_pb2.Run, notify: Callable[[str], None], *, replays: bool = True) -> None:
        self.run = run
        self.ended = False
        self.episodes_ended = run.episodes_ended
        self.steps = 0
        self.advances = 0
        self.problems: list[str] = []
        self.actions: dict[str, tuple[int, ...]] = {}
        self.decoder = ImageDecoder()
        self._notify = notify
        self._replays = replays
        self._open: dict[str, OpenEpisode] = {}
        self._resend: list[evaluation_pb2.Act] = []
        self._rebuilding: set[str] = set()  # Episodes whose history is being replayed.
        self._history = False  # Whether the current stream replays the history of its episodes.
        self._max_episodes = MAX_EPISODES  # Episodes that may be open on the current stream.
        self._shared = False  # Whether the current stream may pass images through shared memory.
        self._labels: tuple[Label, ...] = ()  # Labels of the current stream's segmentations.
        self._outdated = False  # Whether the server may not know that this player dropped an episode.
        self._note_refused = False

    # For subclasses

    def begin_episode(self, episode: OpenEpisode) -> None:
        """Take note that an episode was assigned to this player."""

    def receive(self, episode: OpenEpisode) -> None:
        """Take note that an observation was received: a new one in the episode's inbox, or one that was repeated."""

    def leave_episode(self, episode: OpenEpisode, cause: types_pb2.Cause.ValueType | None, *, taken_over: bool) -> None:
        """Take note that an episode has ended, or is no longer this player's.

        Args:
            episode: the episode.
            cause: cause of its end; None if the server did not say, as it ended while the stream was broken, or with
                the run.
            taken_over: whether it has not ended, but another player has it.
        """

    def is_taken_over(self, episode: OpenEpisode) -> bool:  # noqa: ARG002 - for subclasses
        """Return whether another stream of this client has begun the episode since."""
        return False

    # For the connection

    @property
    def backlog(self) -> int:
        """Number of observations and repeated acts that are pending."""
        return len(self._resend) + sum(len(episode.inbox) for episode in self._open.values())

    @property
    def needs_history(self) -> bool:
        """Whether the next stream must replay the history of its episodes."""
        return bool(self._rebuilding)

    @property
    def must_reopen(self) -> bool:
        """Whether a new stream is needed.

        This is the case if an episode that had already begun arrived on a stream that does not replay history, or if
        this player dropped an episode that the server may still assign to it.
        """
        return self._outdated or (self.needs_history and not self._history)

    def start_stream(self, *, history: bool, max_episodes: int = MAX_EPISODES, shared: bool = False) -> None:
        """Prepare for a new stream, on which the server repeats the observations that were not answered.

        Args:
            history: whether the stream replays the history of its episodes.
            max_episodes: requested maximum number of open episodes.
            shared: whether shared memory was requested for images.
        """
        self._history, self._max_episodes, self._shared = history, max_episodes, shared
        self._outdated = False
        self._resend.clear()
        for episode in self._open.values():
            episode.inbox.clear()

    def take(self, event: evaluation_pb2.Event) -> None:
        """Handle one event from the server.

        Raises:
            AgentStoppedError: if the agent failed and the run must stop; no episode is given up for that failure.
            ProtocolError: if the event reports a protocol violation by this client, or is malformed.
            ImagesUnreadableError: if this client cannot read images in the stream's encoding.
        """
        kind = event.WhichOneof("event")
        if kind != "observation":
            check_and_clean(event)
        match kind:
            case "opened":
                self._take_opened(event.opened)
            case "episode_started":
                self._take_started(event.episode_started)
            case "observation":
                self._take_observation(event.observation)
            case "episode_ended":
                self._take_ended(event.episode_ended)
            case "run_ended":
                check_same_run(event.run_ended.run, self.run.run_id)
                self.run, self.ended = event.run_ended.run, True
                self.episodes_ended = self.run.episodes_ended
                self._forget_all(self._open.keys())
            case "problem":
                self._take_problem(event.problem)
            case _:  # The next observation shows the end of a phase; unknown events of newer servers are ignored.
                pass

    # For whoever decides the actions

    def take_resends(self) -> list[evaluation_pb2.Act]:
        """Return the acts to send again, as the server repeated their observations."""
        acts, self._resend = self._resend, []
        return acts

    def act(self, episode: OpenEpisode, step: int, action: int, note: str = "") -> evaluation_pb2.Act:
        """Answer an observation with an action; return the act to send.

        Args:
            episode: the episode.
            step: step of the observation.
            action: the action, 0 to 3.
            note: a note to store beside the step; empty for none.
        """
        episode_id = episode.episode.episode_id
        act = evaluation_pb2.Act(episode_id=episode_id, step=step, action=types_pb2.Action.ValueType(action))
        if note:
            act.note = note
        episode.answers[step] = act
        self._rebuilding.discard(episode_id)
        self.steps += 1
        return act

    def pass_recorded(self, episode: OpenEpisode, step: int, action: int) -> None:
        """Take note of a recorded step and its action; nothing is sent."""
        episode.answers[step] = evaluation_pb2.Act(
            episode_id=episode.episode.episode_id, step=step, action=types_pb2.Action.ValueType(action)
        )

    def forfeit(self, episode: OpenEpisode, step: int, reason: str) -> evaluation_pb2.Act:
        """Give up an episode in place of answering an observation; return the act to send."""
        episode_id = episode.episode.episode_id
        self._rebuilding.discard(episode_id)
        forfeit = evaluation_pb2.Forfeit(reason=reason[:500])
        act = evaluation_pb2.Act(episode_id=episode_id, step=step, forfeit=forfeit)
        episode.answers[step] = act
        return act

    def is_rebuilding(self, episode: OpenEpisode) -> bool:
        """Return whether an episode's history is being replayed."""
        return episode.episode.episode_id in self._rebuilding

    def drop(self, episode_ids: Iterable[str]) -> None:
        """Drop episodes that another stream of this client has begun, and ask for a new stream."""
        self._outdated = True
        self._forget_all(episode_ids, taken_over=True)

    # Events

    def _take_opened(self, opened: evaluation_pb2.Opened) -> None:
        check_same_run(opened.run, self.run.run_id)
        if opened.encoding == types_pb2.ENCODING_SHARED and not self._shared:
            raise ProtocolError("the server offers images in shared memory, which was not requested")
        self.run = opened.run
        self._labels = labels_of(opened)
        self.decoder = decoder_of(opened)
        self.episodes_ended = max(self.episodes_ended, opened.run.episodes_ended)
        self._forget_all(self._open.keys() - set(opened.episode_ids))
        self._rebuilding.intersection_update(opened.episode_ids)

    def _take_started(self, started: evaluation_pb2.EpisodeStarted) -> None:
        known = self._open.get(started.episode_id)
        rebuilding = started.episode_id in self._rebuilding
        if known is not None and self._is_outdated(known, started, rebuilding=rebuilding):
            self._forget(started.episode_id, taken_over=True)
            known = None
        if known is not None:
            return
        if started.step > 0 and self._replays:
            self._rebuilding.add(started.episode_id)
            if not self._history:
                return
        if len(self._open) >= self._max_episodes:
            raise ProtocolError(
                f"the server started more than the {self._max_episodes} episodes that were requested at once"
            )
        episode = OpenEpisode(episode_of(started, self._labels))
        self._open[started.episode_id] = episode
        self.begin_episode(episode)

    def _is_outdated(self, known: OpenEpisode, started: evaluation_pb2.EpisodeStarted, *, rebuilding: bool) -> bool:
        """Return whether another player has continued the episode, or another stream has begun it with this agent."""
        if self.is_taken_over(known):
            return True
        return not rebuilding and started.step > max(known.answers, default=-1) + 1

    def _take_observation(self, message: evaluation_pb2.Observation) -> None:
        episode = self._open.get(message.episode_id)
        if episode is None:
            return
        check_observation(message)
        if not message.HasField("taken") and message.step in episode.answers:
            self._rebuilding.discard(message.episode_id)
            self._resend.append(episode.answers[message.step])
        elif message.HasField("taken") and not self._replays:
            if message.step not in episode.answers:
                self.pass_recorded(episode, message.step, message.taken)
        elif not episode.knows(message.step):
            episode.inbox.append(ReceivedObservation(message, time.monotonic()))
            self.advances += 1
            self.receive(episode)

    def _take_problem(self, problem: evaluation_pb2.Problem) -> None:
        where = f" (episode {problem.episode_id}, step {problem.step})" if problem.episode_id else ""
        text = f"{Problem.Code.Name(problem.code)}: {problem.message}{where}"
        if problem.code == Problem.CODE_NOTE_REFUSED:
            self.refuse_note(f"the server did not store a note: {problem.message}{where}")
            return
        self.problems.append(text)
        if len(self.problems) > MAX_PROBLEMS:
            raise ProtocolError(f"the server reported more than {MAX_PROBLEMS} problems")
        self._notify(f"the server reports {text}")
        if problem.code != Problem.CODE_NOT_YOUR_EPISODE:
            raise ProtocolError(f"the server reports {text}: this is a defect of this client or of the server")
        self._forget(problem.episode_id, taken_over=True)

    def refuse_note(self, text: str) -> None:
        """Notify the participant that a note was not stored; the first time only, as there may be one at each step."""
        if not self._note_refused:
            self._note_refused = True
            self.problems.append(text)
            self._notify(f"{text}; the action was taken all the same, and the run goes on")

    def _take_ended(self, ended: evaluation_pb2.EpisodeEnded) -> None:
        self.episodes_ended = max(self.episodes_ended, ended.episodes_ended)
        episode = self._open.get(ended.episode_id)
        if episode is not None:  # Otherwise a repeated event, or another player's episode.
            self.advances += 1
            taken = episode.actions()
            if taken is not None and ended.episode_id not in self._rebuilding:
                self.actions[ended.episode_id] = taken
            self._forget(ended.episode_id, ended.cause)
        self._rebuilding.discard(ended.episode_id)

    def _forget_all(self, episode_ids: Iterable[str], *, taken_over: bool = False) -> None:
        for episode_id in sorted(episode_ids):
            self._forget(episode_id, taken_over=taken_over)

    def _forget(
        self, episode_id: str, cause: types_pb2.Cause.ValueType | None = None, *, taken_over: bool = False
    ) -> None:
        """Drop an episode; the subclass may raise AgentStoppedError."""
        self._rebuilding.discard(episode_id)
        episode = self._open.pop(episode_id, None)
        if episode is not None:
            self.leave_episode(episode, cause, taken_over=taken_over)
