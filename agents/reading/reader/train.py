"""Train the reader on instructions of every language: `python -m arramon_agents.reading.reader.train --data DATA`.

It reads the plans of a split's instructions, writes new texts from them with other things, and learns to read those.
The folder gets `reader.state.safetensors`, from which it goes on when it is started again, `reader.log.jsonl`,
and at the end `reader.safetensors`, the weights.
"""

import argparse
import json
import logging
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import torch

import arramon_lang as lang
from arramon_agents.reading.reader.network import ReaderNetwork, Sizes
from arramon_agents.reading.reader.reader import write_reader
from arramon_agents.reading.reader.slots import rows_of
from arramon_agents.reading.reader.task import Examples, ReadingTask, score
from arramon_agents.reading.reader.words import Vocabulary
from arramon_agents.simulated.meanings import Sample, draw_samples, read_samples, write_plans
from arramon_agents.training.run import train
from arramon_agents.training.trainer import Plan, Trainer

LOG = logging.getLogger("train_reader")

HELD_OUT = 10
"""Of so many episodes of the split one is held out to test."""


def main(arguments: list[str] | None = None) -> None:
    """Train, or go on training."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    options = _options(arguments)
    torch.set_num_threads(options.threads)
    options.out.mkdir(parents=True, exist_ok=True)
    began = time.thread_time()
    given = read_samples(options.data, options.split)
    each = 4 * len(lang.available())  # Texts of an episode.
    parts = [number // each % HELD_OUT == 0 for number in range(len(given))]
    plans, held = (
        [one.meaning for one, is_held in zip(given, parts, strict=True) if is_held is wanted]
        for wanted in (False, True)
    )
    drawn = list(draw_samples(plans, lang.available(), options.texts, options.seed))
    written = list(write_plans(held, lang.available(), options.seed))
    vocabulary = Vocabulary.of(sample.text for sample in drawn)
    LOG.info("%d texts, %d words, in %.0f s", len(drawn), len(vocabulary), time.thread_time() - began)
    learned, tested = examples_of(drawn, vocabulary), examples_of(written, vocabulary)

    def make_task() -> ReadingTask:
        return ReadingTask(ReaderNetwork(Sizes(len(vocabulary))), learned, options.seed)

    about = f"{len(drawn)} texts, {len(vocabulary)} words"
    plan = Plan(options.rounds * len(drawn), batch=48, rate=0.003, seed=options.seed, about=about)
    trainer = Trainer(plan, make_task)
    train(trainer, options.out, "reader", lambda: _scores(trainer, tested))
    network = trainer.network
    assert isinstance(network, ReaderNetwork)
    write_reader(options.out / "reader.safetensors", network, vocabulary)
    LOG.info("%s", json.dumps(_scores(trainer, tested)))


def examples_of(samples: Sequence[Sample], vocabulary: Vocabulary) -> Examples:
    """Return samples as numbers; those with more rows than a reader can say are left out."""
    texts, rows, languages = [], [], []
    for sample in samples:
        try:
            row = rows_of(sample.meaning)
        except ValueError:
            continue
        texts.append(vocabulary.numbers(sample.text))
        rows.append(row)
        languages.append(sample.language)
    return Examples.of(texts, rows, languages)


def _scores(trainer: Trainer, tested: Examples) -> dict[str, object]:
    network = trainer.network
    assert isinstance(network, ReaderNetwork)
    return {language: asdict(scores) for language, scores in score(network, tested).items()}


def _options(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--data", type=Path, required=True, help="data folder")
    parser.add_argument("--split", default="train", help="split whose instructions are taken")
    parser.add_argument("--out", type=Path, required=True, help="folder for state, log and weights")
    parser.add_argument("--texts", type=int, default=40_000, help="texts to write anew")
    parser.add_argument("--rounds", type=int, default=4, help="how often each text is learned from")
    parser.add_argument("--seed", type=int, default=0, help="of texts and first weights")
    parser.add_argument("--threads", type=int, default=1, help="threads of the computation")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    main()
