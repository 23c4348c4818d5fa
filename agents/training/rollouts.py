"""Rollouts: let an agent play episodes in this process and score it, by the same rules as a run on a server."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from arramon_client.agent import Agent, Episode, Observation, actions_of, end_episode
from arramon_client.environments.backend import Player, PlayerSettings, Scores
from arramon_client.environments.options import Options
from arramon_client.environments.players import open_backend
from arramon_client.errors import UsageError
from arramon_client.world import PHASES

PARALLEL = 16
"""Number of episodes played in parallel."""

FRAME_SIZE = 224
"""Side length of the images if none is named, in pixels: a server's default."""


@dataclass(frozen=True)
class RolloutPlan:
    """Episodes and phases to play.

    Attributes:
        data: data folder.
        split: name of a split that is not hidden.
        languages: languages of the instructions, alternating between episodes.
        episodes: number of episodes that have all languages, in playing order; 0 for all.
        image_size: side length of the images, in pixels.
        phases: phases that the agent plays; the ground truth plays the others.
        chosen: ids of the episodes to play, in this order; empty for the first ones of the split.
    """

    data: Path
    split: str
    languages: tuple[str, ...]
    episodes: int
    image_size: int = FRAME_SIZE
    phases: tuple[str, ...] = PHASES
    chosen: tuple[str, ...] = ()


def check_validation(data: Path, split: str, languages: Sequence[str], episodes: int) -> None:
    """Check, before a training, that it can be validated.

    Args:
        data: data folder.
        split: split for validation.
        languages: languages of the instructions.
        episodes: number of episodes to validate on; 0 for no validation, which needs no split.

    Raises:
        UsageError: if the data folder does not have the split or a language, or no episode has all languages.
    """
    if not episodes:
        return
    backend = open_backend(Options(data=data))
    try:
        infos = [backend.player(PlayerSettings(language, split, (), 8)).split for language in languages]
        if not set.intersection(*(set(info.episode_ids or ()) for info in infos)):
            raise UsageError(f"no episode of {split!r} has all of the languages {', '.join(languages)}")
    except UsageError as error:
        raise UsageError(
            f"the training cannot be validated: {error} (--validate names the split for it; --validate-episodes 0 "
            "trains without)"
        ) from error


def play(agent: Agent, plan: RolloutPlan) -> dict[str, Mapping[str, float]]:
    """Return the scores of each episode by id, averaged over both turns; otherwise as `play_turns`."""
    return {name: scores["total"] for name, scores in play_turns(agent, plan).items()}


def play_turns(agent: Agent, plan: RolloutPlan) -> dict[str, Scores]:
    """Return the scores of each episode by id, in playing order: of "turn 1" and "turn 2", and their means as "total".

    Raises:
        UsageError: if the data folder does not have the split or a language.
    """
    backend = open_backend(Options(data=plan.data))
    sensors = getattr(agent, "sensors", ("rgb", "depth"))

    def open_player(language: str) -> Player:
        return backend.player(PlayerSettings(language, plan.split, sensors, plan.image_size, phases=plan.phases))

    known = [open_player(language).split.episode_ids or () for language in plan.languages]
    ids = [each for each in plan.chosen or known[0] if all(each in others for others in known)][: plan.episodes or None]
    languages = [plan.languages[number % len(plan.languages)] for number in range(len(ids))]
    waiting = iter(range(len(ids)))
    open_: dict[int, tuple[Player, Observation]] = {}
    scores: dict[int, Scores] = {}
    idle: dict[str, list[Player]] = {language: [] for language in plan.languages}
    while True:
        for number in _next(waiting, PARALLEL - len(open_)):
            language = languages[number]
            player = idle[language].pop() if idle[language] else open_player(language)
            observation = player.begin(ids[number], 0)
            agent.begin(Episode(ids[number], language, plan.split, labels=player.labels))
            open_[number] = player, observation
        if not open_:
            return {each: scores[number] for number, each in enumerate(ids)}
        numbers = list(open_)
        actions = actions_of(agent.act([open_[number][1] for number in numbers]))
        for number, action in zip(numbers, actions, strict=True):
            player = open_[number][0]
            step = player.step(action)
            if step.observation is not None:
                open_[number] = player, step.observation
                continue
            assert step.ending is not None
            assert step.ending.scores is not None
            scores[number] = step.ending.scores
            idle[languages[number]].append(player)
            del open_[number]
            end_episode(agent, ids[number])


def mean(scores: Mapping[str, Mapping[str, float]], metric: str) -> float:
    """Return the mean of a metric over episodes."""
    return sum(each[metric] for each in scores.values()) / max(len(scores), 1)


def _next(numbers: Iterator[int], count: int) -> Iterator[int]:
    for _ in range(count):
        try:
            yield next(numbers)
        except StopIteration:
            return
