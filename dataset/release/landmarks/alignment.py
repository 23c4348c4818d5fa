"""Alignment of an instruction to its path: a hidden Markov model whose states are the places of the path.

Events are in the order of the text. A turn is likely where the path turns by its angle; a mention is likely where its
kernel covers a known landmark of its kind; and skipping a big turn of the path is unlikely.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from arramon_dataset.release.landmarks.mentions import Event
from arramon_dataset.release.landmarks.turn_paths import Indices, Numbers, TurnPath
from arramon_lang.street_words import DEGREES

BIG = 60.0
"""Minimum size of turns of a path that texts usually mention, in degrees."""

PASSED_OVER = 1.5
"""Cost of skipping a big turn between two events, in nats."""

NEAR = 2
"""Maximum number of steps between an event and the big turn that it mentions."""

SPREAD = 35.0
"""Standard deviation of turns from the nominal angle of their word, in degrees."""

UNEXPECTED = 0.03
"""Likelihood of a turn where the path has none, relative to an exact one."""

PACE = 0.35
"""Standard deviation of an event's place from an even pace through the text, as a share of the path."""

Fit = Callable[[Event, TurnPath], Numbers]
"""Returns the likelihood (n,) of a mention at each place of the path, given the known landmarks."""


@dataclass(frozen=True, eq=False)
class EventAlignment:
    """An instruction's events on its path.

    Attributes:
        posterior: (events, places), the probability of each place; rows sum to 1.
        best: (events,), the places of the likeliest sequence.
    """

    posterior: Numbers
    best: Sequence[int]


def align(events: Sequence[Event], path: TurnPath, fit: Fit) -> EventAlignment:
    """Return the alignment of events, at least one, to a path."""
    size = len(path.places)
    emission = np.stack([_emission(event, number, len(events), path, fit) for number, event in enumerate(events)])
    passed = np.cumsum(_big_turns(path))
    moves = [np.zeros((size, size)), *(_moves(before, event, passed) for before, event in pairwise(events))]
    forward, viterbi = np.empty_like(emission), np.empty_like(emission)
    back = np.zeros(emission.shape, dtype=np.intp)
    first = -PASSED_OVER * _between(np.zeros(1, dtype=np.intp), np.arange(size), passed, False, _turns(events[0]))[0]
    forward[0] = viterbi[0] = first + emission[0]
    for at in range(1, len(events)):
        forward[at] = _sum(forward[at - 1][:, None] + moves[at]) + emission[at]
        reached = viterbi[at - 1][:, None] + moves[at]
        back[at] = reached.argmax(axis=0)
        viterbi[at] = reached.max(axis=0) + emission[at]
    last = -PASSED_OVER * _between(np.arange(size), np.array([size - 1]), passed, _turns(events[-1]), False)[:, 0]
    backward = np.empty_like(emission)
    backward[-1] = last
    for at in range(len(events) - 2, -1, -1):
        backward[at] = _sum((moves[at + 1] + (emission[at + 1] + backward[at + 1])[None, :]).T)
    total = forward + backward
    posterior = np.exp(total - total.max(axis=1, keepdims=True))
    best = [int((viterbi[-1] + last).argmax())]
    for at in range(len(events) - 1, 0, -1):
        best.append(int(back[at][best[-1]]))
    return EventAlignment(posterior / posterior.sum(axis=1, keepdims=True), best[::-1])


def _emission(event: Event, number: int, count: int, path: TurnPath, fit: Fit) -> Numbers:
    """Return the logarithm of an event's likelihood at each place, (n,)."""
    size = len(path.places)
    if event.manner == "target":
        only = np.full(size, -40.0)
        only[-1] = np.log(fit(event, path)[-1])
        return only
    share = np.linspace(0.0, 1.0, size) if size > 1 else np.zeros(1)
    pace = -0.5 * ((share - (number / (count - 1) if count > 1 else 0.5)) / PACE) ** 2
    if event.direction:
        expected = DEGREES[event.direction]
        apart = np.abs((path.turned - expected + 180.0) % 360.0 - 180.0)
        if abs(expected) == 90.0:  # People call anything from 60 to 150 degrees a turn to the left or right.
            apart = np.maximum(apart - np.where(np.abs(path.turned) > abs(expected), 60.0, 30.0), 0.0)
        likely: Numbers = pace + np.log(UNEXPECTED + np.exp(-0.5 * (apart / SPREAD) ** 2))
        return likely
    if not event.kind:
        return pace
    mention: Numbers = pace + np.log(fit(event, path))
    return mention


def _moves(before: Event, event: Event, passed: Numbers) -> Numbers:
    """Return the logarithm of the transition from each place to each other, (n, n)."""
    places = np.arange(len(passed))
    if event.tied:
        return np.where(np.eye(len(passed), dtype=bool), 0.0, -np.inf)
    cost = -PASSED_OVER * _between(places, places, passed, _turns(before), _turns(event))
    return np.where(places[None, :] >= places[:, None], cost, -np.inf)


def _between(start: Indices, end: Indices, passed: Numbers, leaves: bool, arrives: bool) -> Numbers:
    """Return the number of big turns between two places, (starts, ends), less those that the events there mention."""
    after = passed[np.minimum(start + (NEAR if leaves else 0), len(passed) - 1)]
    before = np.where(end - NEAR - 1 >= 0, passed[np.maximum(end - NEAR - 1, 0)], 0) if arrives else passed[end]
    turns: Numbers = np.maximum(before[None, :] - after[:, None], 0.0)
    return turns


def _turns(event: Event) -> bool:
    return bool(event.direction) or event.manner in ("faced", "at", "after", "before")


def _big_turns(path: TurnPath) -> Numbers:
    """Return 1.0 at the middle of each big turn, (n,), otherwise 0.0."""
    size = np.abs(path.turned)
    wide = np.pad(size, NEAR)
    greatest = np.max([wide[shift : shift + len(size)] for shift in range(2 * NEAR + 1)], axis=0)
    at = np.flatnonzero((size >= BIG) & (size == greatest))
    marks = np.zeros(len(size))
    marks[[place for number, place in enumerate(at) if number == 0 or place - at[number - 1] > NEAR]] = 1.0
    return marks


def _sum(logarithms: Numbers) -> Numbers:
    """Return the logarithm of the sums over the first axis."""
    top = logarithms.max(axis=0)
    safe = np.where(np.isfinite(top), top, 0.0)
    with np.errstate(divide="ignore"):
        summed: Numbers = safe + np.log(np.exp(logarithms - safe).sum(axis=0))
    return summed
