"""Training of the learned reader on generated texts in every language, and fine-tuning on people's texts."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

import torch

import arramon_lang as lang
from arramon_agents.process_settings import prepare_process
from arramon_agents.reading.reader.network import ReaderNetwork, ReaderSizes
from arramon_agents.reading.reader.reader import WEIGHTS, read_reader, write_reader
from arramon_agents.reading.reader.recipe import FineTuningRecipe, ReaderRecipe
from arramon_agents.reading.reader.slots import rows_of
from arramon_agents.reading.reader.task import Examples, ReadingTask, score
from arramon_agents.reading.reader.vocabulary import UNKNOWN, Vocabulary, split
from arramon_agents.simulated.meanings import TextSample, draw_samples, read_samples, write_in_all_languages
from arramon_agents.simulated.people_texts import parse_training_half
from arramon_agents.training.checkpoint import TrainingInputs, check_recipe
from arramon_agents.training.recipe import as_json
from arramon_agents.training.schedule import warm_up_cosine
from arramon_agents.training.trainer import Scores, Trainer, TrainerSettings
from arramon_agents.training.workspace import Report, Workspace
from arramon_agents.weights import SUFFIX, find_initial

NAME, TUNING = "reader", "reader_tuning"
"""Names of checkpoint and log."""

HELD_OUT = 10
"""One in HELD_OUT episodes of the split is held out for validation."""

DECAY = 0.0001
"""Weight decay."""

VALIDATE_STEPS = 250
"""Steps between two validations."""


def train(recipe: ReaderRecipe | FineTuningRecipe, workspace: Workspace, report: Report) -> Path:
    """Train or fine-tune a reader, resuming from a checkpoint if there is one; return the path of the weights.

    Raises:
        UsageError: if the data folder does not have the split.
        ValueError: if the output folder holds a checkpoint of another recipe or other data.
    """
    prepare_process()
    workspace.output.mkdir(parents=True, exist_ok=True)
    check_recipe(workspace.output, TUNING if isinstance(recipe, FineTuningRecipe) else NAME, as_json(recipe))
    if isinstance(recipe, FineTuningRecipe):
        (language,) = recipe.languages
        return fine_tune(
            recipe, parse_training_half(workspace.data, recipe.split, language), lang.required(), workspace, report
        )
    initial = read_reader(find_initial(recipe.init, NAME)) if recipe.init else None
    learned, tested, vocabulary = _examples(recipe, workspace, initial[1] if initial else Vocabulary(()))
    report(f"{NAME}: {len(learned.texts)} texts, {len(vocabulary)} words")
    torch.manual_seed(recipe.seed)
    network = extend_vocabulary(*initial, vocabulary) if initial else ReaderNetwork(ReaderSizes(len(vocabulary)))

    def validate() -> Scores:
        scores = score(network, tested)
        return {
            f"{language}/{name}": value for language, each in scores.items() for name, value in asdict(each).items()
        }

    steps = recipe.passes * len(learned.texts) // recipe.batch
    _learn(NAME, recipe, steps, network, learned, workspace, report, validate)
    return _write(workspace.output, network, vocabulary)


def _examples(recipe: ReaderRecipe, workspace: Workspace, known: Vocabulary) -> tuple[Examples, Examples, Vocabulary]:
    """Return training examples, validation examples from other episodes, and the vocabulary.

    The vocabulary has the known words first, then those of the training texts.
    """
    given = read_samples(workspace.data, recipe.split)
    each = 4 * len(lang.required())  # Texts of an episode.
    parts = [number // each % HELD_OUT == 0 for number in range(len(given))]
    plans, held_out = (
        [one.meaning for one, is_held in zip(given, parts, strict=True) if is_held is wanted]
        for wanted in (False, True)
    )
    drawn = list(draw_samples(plans, lang.required(), recipe.texts, recipe.seed, workspace.processes))
    vocabulary = known.extended(Vocabulary.of(sample.text for sample in drawn))
    written = write_in_all_languages(held_out, lang.required(), recipe.seed)
    return examples_of(drawn, vocabulary), examples_of(list(written), vocabulary), vocabulary


def examples_of(samples: Sequence[TextSample], vocabulary: Vocabulary) -> Examples:
    """Encode samples; those with too many rows for the reader are left out."""
    texts, rows, languages = [], [], []
    for sample in samples:
        try:
            row = rows_of(sample.meaning)
        except ValueError:
            continue
        texts.append(split(sample.text) or [""])
        rows.append(row)
        languages.append(sample.language)
    return Examples.of(texts, rows, languages, vocabulary)


def fine_tune(
    recipe: FineTuningRecipe,
    samples: Sequence[TextSample],
    languages: Sequence[str],
    workspace: Workspace,
    report: Report = lambda _: None,
) -> Path:
    """Fine-tune a reader on people's texts, and return the path of the weights.

    The training data has as many generated texts with the same meanings, to prevent forgetting. New words are added to
    the vocabulary.

    Args:
        recipe: training settings; `init` names the weights to fine-tune.
        samples: people's texts with their meanings.
        languages: languages of the generated texts.
        workspace: has the folder for the weights.
        report: receives lines of progress.
    """
    known_network, known = read_reader(find_initial(recipe.init, NAME) if recipe.init else WEIGHTS)
    drawn = list(draw_samples([sample.meaning for sample in samples], languages, len(samples), recipe.seed))
    vocabulary = known.extended(Vocabulary.of((sample.text for sample in samples), fewest=2))
    examples = examples_of([*samples, *drawn], vocabulary)
    report(f"{TUNING}: {len(samples)} texts of people, {len(vocabulary) - len(known)} new words")
    network = extend_vocabulary(known_network, known, vocabulary)
    _learn(TUNING, recipe, recipe.passes * len(examples.texts) // recipe.batch, network, examples, workspace, report)
    return _write(workspace.output, network, vocabulary)


def extend_vocabulary(network: ReaderNetwork, known: Vocabulary, vocabulary: Vocabulary) -> ReaderNetwork:
    """Return the network for a larger vocabulary; new words get the embedding of the unknown word."""
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
    recipe: ReaderRecipe | FineTuningRecipe,
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
        training_inputs=TrainingInputs(as_json(recipe), examples.digest()),
    )
    Trainer(
        ReadingTask(network.to(workspace.device), examples, recipe.batch, recipe.seed, workspace.device),
        settings,
        workspace.output,
        report,
        validate,
    ).run()


def _write(folder: Path, network: ReaderNetwork, vocabulary: Vocabulary) -> Path:
    path = folder / f"reader{SUFFIX}"
    write_reader(path, network, vocabulary)
    return path
