"""Training of the learned reader: on generated texts in every language, and fine-tuned on people's."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

import torch

import arramon_lang as lang
from arramon_agents.process_settings import prepare_process
from arramon_agents.reading.reader.network import ReaderNetwork, ReaderSizes
from arramon_agents.reading.reader.reader import WEIGHTS, read_reader, write_reader
from arramon_agents.reading.reader.recipe import ReaderRecipe, TuningRecipe
from arramon_agents.reading.reader.slots import rows_of
from arramon_agents.reading.reader.task import Examples, ReadingTask, score
from arramon_agents.reading.reader.words import UNKNOWN, Vocabulary
from arramon_agents.simulated.meanings import TextSample, draw_samples, read_samples, write_plans
from arramon_agents.simulated.people import read_half
from arramon_agents.training.checkpoint import Identity
from arramon_agents.training.recipe import as_json
from arramon_agents.training.schedule import warm_up_cosine
from arramon_agents.training.trainer import Scores, Trainer, TrainerSettings
from arramon_agents.training.workspace import Report, Workspace
from arramon_agents.weights import SUFFIX, find_initial

NAME, TUNING = "reader", "reader_tuning"
"""Names of checkpoint and log."""

HELD_OUT = 10
"""Of so many episodes of the split one is held out for validation."""

DECAY = 0.0001
"""Weight decay."""

VALIDATE_STEPS = 250
"""Steps between two validations."""


def train(recipe: ReaderRecipe | TuningRecipe, workspace: Workspace, report: Report) -> Path:
    """Train or fine-tune a reader, resuming from a checkpoint if there is one; return the path of the weights.

    Raises:
        NotFound: if the data folder does not have the split.
        ValueError: if the output folder holds a checkpoint of another recipe or other data.
    """
    prepare_process()
    workspace.output.mkdir(parents=True, exist_ok=True)
    if isinstance(recipe, TuningRecipe):
        (language,) = recipe.languages
        return tune(recipe, read_half(workspace.data, recipe.split, language), lang.available(), workspace, report)
    learned, tested, vocabulary = _examples(recipe, workspace.data)
    report(f"{NAME}: {len(learned.texts)} texts, {len(vocabulary)} words")
    torch.manual_seed(recipe.seed)
    network = ReaderNetwork(ReaderSizes(len(vocabulary)))

    def validate() -> Scores:
        scores = score(network, tested)
        return {
            f"{language}/{name}": value for language, each in scores.items() for name, value in asdict(each).items()
        }

    steps = recipe.passes * recipe.texts // recipe.batch
    _learn(NAME, recipe, steps, network, learned, workspace, report, validate)
    return _write(workspace.output, network, vocabulary)


def _examples(recipe: ReaderRecipe, data: Path) -> tuple[Examples, Examples, Vocabulary]:
    """Return the examples to learn from, those for validation, from other episodes, and the words of the former."""
    given = read_samples(data, recipe.split)
    each = 4 * len(lang.available())  # Texts of an episode.
    parts = [number // each % HELD_OUT == 0 for number in range(len(given))]
    plans, held = (
        [one.meaning for one, is_held in zip(given, parts, strict=True) if is_held is wanted]
        for wanted in (False, True)
    )
    drawn = list(draw_samples(plans, lang.available(), recipe.texts, recipe.seed))
    vocabulary = Vocabulary.of(sample.text for sample in drawn)
    written = write_plans(held, lang.available(), recipe.seed)
    return examples_of(drawn, vocabulary), examples_of(list(written), vocabulary), vocabulary


def examples_of(samples: Sequence[TextSample], vocabulary: Vocabulary) -> Examples:
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


def tune(
    recipe: TuningRecipe,
    samples: Sequence[TextSample],
    languages: Sequence[str],
    workspace: Workspace,
    report: Report = lambda _: None,
) -> Path:
    """Fine-tune a reader on people's texts, and return the path of the weights.

    As many texts written anew from the same plans are learned besides, so that the reader does not forget them. Words
    that it did not know are added.

    Args:
        recipe: with the weights to begin with.
        samples: people's texts, with their meanings.
        languages: in which texts are written anew.
        workspace: with the folder for the weights.
        report: receives lines of progress.
    """
    known_network, known = read_reader(find_initial(recipe.init, NAME) if recipe.init else WEIGHTS)
    drawn = list(draw_samples([sample.meaning for sample in samples], languages, len(samples), recipe.seed))
    new = Vocabulary.of(sample.text for sample in samples)
    vocabulary = Vocabulary((*known.words, *(word for word in new.words if word not in set(known.words))))
    examples = examples_of([*samples, *drawn], vocabulary)
    report(f"{TUNING}: {len(samples)} texts of people, {len(vocabulary) - len(known)} new words")
    network = extend_vocabulary(known_network, known, vocabulary)
    _learn(TUNING, recipe, recipe.passes * len(examples.texts) // recipe.batch, network, examples, workspace, report)
    return _write(workspace.output, network, vocabulary)


def extend_vocabulary(network: ReaderNetwork, known: Vocabulary, vocabulary: Vocabulary) -> ReaderNetwork:
    """Return a network with the same weights for a vocabulary with words added; they begin as unknown ones."""
    sizes = network.sizes
    wider = ReaderNetwork(
        ReaderSizes(len(vocabulary), sizes.embedding, sizes.encoder, sizes.decoder, dropout=sizes.dropout)
    )
    weights = {name: value.clone() for name, value in network.state_dict().items()}
    added = weights["words.weight"][UNKNOWN].repeat(len(vocabulary) - len(known), 1)
    weights["words.weight"] = torch.cat([weights["words.weight"], added])
    wider.load_state_dict(weights)
    return wider


def _learn(
    name: str,
    recipe: ReaderRecipe | TuningRecipe,
    steps: int,
    network: ReaderNetwork,
    examples: Examples,
    workspace: Workspace,
    report: Report,
    validate: Callable[[], Scores] | None = None,
) -> None:
    """Train a network on examples to the end."""
    settings = TrainerSettings(
        name,
        steps,
        warm_up_cosine(recipe.learning_rate, steps),
        recipe.seed,
        decay=DECAY,
        validate_steps=VALIDATE_STEPS,
        checkpoint_steps=workspace.checkpoint_steps,
        identity=Identity(as_json(recipe), examples.digest()),
    )
    Trainer(
        ReadingTask(network, examples, recipe.batch, recipe.seed), settings, workspace.output, report, validate
    ).run()


def _write(folder: Path, network: ReaderNetwork, vocabulary: Vocabulary) -> Path:
    path = folder / f"reader{SUFFIX}"
    write_reader(path, network, vocabulary)
    return path
