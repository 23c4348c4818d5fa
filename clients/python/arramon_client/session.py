"""What a player knows of its open episodes, and what follows from each of the server's events. Knows no connection.

The promise it keeps: between two `begin`s of an episode the agent is shown every step of it once and in order, however
often the stream breaks. What was answered is remembered, and answered again where the server asks again.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client import checked
from arramon_client.agent import Agent, Episode, Label
from arramon_client.errors import AgentError, ProtocolError
from arramon_client.observations import episode_of, labels_of, observation_of
from arramon_client.sharing import shared_memory

Problem = evaluation_pb2.Problem


@dataclass(frozen=True)
class AgentFailure:
    """One time that the agent failed.

    Attributes:
        episode_ids: the episodes that were given up for it.
        message: what was wrong.
        details: the tail of the agent's traceback; empty where it raised nothing.
    """

    episode_ids: tuple[str, ...]
    message: str
    details: str


@dataclass
class _Open:
    """An open episode: what was answered by step, what is still to be answered, and why it is given up, if it is."""

    episode: Episode
    answers: dict[int, evaluation_pb2.Act] = field(default_factory=dict)
    inbox: deque[evaluation_pb2.Observation] = field(default_factory=deque)
    failure: str = ""

    def knows(self, step: int) -> bool:
        return step in self.answers or any(queued.step == step for queued in self.inbox)


class Session:
    """The player's memory over all of its streams.

    Attributes:
        run: as the server last described it.
        ended: whether every episode of the run has ended.
        steps: actions that the agent has taken, history not counted.
        advances: grows with everything new that the server said; a stream on which it does not grow got nowhere.
        failures: each time that the agent failed.
        problems: what the server reported, in words.
        actions: of episodes that ended here, as they were sent, from the first step on. What came last may have been
            taken by nobody, as an episode may end while an action is on its way.
    """

    def __init__(self, run: evaluation_pb2.Run, agent: Agent, notify: Callable[[str], None]) -> None:
        self.run = run
        self.ended = False
        self.episodes_ended = run.episodes_ended
        self.steps = 0
        self.advances = 0
        self.failures: list[AgentFailure] = []
        self.problems: list[str] = []
        self.actions: dict[str, tuple[int, ...]] = {}
        self._agent = agent
        self._notify = notify
        self._open: dict[str, _Open] = {}
        self._resend: list[evaluation_pb2.Act] = []
        self._rebuilding: set[str] = set()  # Episodes that were played before this player knew them.
        self._history = False  # Whether the present stream tells the history of its episodes.
        self._labels: tuple[Label, ...] = ()  # Of the present stream's segmentations.
        self._shared: memoryview | None = None  # Where the present stream's images lie, if they do.
        self._warned = False

    @property
    def backlog(self) -> int:
        """Observations and repeated answers that wait for `answer`."""
        return len(self._resend) + sum(len(episode.inbox) for episode in self._open.values())

    @property
    def needs_history(self) -> bool:
        """Whether the next stream has to tell the history of its episodes."""
        return bool(self._rebuilding)

    @property
    def must_reopen(self) -> bool:
        """Whether the present stream is of no use: it brought an episode in mid-play, and does not tell its history."""
        return self.needs_history and not self._history

    def start_stream(self, *, history: bool) -> None:
        """A new stream was opened: what was not yet answered will come again on it."""
        self._history = history
        self._resend.clear()
        for episode in self._open.values():
            episode.inbox.clear()

    def take(self, event: evaluation_pb2.Event) -> None:
        """Notes an event.

        Raises:
            ProtocolError: if it reports a fault that this client must not make.
            NotSharedError: if it shares memory with this client that is not to be had.
        """
        match event.WhichOneof("event"):
            case "opened":
                self._take_opened(event.opened)
            case "episode_started":
                self._take_started(event.episode_started)
            case "observation":
                self._take_observation(event.observation)
            case "episode_ended":
                self._remember(event.episode_ended.episode_id)
                self._forget(event.episode_ended.episode_id)
                self.episodes_ended = max(self.episodes_ended, event.episode_ended.episodes_ended)
                self.advances += 1
            case "run_ended":
                self.run, self.ended = event.run_ended.run, True
                self.episodes_ended = self.run.episodes_ended
            case "problem":
                self._take_problem(event.problem)
            case _:  # The end of a phase shows in the next observation; what a later server says besides is not needed.
                pass

    def answer(self) -> list[evaluation_pb2.Act]:
        """Gives the agent one batch, at most one observation of each open episode, and returns what is to be sent.

        Raises:
            ProtocolError: if an image cannot be decoded.
        """
        acts, self._resend = self._resend, []
        batch: list[tuple[_Open, evaluation_pb2.Observation]] = []
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

    def _ask_agent(self, batch: list[tuple[_Open, evaluation_pb2.Observation]]) -> list[evaluation_pb2.Act]:
        observations = [observation_of(message, self._shared) for _, message in batch]
        try:
            actions = checked.act(self._agent, observations)
        except AgentError as error:
            self._fail([episode for episode, _ in batch], error)
            return [self._forfeit(episode, message) for episode, message in batch if not message.HasField("taken")]
        acts = []
        for (episode, message), action in zip(batch, actions, strict=True):
            if message.HasField("taken"):
                self._compare(message, action)
                action = message.taken
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
                f"{message.taken} before and takes {action} now; its state may differ from what it was"
            )

    def _forfeit(self, episode: _Open, message: evaluation_pb2.Observation) -> evaluation_pb2.Act:
        self._rebuilding.discard(message.episode_id)
        forfeit = evaluation_pb2.Forfeit(reason=episode.failure[:500])
        act = evaluation_pb2.Act(episode_id=message.episode_id, step=message.step, forfeit=forfeit)
        episode.answers[message.step] = act
        return act

    def _fail(self, episodes: list[_Open], error: AgentError) -> None:
        if not self.failures:
            self._notify(f"the agent failed, and gives up {len(episodes)} episode(s): {error}")
        for episode in episodes:
            episode.failure = str(error)
        ids = tuple(episode.episode.episode_id for episode in episodes)
        self.failures.append(AgentFailure(ids, str(error), error.details))

    def _take_opened(self, opened: evaluation_pb2.Opened) -> None:
        self.run = opened.run
        self._labels = labels_of(opened)
        self._shared = shared_memory(opened.shared) if opened.HasField("shared") else None
        self.episodes_ended = max(self.episodes_ended, opened.run.episodes_ended)
        for episode_id in self._open.keys() - set(opened.episode_ids):
            self._forget(episode_id)
        self._rebuilding.intersection_update(opened.episode_ids)

    def _take_started(self, started: evaluation_pb2.EpisodeStarted) -> None:
        known = self._open.get(started.episode_id)
        rebuilding = started.episode_id in self._rebuilding
        if known is not None and not rebuilding and started.step > max(known.answers, default=-1) + 1:
            self._forget(started.episode_id)  # Another player went on with it in between.
            known = None
        if known is not None:
            return
        if started.step > 0:
            self._rebuilding.add(started.episode_id)
            if not self._history:
                return
        episode = _Open(episode_of(started, self._labels))
        self._open[started.episode_id] = episode
        try:
            checked.begin(self._agent, episode.episode)
        except AgentError as error:
            self._fail([episode], error)

    def _take_observation(self, message: evaluation_pb2.Observation) -> None:
        episode = self._open.get(message.episode_id)
        if episode is None:
            return
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
        self._notify(f"the server reports {text}")
        if problem.code != Problem.CODE_NOT_YOUR_EPISODE:
            raise ProtocolError(f"the server reports {text}: a defect of this client or of the server")
        self._forget(problem.episode_id)

    def _remember(self, episode_id: str) -> None:
        answers = self._open[episode_id].answers if episode_id in self._open else {}
        acts = [answers[step] for step in sorted(answers) if answers[step].HasField("action")]
        if [act.step for act in acts] == list(range(len(acts))):  # or somebody else has played a part of it
            self.actions[episode_id] = tuple(act.action for act in acts)

    def _forget(self, episode_id: str) -> None:
        self._open.pop(episode_id, None)
        self._rebuilding.discard(episode_id)
