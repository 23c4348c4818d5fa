"""Rendering of demonstrations by the environments' own player, so that frames equal those that agents get."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from arramon_client.agent import Observation
from arramon_client.environments.backend import PlayerSettings
from arramon_dataset.demonstrations.request import ResolvedExport
from arramon_dataset.demonstrations.sources import EpisodeActions
from arramon_dataset.demonstrations.trajectory import Scores, checked_scores, replay_mismatch
from arramon_dataset.environments import LocalBackend
from arramon_dataset.environments.player import LocalPlayer
from arramon_server.episodes.episode import Episode
from arramon_server.errors import Conflict


@dataclass(frozen=True, eq=False)
class RenderedDemonstration:
    """A demonstration with its observations and rewards.

    Attributes:
        source: the episode's actions.
        episode: the episode that was played.
        observations: one before each action, and the last one: after the end of the episode it repeats the one before,
            as in the environments.
        rewards: reward of each action.
        phases_ended: whether each action ended a phase.
        finished: whether the actions end the episode.
        scores: of the whole episode.
    """

    source: EpisodeActions
    episode: Episode
    observations: Sequence[Observation]
    rewards: Sequence[float]
    phases_ended: Sequence[bool]
    finished: bool
    scores: Scores

    @property
    def action_observations(self) -> Sequence[Observation]:
        """The observation before each action."""
        return self.observations[:-1]

    @property
    def steps(self) -> int:
        """Number of actions."""
        return len(self.source.actions)

    def instructions(self, language: str, observations: Sequence[Observation]) -> list[str]:
        """Return the instruction of each observation in a language."""
        return [self.episode.instruction(language, each.turn, each.phase) for each in observations]

    def terminated(self) -> list[bool]:
        """Return, for each action, whether it ended the episode."""
        return [*(False for _ in self.source.actions[1:]), self.finished]

    def truncated(self) -> list[bool]:
        """Return, for each action, whether the episode was truncated after it, by a time limit or a forfeit."""
        return [*(False for _ in self.source.actions[1:]), not self.finished]


def render(export: ResolvedExport, source: EpisodeActions) -> RenderedDemonstration:
    """Play and render a demonstration.

    Raises:
        ArraMonError: if the actions do not fit the episode.
        Conflict: if the data of the split has changed since the export began.
    """
    player = player_of(export, source.languages[0])
    if player.split.data_hash != export.data_hash:
        raise Conflict(f"the data of split {export.request.split!r} has changed during the export; start again")
    observations, rewards, ended = [player.begin(source.episode_id, 0)], [], []
    try:
        for action in source.actions:
            step = player.step(action)
            observations.append(step.observation or player.latest())
            rewards.append(step.reward)
            ended.append(bool(step.phases_ended))
    except ValueError as error:
        raise replay_mismatch(source, f"after {len(rewards)} of {len(source.actions)} actions: {error}") from error
    session = player.session
    finished = session.state.finished
    scores = checked_scores(source, session)
    return RenderedDemonstration(source, session.episode, observations, rewards, ended, finished, scores)


@lru_cache(maxsize=8)
def player_of(export: ResolvedExport, language: str) -> LocalPlayer:
    """Return this process's player of an export. Players of different languages share their worlds."""
    return LocalBackend(export.request.data).player(settings_of(export, language))


def settings_of(export: ResolvedExport, language: str) -> PlayerSettings:
    """Return the settings of the environment whose observations are exported."""
    request = export.request
    return PlayerSettings(
        language=language,
        split=request.split,
        sensors=request.sensors,
        image_size=request.size,
        reward=request.reward,
        steps_per_phase=export.steps_per_phase,
    )
