"""Fine-tune the reader on people's texts: `python -m arramon_agents.reading.reader.tune --data DATA --out FOLDER`.

The texts are those of half of an imported split's episodes; what they say is taken from the languages' grammars, as
far as these can read them. As many texts written anew from the same plans are learned besides, so that the reader does
not forget them. Words that it did not know are added. The folder gets `reader.safetensors`, and the other half of the
episodes is left to test on.
"""

import argparse
import logging
from collections.abc import Sequence
from pathlib import Path

import torch

import arramon_lang as lang
from arramon_agents.reading.reader.network import ReaderNetwork, Sizes
from arramon_agents.reading.reader.reader import WEIGHTS, read_reader, write_reader
from arramon_agents.reading.reader.task import ReadingTask
from arramon_agents.reading.reader.train import examples_of
from arramon_agents.reading.reader.words import UNKNOWN, Vocabulary
from arramon_agents.simulated.meanings import Sample, draw_samples
from arramon_agents.simulated.people import read_half
from arramon_agents.training.trainer import Plan, Trainer

LOG = logging.getLogger("tune_reader")


def widen(network: ReaderNetwork, known: Vocabulary, vocabulary: Vocabulary) -> ReaderNetwork:
    """Return a network with the same weights for a vocabulary with words added; they begin as unknown ones."""
    sizes = network.sizes
    wider = ReaderNetwork(Sizes(len(vocabulary), sizes.embedding, sizes.encoder, sizes.decoder, dropout=sizes.dropout))
    weights = {name: value.clone() for name, value in network.state_dict().items()}
    added = weights["words.weight"][UNKNOWN].repeat(len(vocabulary) - len(known), 1)
    weights["words.weight"] = torch.cat([weights["words.weight"], added])
    wider.load_state_dict(weights)
    return wider


def tune(
    source: Path,
    samples: Sequence[Sample],
    languages: Sequence[str],
    out: Path,
    *,
    rounds: int = 4,
    rate: float = 0.001,
    seed: int = 0,
) -> Path:
    """Fine-tune a reader, and return the file of its weights.

    Args:
        source: weights to begin with.
        samples: people's texts with their meanings.
        languages: in which texts are written anew.
        out: folder for the weights.
        rounds: how often each text is learned from.
        rate: the highest learning rate.
        seed: of new texts and their order.
    """
    network, known = read_reader(source)
    drawn = list(draw_samples([sample.meaning for sample in samples], languages, len(samples), seed))
    new = Vocabulary.of(sample.text for sample in samples)
    vocabulary = Vocabulary((*known.words, *(word for word in new.words if word not in set(known.words))))
    examples = examples_of([*samples, *drawn], vocabulary)
    wider = widen(network, known, vocabulary)
    plan = Plan(rounds * len(examples.texts), batch=48, rate=rate, seed=seed, about=f"{len(samples)} texts of people")
    trainer = Trainer(plan, lambda: ReadingTask(wider, examples, seed))
    while trainer.done < plan.steps:
        loss = trainer.step()
        if trainer.done % 50 == 0 or trainer.done == plan.steps:
            LOG.info("reader: step %d of %d, loss %.3f", trainer.done, plan.steps, loss)
    out.mkdir(parents=True, exist_ok=True)
    write_reader(out / "reader.safetensors", wider, vocabulary)
    return out / "reader.safetensors"


def main() -> None:
    """Read the texts, fine-tune, and write the weights."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, required=True, help="folder of `arramon-server import-release`")
    parser.add_argument("--split", default="val_seen", help="imported split (default: %(default)s)")
    parser.add_argument("--lang", default="en", help="language of the texts (default: %(default)s)")
    parser.add_argument("--reader", type=Path, default=WEIGHTS, help="weights to begin with")
    parser.add_argument("--out", type=Path, required=True, help="folder for the weights")
    parser.add_argument("--rounds", type=int, default=4, help="how often each text is learned from")
    parser.add_argument("--seed", type=int, default=0, help="of new texts and their order")
    given = parser.parse_args()
    torch.set_num_threads(1)
    samples = read_half(given.data, given.split, given.lang)
    LOG.info("%d texts could be read", len(samples))
    tune(given.reader, samples, lang.available(), given.out, rounds=given.rounds, seed=given.seed)


if __name__ == "__main__":
    main()
