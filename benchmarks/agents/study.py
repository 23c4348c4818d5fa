"""Training studies of `agents.vl` at equal compute: each phase is trained and played separately."""

import argparse
import json
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from arramon_agents.perception.encoder import VisualEncoder
from arramon_agents.perception.frame_cache import FrameCache
from arramon_agents.perception.registry import open_encoder
from arramon_agents.training.demonstrations import ROOMS, DemonstrationSource, PhaseDemonstration, collect
from arramon_agents.training.rollouts import RolloutPlan, play
from arramon_agents.training.workspace import Workspace
from arramon_agents.vl.agent import LearnedAgent
from arramon_agents.vl.policy import VlPolicy, load_policy, save_policy
from arramon_agents.vl.recipe import RECIPES, Recipe
from arramon_agents.vl.train import Imitation
from arramon_agents.weights import SUFFIX
from arramon_client.agent import Agent
from benchmarks.common import parser_of

LANGUAGES = ("en", "hi")
SPLITS = ("val_seen", "val_unseen")

METRICS = {"navigation": ("nDTW", "CTC-3"), "assembly": ("PTC",)}
"""Metrics of each phase; the ground truth plays the other one."""

SHORT_RECIPE = replace(RECIPES["vl"], variants=0, average=0.0, validate_episodes=0)
"""The recipe of `vl` for minutes of training: variants of demonstrations would take most of them to be written."""

Scores = Mapping[str, Mapping[str, Mapping[str, float]]]
"""By language of play and "split/episode": each metric."""


@dataclass(frozen=True)
class TrainingSet:
    """The demonstrations of a training run.

    Attributes:
        phase: of all of them.
        encoder: name of the visual encoder.
        episodes: of `train`, the first ones in playing order; 0 for all, None for none.
        rooms: number of additional random room tasks.
    """

    phase: str
    encoder: str
    episodes: int | None
    rooms: int


