"""The benchmark as a task set and environment of verifiers: a task is an episode, the server's scores are the rewards.

The model gets each observation as a message with a picture, and answers with JSON, {"actions": ["forward", "left"]}.
"""

import json
from collections.abc import Iterator
from typing import Any

from arramon_client.adapters.episode_runs import EpisodeRuns
from arramon_client.adapters.extras import extra
from arramon_client.adapters.host import Host
from arramon_client.adapters.model_view import RULES, actions_of, observation_text, picture_url
from arramon_client.adapters.results import headline
from arramon_client.agent import Observation
from arramon_client.errors import UsageError

with extra("verifiers"):
    import verifiers.v1 as vf

TASKSET = "arramon-verifiers"
"""The id by which verifiers finds the task set."""

FORMAT = 'Answer with JSON only, for example {"actions": ["forward", "left"]}.'

MAX_UNREADABLE = 3
"""Number of unreadable answers in a row after which the episode is given up."""

INFO = "arramon"
"""Key of an episode's result, with its receipt, in the trace's `info`."""


class ArramonTasksetConfig(vf.TasksetConfig):
    """What is played, and where; a token is that of `$ARRAMON_TOKEN`."""

    id: str = TASKSET
    lang: str = "en"
    """Language of the instructions."""
    split: str | None = None
    """Name of the split; None for the server's only one with the language."""
    server: str | None = None
    """Address of the server, HOST:PORT; None for an embedded one."""
    data: str | None = None
    """Data folder of the embedded server."""
    agent: str = "verifiers"
    """Name of the agent, shown on the leaderboard."""
    image_size: int | None = None
    """Side length of images in pixels; 0 for the server's."""


class EpisodeData(vf.TaskData):
    """Data of a task: `id` is the episode's."""

    section: str | None = None
    """Section in which it takes place; None on a hidden split."""


class EpisodeTask(vf.Task[EpisodeData]):
    """The task of playing one episode."""


class ArramonTaskset(vf.Taskset[EpisodeTask, ArramonTasksetConfig]):
    """The episodes of a split."""

    def __init__(self, config: ArramonTasksetConfig) -> None:
        super().__init__(config)
        self.host = Host(
            language=config.lang,
            split=config.split,
            agent=config.agent,
            server=config.server,
            data=config.data,
            sensors=("rgb",),
            image_size=config.image_size,
        )
        self.runs = EpisodeRuns(self.host)

    def load(self) -> Iterator[EpisodeTask]:
        """Yield a task for each episode, in the split's fixed order; those of a hidden split are numbered."""
        hidden = self.host.is_hidden
        sections: dict[str, str | None] = (
            {f"episode {number + 1}": None for number in range(self.host.episode_count)}
            if hidden
            else dict(self.host.episodes())
        )
        for episode_id, section in sections.items():
            data = EpisodeData(id=episode_id, name=episode_id, system_prompt=f"{RULES}\n{FORMAT}", section=section)
            yield EpisodeTask(data, self.config.task)


class ArramonEnvConfig(vf.EnvConfig):
    """Configuration of the environment, with its only role."""

    player: vf.AgentConfig = vf.AgentConfig()


class ArramonEnv(vf.Env[ArramonEnvConfig]):
    """Plays an episode with a model: observations are its user's messages."""

    async def run(self, task: EpisodeTask, agents: vf.Agents) -> None:
        """Play an episode, and record nDTW, CTC-3 and PTC@CTC-3 as rewards.

        On a hidden split, the last episode to end has the run's scores; the others have no rewards.
        """
        played = await self.taskset.runs.open(task.data.id)
        episode, reason = played.episode, "the rollout ended before the episode's end"
        try:
            async with agents.player.interaction(task) as interaction:
                seen: Observation | None = await episode.look()
                said, unreadable = "", 0
                while seen is not None:
                    segment = await interaction.turn([message(seen, said or episode.stop_reason)])
                    if segment.terminated:
                        break
                    try:
                        actions, said, unreadable = read_actions(segment.last_reply), "", 0
                    except UsageError as error:
                        said, unreadable = str(error), unreadable + 1
                        if unreadable == MAX_UNREADABLE:
                            reason = f"{MAX_UNREADABLE} answers in a row were unreadable"
                            interaction.trace.stop("unreadable_answers")
                            break
                    else:
                        seen = await episode.act(seen.step, actions)
        finally:
            result = await played.finish(reason)
        trace = interaction.trace
        trace.info[INFO] = result
        rows = result.get("scores") or result.get("run_scores")
        for name, value in headline(rows).items() if rows else ():
            trace.record_reward(name, value)


def message(seen: Observation, said: str) -> vf.UserMessage:
    """Return an observation as a message with a picture."""
    parts: list[vf.ContentPart] = [vf.TextContentPart(text=f"{observation_text(seen, said)}\n{FORMAT}")]
    if (url := picture_url(seen)) is not None:
        parts.append(vf.ImageUrlContentPart(image_url=vf.ImageUrlSource(url=url)))
    return vf.UserMessage(content=parts)


def read_actions(reply: str) -> list[int]:
    """Return the actions of a model's answer.

    Raises:
        UsageError: if it is not the JSON object that was asked for.
    """
    try:
        answer = json.loads(reply)
    except ValueError as error:
        raise UsageError(f"the answer is not JSON: {error}") from error
    actions = answer.get("actions") if isinstance(answer, dict) else None
    if not isinstance(actions, list) or not all(isinstance(action, str) for action in actions):
        raise UsageError('the answer has no list "actions" of texts')
    return actions_of(actions)


def load_environment(**settings: Any) -> ArramonEnv:
    """Return the environment.

    Args:
        settings: fields of `ArramonTasksetConfig`; and `player`, the role's `AgentConfig` or its fields.
    """
    player = settings.pop("player", None)
    config: dict[str, Any] = {"taskset": {"id": TASKSET, **settings}} | ({} if player is None else {"player": player})
    return ArramonEnv(ArramonEnvConfig.model_validate(config))
