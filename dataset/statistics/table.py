"""Statistics as text tables with a column for each split and language, and histograms."""

import unicodedata
from collections.abc import Iterable, Iterator, Sequence

from arramon_client.world import PHASES
from arramon_dataset.statistics import paper
from arramon_dataset.statistics.histogram import BINS, bin_shares
from arramon_dataset.statistics.lengths import MEASURES
from arramon_dataset.statistics.measure import SplitStatistics
from arramon_dataset.statistics.properties import PROPERTIES

_NAMES = {
    "words": "words",
    "path": "path",
    "actions": "actions",
    "egocentric": "egocentric relation",
    "allocentric": "allocentric relation",
    "temporal": "temporal condition",
    "directional": "directional reference",
    "sequencing": "sequencing",
    "discrete_3d": "3D discrete reference",
}
_FIRST, _COLUMN, _BAR = 24, 18, 10
_TEXT_BARS = " ▏▎▍▌▋▊▉█"


def as_text(columns: Sequence[SplitStatistics]) -> Iterator[str]:
    """Yield all tables, line by line.

    Args:
        columns: at least one.
    """
    yield "Words are lower-case tokens of the language's own tokenizer, without punctuation. Paths include the start."
    yield "Diversity is measured on instructions sampled with a fixed seed, equally many for each split and language."
    for phase in PHASES:
        yield from _titled(phase.upper(), [f"{each.split} {each.language}" for each in columns])
        yield _row("episodes", [f"{each.episodes}" for each in columns])
        if any(each.lacking for each in columns):
            yield _row("without this language", [f"{each.lacking}" for each in columns])
        if any(each.preview for each in columns):
            yield _row("", ["preview" if each.preview else "" for each in columns])
        yield from _lengths(columns, phase)
        yield from _properties(columns, phase)
        yield from _diversity(columns, phase)
        yield from _words(columns, phase)
        yield from _histograms(columns, phase)
        yield ""


def _lengths(columns: Sequence[SplitStatistics], phase: str) -> Iterator[str]:
    yield from _titled("lengths of a turn", ["mean, max"] * len(columns))
    for name in MEASURES:
        turns = [each.phases[phase].lengths.turns[name] for each in columns]
        yield _row(_NAMES[name], [f"{each.mean:.2f} {each.longest:5}" for each in turns])
    yield from _titled("sum of both turns", ["mean, max"] * len(columns) + ["paper"])
    for name in MEASURES:
        sums = [each.phases[phase].lengths.episodes[name] for each in columns]
        first = 2 if name == "path" else 0  # The paper counts steps, so the first position of each turn is subtracted.
        cells = [(each.mean - first, each.longest - first) for each in sums] + [paper.LENGTHS[phase][name]]
        yield _row("path steps" if first else _NAMES[name], [f"{mean:.2f} {longest:5}" for mean, longest in cells])


def _properties(columns: Sequence[SplitStatistics], phase: str) -> Iterator[str]:
    yield from _titled("linguistic properties", ["instr., episodes"] * len(columns) + ["paper, episodes"])
    for name in PROPERTIES:
        shares = [each.phases[phase].properties[name] for each in columns]
        cells = [f"{share.instructions:.0%} {share.episodes:6.0%}" for share in shares]
        yield _row(_NAMES[name], [*cells, f"{paper.PROPERTIES[phase][name]:.0%}"])


def _diversity(columns: Sequence[SplitStatistics], phase: str) -> Iterator[str]:
    found = [each.phases[phase].diversity for each in columns]
    yield from _titled("diversity", [f"of {each.texts}" if each else "" for each in found])
    for name, values in (
        ("words", [f"{each.tokens}" if each else "-" for each in found]),
        ("different words", [f"{each.types}" if each else "-" for each in found]),
        ("different instructions", [f"{each.different:.1%}" if each else "-" for each in found]),
        ("MTLD", [f"{each.mtld:.1f}" if each else "-" for each in found]),
        ("distinct-1", [f"{each.distinct[0]:.4f}" if each else "-" for each in found]),
        ("distinct-2", [f"{each.distinct[1]:.3f}" if each else "-" for each in found]),
        ("distinct-3", [f"{each.distinct[2]:.3f}" if each else "-" for each in found]),
        ("self-BLEU in 300", [f"{each.self_bleu:.1f}" if each else "-" for each in found]),
        ("self-BLEU in all", [f"{each.self_bleu_all:.1f}" if each else "-" for each in found]),
        ("zlib ratio", [f"{each.zlib_ratio:.2f}" if each else "-" for each in found]),
    ):
        yield _row(name, values)


def _words(columns: Sequence[SplitStatistics], phase: str) -> Iterator[str]:
    lists = [each.phases[phase].frequent for each in columns]
    yield from _titled("frequent words", [""] * len(columns))
    for rank in range(max(map(len, lists))):
        entries = [words[rank] if rank < len(words) else None for words in lists]
        yield _row(f"{rank + 1:4}", [f"{entry[0]} {entry[1]:5}" if entry else "" for entry in entries])


def _histograms(columns: Sequence[SplitStatistics], phase: str) -> Iterator[str]:
    for name in ("words", "path"):
        width, stop = BINS[phase, name]
        shares = [bin_shares(each.phases[phase].lengths.turns[name], width, stop) for each in columns]
        highest = max(share for each in shares for share in each)
        yield from _titled(f"{_NAMES[name]} a turn, share", [""] * len(columns))
        for number in range(max(_last(each) for each in shares) + 1):
            label = _label(number, width, len(shares[0]))
            yield _row(label, [f"{_bar(each[number] / highest)} {each[number]:6.1%}" for each in shares])


def _last(shares: Sequence[float]) -> int:
    return max(number for number, share in enumerate(shares) if share)


def _label(number: int, width: int, count: int) -> str:
    if number == count - 1:
        return f"{number * width:7} +"
    return f"{number * width:7}" if width == 1 else f"{number * width:7} - {(number + 1) * width - 1}"


def _bar(share: float) -> str:
    """Return a bar of up to `_BAR` characters, to an eighth of a character."""
    eighths = round(share * _BAR * 8)
    bar = "█" * (eighths // 8) + (_TEXT_BARS[eighths % 8] if eighths % 8 else "")
    return bar.ljust(_BAR)


def _titled(title: str, columns: Iterable[str]) -> Iterator[str]:
    yield ""
    yield _row(title, columns)


def _row(first: str, cells: Iterable[str]) -> str:
    return (first.ljust(_FIRST) + "".join(f"  {_right(cell)}" for cell in cells)).rstrip()


def _right(text: str) -> str:
    """Return the text right-aligned by its displayed width: combining and format characters take no space."""
    shown = sum(unicodedata.category(character) not in ("Mn", "Me", "Cf") for character in text)
    return " " * (_COLUMN - shown) + text