class CachedEncoder:
    """A visual encoder that caches its features, as agents that play the same rooms see the same frames.

    Args:
        eyes: the encoder whose features are cached.
    """

    def __init__(self, eyes: VisualEncoder) -> None:
        self.name, self.fingerprint, self.channel_names = eyes.name, eyes.fingerprint, eyes.channel_names
        self.channels, self.image_size = eyes.channels, eyes.image_size
        self._seen: FrameCache[npt.NDArray[np.float32]] = FrameCache(eyes.encode, sys.maxsize)

    def encode(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Return the features of a batch of images."""
        return np.stack(self._seen.find(rgb, depth))


@dataclass(frozen=True)
class Study:
    """Trains and plays recipes, and caches weights and scores in a folder.

    Attributes:
        data, cache, runs: the data folder, the drawn demonstrations, and the weights and scores of this study.
        rate: initial learning rate; it decays to 0.
        episodes: number of episodes of each split to play; 0 for all.
        processes: number of processes that render demonstrations.
    """

    data: Path
    cache: Path
    runs: Path
    rate: float
    episodes: int
    processes: int = 1

    def result(self, name: str, recipe: Recipe, training_set: TrainingSet, seconds: float) -> dict[str, Any]:
        """Return the results of a recipe: "scores" as `Scores`, "parameters", "updates", and "pieces" by language.

        Args:
            name: of its files.
            recipe: the recipe to train.
            training_set: the training set.
            seconds: CPU time of training.
        """

        def measure() -> dict[str, Any]:
            policy = self._train(name, recipe, training_set, seconds)
            if training_set.phase == "assembly" and policy.encoder is not None:
                policy = replace(policy, encoder=cached_encoder(policy.encoder.name))
            size = policy.encoder.image_size if policy.encoder else 8
            scores = self.play(LearnedAgent(policy, recipe.agent), training_set.phase, size)
            parameters = sum(each.numel() for each in policy.model.of(training_set.phase).parameters())
            return {"scores": scores, "parameters": parameters} | {
                key: policy.about[key] for key in ("updates", "pieces")
            }

        return self.kept(name, measure)

    def seeds(self, name: str) -> list[int]:
        """Return the seeds of a recipe's cached results with the same number of episodes."""
        end = f"-{self.episodes or 'all'}"
        stems = (path.stem.removesuffix(end) for path in self.runs.glob(f"{name}-*{end}.json"))
        return sorted(int(stem.removeprefix(f"{name}-")) for stem in stems)

    def kept(self, name: str, measure: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """Return the cached results with the same number of episodes, or measure them now."""
        path = self.runs / f"{name}-{self.episodes or 'all'}.json"
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            new = path.with_suffix(".new")
            new.write_text(json.dumps(measure()))
            new.replace(path)
            print(f"{name}: played", file=sys.stderr, flush=True)
        found: dict[str, Any] = json.loads(path.read_text())
        return found

    def play(self, agent: Agent, phase: str, image_size: int, languages: Sequence[str] = LANGUAGES) -> Scores:
        """Return the scores of an agent that plays one phase on both splits; the ground truth plays the other."""
        found: dict[str, dict[str, dict[str, float]]] = {language: {} for language in languages}
        for language in languages:
            for split in SPLITS:
                plan = RolloutPlan(self.data, split, (language,), self.episodes, image_size, (phase,))
                for name, scores in play(agent, plan).items():
                    found[language][f"{split}/{name}"] = {metric: scores[metric] for metric in METRICS[phase]}
        return found

    def _train(self, name: str, recipe: Recipe, training_set: TrainingSet, seconds: float) -> VlPolicy:
        """Return the weights of a recipe, from the folder or by training for some CPU seconds."""
        path = self.runs / f"{name}{SUFFIX}"
        if path.exists():
            return load_policy(path)
        shown = demonstrations(self.data, self.cache, training_set, self.processes)
        training = Imitation(recipe, Workspace(self.data, self.cache, self.runs / "unused"), shown)
        began = time.process_time()
        while (used := (time.process_time() - began) / seconds) < 1.0:
            training.trainer.update(self.rate * (1.0 - used))
        encode = training.policy.tokenizer.encode
        texts_by_language = {
            language: [text for each in shown[:400] for text in each.texts_in([language])] for language in LANGUAGES
        }
        pieces = {
            name: sum(len(encode(text)) for text in texts) / max(len(texts), 1)
            for name, texts in texts_by_language.items()
        }
        training.policy.about |= {"updates": training.trainer.step, "pieces": pieces}
        save_policy(training.policy, path)
        print(f"{name}: trained, {training.trainer.step} updates", file=sys.stderr, flush=True)
        return replace(training.policy, model=training.policy.model.eval())


@lru_cache(maxsize=1)
def demonstrations(data: Path, cache: Path, training_set: TrainingSet, processes: int) -> list[PhaseDemonstration]:
    """Return demonstrations with texts in both languages; those missing in the cache are rendered."""
    sources = (
        []
        if training_set.episodes is None
        else [DemonstrationSource(data, "train", LANGUAGES, training_set.encoder, training_set.episodes)]
    )
    if training_set.rooms:
        sources.append(DemonstrationSource(data, ROOMS, LANGUAGES, training_set.encoder, training_set.rooms))
    return [
        each
        for source in sources
        for part in collect(source, cache, processes)
        for each in part
        if each.phase == training_set.phase
    ]


def study_options(doc: str | None, name: str) -> argparse.ArgumentParser:
    """Return an argument parser with the options that all studies share.

    Args:
        doc: docstring of the study's module.
        name: of its folder of runs and its page.
    """
    parser = parser_of(doc)
    parser.add_argument("--data", type=Path, default=Path("arramon-data"))
    parser.add_argument("--runs", type=Path, default=Path("arramon-results") / name)
    parser.add_argument("--cache", type=Path, default=Path("arramon-cache"))
    parser.add_argument("--rate", type=float, default=0.002, help="learning rate at first; it falls to 0")
    parser.add_argument("--train-episodes", type=int, default=0, help="to learn from; 0 for all")
    parser.add_argument("--rooms", type=int, default=2000, help="drawn rooms to learn from")
    parser.add_argument("--seeds", default="1", help="of training, separated by commas")
    parser.add_argument("--episodes", type=int, default=0, help="of each split; 0 for all")
    parser.add_argument("--page", type=Path, default=Path(f"docs/results/{name}.md"))
    parser.add_argument("--play-only", action="store_true", help="do not write the page")
    return parser


@lru_cache(maxsize=1)
def cached_encoder(encoder: str) -> CachedEncoder:
    """Return a caching encoder by name; the last one is reused."""
    return CachedEncoder(open_encoder(encoder))


def write_page(page: Path, begin: str, end: str, shown: str) -> None:
    """Replace the text between two marks of a page.

    Raises:
        ValueError: if the page lacks one of them.
    """
    text = page.read_text(encoding="utf-8")
    if begin not in text or end not in text.split(begin, 1)[1]:
        raise ValueError(f"{page} has no place for the tables: expected {begin} and {end}")
    before, rest = text.split(begin, 1)
    page.write_text(f"{before}{begin}\n\n{shown}\n\n{end}{rest.split(end, 1)[1]}", encoding="utf-8")
