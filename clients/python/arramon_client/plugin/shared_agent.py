"""An agent shared by several streams of a run, or copies of it: one call at a time, and each episode on one stream."""

import threading
from collections.abc import Iterable, Sequence

from arramon_client.agent import Agent, Answer, Episode, Observation, end_episode


class EpisodesTakenOver(Exception):
    """A stream passed observations of episodes that another stream has since begun with the same agent.

    Attributes:
        episode_ids: the episodes.
    """

    def __init__(self, episode_ids: Iterable[str]) -> None:
        self.episode_ids = frozenset(episode_ids)
        super().__init__(f"another stream plays {', '.join(sorted(self.episode_ids))}")


class SharedAgent:
    """An agent, and the stream that plays each open episode: the last one that began the episode.

    Args:
        agent: the agent; it is called by one thread at a time.
    """

    def __init__(self, agent: Agent) -> None:
        self.agent = agent
        self.lock = threading.Lock()
        self.streams: dict[str, StreamAgent] = {}

    def copy(self, agent: Agent) -> "SharedAgent":
        """Return a copy of the agent for some of the streams, which is called at the same time as the others."""
        made = SharedAgent(agent)
        made.streams = self.streams
        return made


class StreamAgent:
    """One stream's view of the shared agent.

    A stream may learn late that the server has given its episode to another stream, for example after its server
    process has died. Its further calls for that episode must not change the agent's state, which now belongs to the
    other stream.

    Args:
        shared: the agent that all streams share.
    """

    def __init__(self, shared: SharedAgent) -> None:
        self._shared = shared
        self.replay = self._replay if callable(getattr(shared.agent, "replay", None)) else None

    def plays(self, episode_id: str) -> bool:
        """Return whether this stream was the last to begin an episode, which has not ended."""
        with self._shared.lock:
            return self._plays(episode_id)

    def begin(self, episode: Episode) -> None:
        """Begin an episode on this stream, which takes it over from any other."""
        with self._shared.lock:
            self._shared.streams.pop(episode.episode_id, None)
            self._shared.agent.begin(episode)
            self._shared.streams[episode.episode_id] = self

    def act(self, observations: Sequence[Observation]) -> Sequence[int | Answer]:
        """Return the agent's actions.

        Raises:
            EpisodesTakenOver: if this stream no longer plays some of the episodes; the agent is not called.
        """
        with self._shared.lock:
            lost = [each.episode_id for each in observations if not self._plays(each.episode_id)]
            if lost:
                raise EpisodesTakenOver(lost)
            return self._shared.agent.act(observations)

    def end(self, episode_id: str) -> None:
        """End an episode, unless another stream now plays it."""
        with self._shared.lock:
            if self._plays(episode_id):
                del self._shared.streams[episode_id]
                end_episode(self._shared.agent, episode_id)

    def _replay(self, observation: Observation, action: int) -> None:
        """Pass a recorded step to the agent.

        Raises:
            EpisodesTakenOver: if this stream no longer plays the episode; the agent is not called.
        """
        with self._shared.lock:
            if not self._plays(observation.episode_id):
                raise EpisodesTakenOver([observation.episode_id])
            self._shared.agent.replay(observation, action)  # type: ignore[attr-defined]  # see `__init__`

    def _plays(self, episode_id: str) -> bool:
        return self._shared.streams.get(episode_id) is self
