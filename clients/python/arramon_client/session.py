"""A player whose actions are chosen by a batch agent.

Guarantee: between two `begin` calls for an episode, the agent gets each of its steps once and in order, however often
the stream breaks. When an episode ends or another player takes it over, the agent's `end` is called.
"""

from collections.abc import Callable

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client.agent import Agent, Answer, Observation
from arramon_client.errors import AgentError
from arramon_client.notes import note_fault, note_text
from arramon_client.observations import nondeterminism_warning, observation_of
from arramon_client.open_episode import OpenEpisode
from arramon_client.play_results import AgentFailure as AgentFailure
from arramon_client.player import Player
from arramon_client.plugin import agent_calls
from arramon_client.plugin.failures import FailureCounter
from arramon_client.plugin.shared_agent import EpisodesTakenOver, StreamAgent
from arramon_client.recording.recorder import EpisodeRecorder

Batch = list[tuple[OpenEpisode, Observation]]


class Session(Player):
    """A player with a batch agent.

    Args:
        run: the run as created.
        agent: the agent.
        notify: called with messages for the participant.
        failure_counter: counter of the agent's failures in the whole run.
        recording: records what the agent perceives and does.

    Attributes:
        failures: the agent's failures.
    """

    def __init__(
        self,
        run: evaluation_pb2.Run,
        agent: Agent,
        notify: Callable[[str], None],
        failure_counter: FailureCounter,
        recording: EpisodeRecorder | None = None,
    ) -> None:
        super().__init__(run, notify)
        self.failures: list[AgentFailure] = []
        self._recording = recording
        self._agent = agent
        self._can_replay = agent_calls.can_replay(agent)
        self._failure_counter = failure_counter
        self._warned = False

    def answer(self) -> list[evaluation_pb2.Act]:
        """Pass the agent one batch, with at most one observation per open episode, and return the acts to send.

        Raises:
            AgentStoppedError: as for `take`.
            StopRun: if the agent stops the run.
            ProtocolError: if an image cannot be decoded.
        """
        acts = self.take_resends()
        batch: Batch = []
        for episode in list(self._open.values()):
            if episode.failure:
                acts.extend(
                    self.forfeit(episode, received.message.step, episode.failure)
                    for received in episode.inbox
                    if not received.message.HasField("taken")
                )
                episode.inbox.clear()
            elif episode.inbox:
                message, arrived = episode.inbox.popleft()
                observation = observation_of(message, self.decoder, arrived)
                if observation.taken is not None and self._can_replay:
                    self._replay(episode, observation)
                else:
                    batch.append((episode, observation))
        if batch:
            acts.extend(self._ask_agent(batch))
        return acts

    def begin_episode(self, episode: OpenEpisode) -> None:
        """Begin an episode in the agent."""
        if self._recording is not None:
            self._recording.begin(episode.episode)
        try:
            agent_calls.begin(self._agent, episode.episode)
            episode.begun = True
        except AgentError as error:
            self._fail([episode], error)

    def leave_episode(self, episode: OpenEpisode, cause: types_pb2.Cause.ValueType | None, *, taken_over: bool) -> None:  # noqa: ARG002
        """End an episode in the agent.

        Raises:
            AgentStoppedError: if that failed and the run must stop.
        """
        if cause is not None and self._recording is not None:
            self._recording.end(episode.episode.episode_id, cause)
        if self._end(episode) and cause is not None and not episode.failure:
            self._failure_counter.record_end()

    def is_taken_over(self, episode: OpenEpisode) -> bool:
        """Return whether another stream has begun the episode with the same agent since."""
        agent = self._agent
        return episode.begun and isinstance(agent, StreamAgent) and not agent.plays(episode.episode.episode_id)

    def _ask_agent(self, batch: Batch) -> list[evaluation_pb2.Act]:
        observations = [observation for _, observation in batch]
        try:
            answers = agent_calls.act(self._agent, observations)
        except EpisodesTakenOver as error:
            self.drop(error.episode_ids)
            kept = [each for each in batch if each[1].episode_id not in error.episode_ids]
            return self._ask_agent(kept) if kept else []
        except AgentError as error:
            if self._recording is not None:
                for observation in observations:
                    self._recording.step(observation, None)
            self._fail([episode for episode, _ in batch], error)
            return [self.forfeit(episode, seen.step, episode.failure) for episode, seen in batch if seen.taken is None]
        self._failure_counter.record_actions()
        acts = []
        for (episode, observation), answer in zip(batch, answers, strict=True):
            if observation.taken is not None:
                self._compare(observation, answer.action)
                self._record(episode, observation, observation.taken)
                continue
            if self._recording is not None:
                self._recording.step(observation, answer.action)
            acts.append(self.act(episode, observation.step, answer.action, self._note(answer)))
        return acts

    def _replay(self, episode: OpenEpisode, observation: Observation) -> None:
        try:
            agent_calls.replay(self._agent, observation)
        except EpisodesTakenOver as error:
            self.drop(error.episode_ids)
        except AgentError as error:
            self._fail([episode], error)
        else:
            assert observation.taken is not None
            self._record(episode, observation, observation.taken)

    def _record(self, episode: OpenEpisode, observation: Observation, action: int) -> None:
        """Take note of a recorded step that the agent has been shown."""
        if self._recording is not None:
            self._recording.step(observation, action)
        self.pass_recorded(episode, observation.step, action)

    def _note(self, answer: Answer) -> str:
        text = note_text(answer.note)
        fault = note_fault(text)
        if fault:
            self.refuse_note(f"the agent's note was not stored: {fault}")
        return "" if fault else text

    def _compare(self, observation: Observation, action: int) -> None:
        if action != observation.taken and not self._warned:
            self._warned = True
            self._notify(nondeterminism_warning(observation, action))

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

    def _end(self, episode: OpenEpisode) -> bool:
        """Call the agent's `end`; return False if it failed.

        Raises:
            AgentStoppedError: if it failed and the run must stop.
        """
        if not episode.begun:
            return True
        try:
            agent_calls.end(self._agent, episode.episode.episode_id)
        except AgentError as error:
            self._failure_counter.record_failure(1, error)
            self._report_failure(error, (), "but no episode is given up")
            return False
        return True
