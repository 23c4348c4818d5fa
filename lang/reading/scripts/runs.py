"""Division of a text into runs of one language each, where its clauses are of two languages."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from arramon_lang.reading.scripts.transcriber import Transcriber
from arramon_lang.tokens import PAUSES, SENTENCE_ENDS

_UNKNOWN, _OTHER_SCRIPT = 1.0, 2.0
"""Costs of a word in a language that does not know it, and in one of another script."""

_BORROWED, _SHORT, _UNDERSTOOD, _SHARED = 0.1, 0.15, 0.35, 0.45
"""Costs in the language's own sentences of a foreign noun, adjective or loan, of a usual short form that is also a
foreign word ("me"), of another foreign word that they may contain, and of one that sounds like an own word."""

_AT_PAUSE, _AT_CONJUNCTION, _ELSEWHERE = 0.3, 0.4, 0.9
"""Costs of changing the language: after punctuation, at a conjunction, and within a clause."""

_MIN_FOREIGN = 2
"""Minimum number of words of a foreign run that the language itself does not use."""


@dataclass(frozen=True, slots=True)
class Run:
    """Words that belong to one language."""

    keys: tuple[str, ...]
    is_foreign: bool


def find_runs(
    keys: Sequence[str], transcriber: Transcriber, foreign: Collection[str], conjunctions: Collection[str]
) -> list[Run]:
    """Return the runs of a text, at least one; the language changes where that explains most words.

    Args:
        keys: the text's words.
        transcriber: knows which words are the language's own, and which it borrows.
        foreign: vocabulary of the other language.
        conjunctions: words at which the language often changes.
    """
    costs = [_costs(key, transcriber, foreign) for key in keys]
    best, before = [(0.0, 0.0)], list[tuple[int, int]]()
    for at, cost in enumerate(costs):
        change = _change(keys, at, conjunctions)
        stay_or_change = [[best[-1][old] + change * (old != new) for old in (0, 1)] for new in (0, 1)]
        before.append((_cheaper(stay_or_change[0]), _cheaper(stay_or_change[1])))
        best.append((min(stay_or_change[0]) + cost[0], min(stay_or_change[1]) + cost[1]))
    state = 0 if best[-1][0] <= best[-1][1] else 1
    states: list[int] = []
    for at in range(len(keys) - 1, -1, -1):
        states.append(state)
        state = before[at][state]
    return _unfinished_apart(_merged(keys, states[::-1], costs))


def _cheaper(costs: Sequence[float]) -> int:
    return 0 if costs[0] <= costs[1] else 1


def _unfinished_apart(runs: Sequence[Run]) -> list[Run]:
    """Return the runs with a sentence that goes on in the next run as a run of its own."""
    parts: list[Run] = []
    for number, run in enumerate(runs):
        ends = [at for at, key in enumerate(run.keys, 1) if _ends_sentence(key)]
        if number + 1 < len(runs) and ends and ends[-1] < len(run.keys):
            parts += (replace(run, keys=run.keys[: ends[-1]]), replace(run, keys=run.keys[ends[-1] :]))
        else:
            parts.append(run)
    return parts


def _ends_sentence(key: str) -> bool:
    return key in SENTENCE_ENDS or key in "!?"


def _costs(key: str, transcriber: Transcriber, foreign: Collection[str]) -> tuple[float, float]:
    """Return the costs of a word in the language itself and in the other one."""
    if not key[0].isalpha():
        return 0.0, 0.0
    if not key.isascii():
        return 0.0, _OTHER_SCRIPT
    other = 0.0 if key in foreign else _UNKNOWN
    if transcriber.is_borrowed(key):
        return _BORROWED, other
    if transcriber.has_sense(key):
        return _UNDERSTOOD, other
    if transcriber.is_own(key):
        return (0.0 if key not in foreign else _SHORT if transcriber.is_short(key) else _SHARED), other
    return _UNKNOWN, other


def _change(keys: Sequence[str], at: int, conjunctions: Collection[str]) -> float:
    if at == 0:
        return 0.0
    if keys[at - 1] in PAUSES or _ends_sentence(keys[at - 1]):
        return _AT_PAUSE
    return _AT_CONJUNCTION if keys[at] in conjunctions else _ELSEWHERE


def _merged(keys: Sequence[str], states: Sequence[int], costs: Sequence[tuple[float, float]]) -> list[Run]:
    """Return the runs of equal states; foreign ones of too few foreign words belong to their neighbours."""
    pieces: list[tuple[int, int]] = []
    for at in range(len(keys)):
        if not pieces or states[at] != states[pieces[-1][0]]:
            pieces.append((at, at + 1))
        else:
            pieces[-1] = (pieces[-1][0], at + 1)
    runs: list[Run] = []
    for start, end in pieces:
        truly = sum(own > _BORROWED for own, _ in costs[start:end])
        run = Run(tuple(keys[start:end]), bool(states[start]) and truly >= _MIN_FOREIGN)
        if runs and runs[-1].is_foreign == run.is_foreign:
            runs[-1] = Run((*runs[-1].keys, *run.keys), run.is_foreign)
        else:
            runs.append(run)
    return runs
