"""State of a player's open episodes, and handling of the server's events, independent of the connection.

Guarantee: between two `begin` calls for an episode, the agent gets each of its steps once and in order, however often
the stream breaks. Actions are kept, and sent again when the server repeats an observation. When an episode ends or
another player takes it over, the agent's `end` is called, and only the actions are kept.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client.agent import Agent, Label
from arramon_client.errors import AgentError, ProtocolError
from arramon_client.observations import episode_of, labels_of, observation_of
from arramon_client.open_episode import OpenEpisode
from arramon_client.plugin import agent_calls
from arramon_client.plugin.failures import FailureCounter
from arramon_client.plugin.shared_agent import EpisodesTakenOver, StreamAgent
from arramon_client.recording.recorder import EpisodeRecorder
from arramon_client.transport.images import ImageDecoder
from arramon_client.transport.incoming import check_and_clean, check_observation, check_same_run
from arramon_client.transport.shared_memory import decoder_of

Problem = evaluation_pb2.Problem

MAX_EPISODES = 1024
"""Maximum number of open episodes on a stream, unless another number was requested."""

MAX_PROBLEMS = 1000
"""Maximum number of problems that a server may report in a run; each is shown to the participant."""


@dataclass(frozen=True)
class AgentFailure:
    """One failure of the agent.

    Attributes:
        episode_ids: the episodes that were given up because of it; empty if the agent's `end` failed.
        message: description of the failure.
        details: the tail of the agent's traceback; empty if it raised no exception.
    """

    episode_ids: tuple[str, ...]
    message: str
    details: str


class Session:
    """State of one player across all of its streams.

    Args:
        run: the run as created.
        agent: the agent.
        notify: called with messages for the participant.
        failure_counter: counter of the agent's failures in the whole run.
        recording: records what the agent perceives and does.

    Attributes:
        run: the run as last described by the server.
        ended: whether every episode of the run has ended.
        steps: actions taken by the agent, not counting replayed history.
        advances: number of new observations and episode ends received, to detect streams that make no progress.
        failures: the agent's failures.
        problems: descriptions of the problems that the server reported.
        actions: actions sent in episodes that ended here, by episode id, from the first step on. The last one may not
            have been applied, as an episode can end while an action is in transit.
    """

    def __init__(
        self,
        run: evaluation_pb2.Run,
        agent: Agent,
        notify: Callable[[str], None],
        failure_counter: FailureCounter,
        recording: EpisodeRecorder | None = None,
    ) -> None:
        self.run = run
        self._recording = recording
        self.ended = False
        self.episodes_ended = run.episodes_ended
        self.steps = 0
        self.advances = 0
        self.failures: list[AgentFailure] = []
        self.problems: list[str] = []
        self.actions: dict[str, tuple[int, ...]] = {}
        self._agent = agent
        self._notify = notify
        self._failure_counter = failure_counter
        self._open: dict[str, OpenEpisode] = {}
        self._resend: list[evaluation_pb2.Act] = []
        self._rebuilding: set[str] = set()  # Episodes whose history is being replayed to the agent.
        self._history = False  # Whether the current stream replays the history of its episodes.
        self._max_episodes = MAX_EPISODES  # Episodes that may be open on the current stream.
        self._shared = False  # Whether the current stream may pass images through shared memory.
        self._labels: tuple[Label, ...] = ()  # Labels of the current stream's segmentations.
        self._decoder = ImageDecoder()  # Of the current stream's images.
        self._outdated = False  # Whether the server may not know that this player dropped an episode.
        self._warned = False

    @property
    def backlog(self) -> int:
        """Number of observations and repeated acts that are pending for `answer`."""
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

    def answer(self) -> list[evaluation_pb2.Act]:
        """Pass the agent one batch, with at most one observation per open episode, and return the acts to send.

        Raises:
            AgentStoppedError: as for `take`.
            ProtocolError: if an image cannot be decoded.
        """
        acts, self._resend = self._resend, []
        batch: list[tuple[OpenEpisode, evaluation_pb2.Observation]] = []
        for episode in list(self._open.values()):
            if episode.failure:
                acts.extend(
                    self._forfeit(episode, message) for message in episode.inbox if not message.HasField("taken")
                )
                episode.inbox.clear()
            elif episode.inbox:
                batch.append((episode, episode.inbox.popleft()))
        if batch:
            acts.extend(self._ask_agent(batch))
        return acts

    def _ask_agent(self, batch: list[tuple[OpenEpisode, evaluation_pb2.Observation]]) -> list[evaluation_pb2.Act]:
        observations = [observation_of(message, self._decoder) for _, message in batch]
        try:
            actions = agent_calls.act(self._agent, observations)
        except EpisodesTakenOver as error:
            self._outdated = True
            self._forget_all(error.episode_ids)
            kept = [each for each in batch if each[1].episode_id not in error.episode_ids]
            return self._ask_agent(kept) if kept else []
        except AgentError as error:
            if self._recording is not None:
                for observation in observations:
                    self._recording.step(observation, None)
            self._fail([episode for episode, _ in batch], error)
            return [self._forfeit(episode, message) for episode, message in batch if not message.HasField("taken")]
        self._failure_counter.record_actions()
        acts = []
        for (episode, message), observation, action in zip(batch, observations, actions, strict=True):
            if message.HasField("taken"):
                self._compare(message, action)
                action = message.taken
            if self._recording is not None:
                self._recording.step(observation, action)
            act = evaluation_pb2.Act(
                episode_id=message.episode_id, step=message.step, action=types_pb2.Action.ValueType(action)
            )
            episode.answers[message.step] = act
            if not message.HasField("taken"):
                self._rebuilding.discard(message.episode_id)
                acts.append(act)
                self.steps += 1
        return acts

    def _compare(self, message: evaluation_pb2.Observation, action: int) -> None:
        if action != message.taken and not self._warned:
            self._warned = True
            self._notify(
                f"the agent is not deterministic: at step {message.step} of episode {message.episode_id} it took "
                f"{message.taken} before, but now {action}; its state may differ from the original one"
            )

    def _forfeit(self, episode: OpenEpisode, message: evaluation_pb2.Observation) -> evaluation_pb2.Act:
        self._rebuilding.discard(message.episode_id)
        forfeit = evaluation_pb2.Forfeit(reason=episode.failure[:500])
        act = evaluation_pb2.Act(episode_id=message.episode_id, step=message.step, forfeit=forfeit)
        episode.answers[message.step] = act
        return act

    def _fail(self, episodes: list[OpenEpisode], error: AgentError) -> None:
        self._failure_counter.record_failure(len(episodes), error)
        for episode in episodes:
            episode.failure = str(error)
        ids = tuple(episode.episode.episode_id for episode in episodes)
        self._report_failure(error, ids, f"{len(ids)} episode(s) are given up")

    def _report_failure(self, error: AgentError, given_up: tuple[str, ...], consequence: str) -> None:
        if not self.failures:
            self._notify(f"the agent failed, {consequence}: {error}")
        self.failures.append(AgentFailure(given_up, str(error), error.details))

    def _take_opened(self, opened: evaluation_pb2.Opened) -> None:
        check_same_run(opened.run, self.run.run_id)
        if opened.encoding == types_pb2.ENCODING_SHARED and not self._shared:
            raise ProtocolError("the server offers images in shared memory, which was not requested")
        self.run = opened.run
        self._labels = labels_of(opened)
        self._decoder = decoder_of(opened)
        self.episodes_ended = max(self.episodes_ended, opened.run.episodes_ended)
        self._forget_all(self._open.keys() - set(opened.episode_ids))
        self._rebuilding.intersection_update(opened.episode_ids)

    def _take_started(self, started: evaluation_pb2.EpisodeStarted) -> None:
        known = self._open.get(started.episode_id)
        rebuilding = started.episode_id in self._rebuilding
        if known is not None and self._is_outdated(known, started, rebuilding=rebuilding):
            self._forget(started.episode_id)
            known = None
        if known is not None:
            return
        if started.step > 0:
            self._rebuilding.add(started.episode_id)
            if not self._history:
                return
        if len(self._open) >= self._max_episodes:
            raise ProtocolError(
                f"the server started more than the {self._max_episodes} episodes that were requested at once"
            )
        episode = OpenEpisode(episode_of(started, self._labels))
        self._open[started.episode_id] = episode
        if self._recording is not None:
            self._recording.begin(episode.episode)
        try:
            agent_calls.begin(self._agent, episode.episode)
            episode.begun = True
        except AgentError as error:
            self._fail([episode], error)

    def _is_outdated(self, known: OpenEpisode, started: evaluation_pb2.EpisodeStarted, *, rebuilding: bool) -> bool:
        """Return whether another player has continued the episode, or another stream has begun it with this agent."""
        if known.begun and isinstance(self._agent, StreamAgent) and not self._agent.plays(started.episode_id):
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
        elif not episode.knows(message.step):
            episode.inbox.append(message)
            self.advances += 1

    def _take_problem(self, problem: evaluation_pb2.Problem) -> None:
        where = f" (episode {problem.episode_id}, step {problem.step})" if problem.episode_id else ""
        text = f"{Problem.Code.Name(problem.code)}: {problem.message}{where}"
        self.problems.append(text)
        if len(self.problems) > MAX_PROBLEMS:
            raise ProtocolError(f"the server reported more than {MAX_PROBLEMS} problems")
        self._notify(f"the server reports {text}")
        if problem.code != Problem.CODE_NOT_YOUR_EPISODE:
            raise ProtocolError(f"the server reports {text}: this is a defect of this client or of the server")
        self._forget(problem.episode_id)

    def _take_ended(self, ended: evaluation_pb2.EpisodeEnded) -> None:
        self.episodes_ended = max(self.episodes_ended, ended.episodes_ended)
        episode = self._open.get(ended.episode_id)
        if episode is not None:  # Otherwise a repeated event, or another player's episode.
            self.advances += 1
            if self._recording is not None:
                self._recording.end(ended.episode_id, ended.cause)
            taken = episode.actions()
            if taken is not None and ended.episode_id not in self._rebuilding:
                self.actions[ended.episode_id] = taken
            if self._forget(ended.episode_id) and not episode.failure:
                self._failure_counter.record_end()
        self._rebuilding.discard(ended.episode_id)

    def _forget_all(self, episode_ids: Iterable[str]) -> None:
        for episode_id in sorted(episode_ids):
            self._forget(episode_id)

    def _forget(self, episode_id: str) -> bool:
        """Drop an episode here and in the agent; return False if the agent's `end` failed.

        Raises:
            AgentStoppedError: if it failed and the run must stop.
        """
        self._rebuilding.discard(episode_id)
        episode = self._open.pop(episode_id, None)
        if episode is None or not episode.begun:
            return True
        try:
            agent_calls.end(self._agent, episode_id)
        except AgentError as error:
            self._failure_counter.record_failure(1, error)
            self._report_failure(error, (), "but no episode is given up")
            return False
        return True
