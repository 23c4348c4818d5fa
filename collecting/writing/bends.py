"""Bends of the line: how far it turned a writer in a move, and where several bends that follow each other lead.

A line may begin with a stub: it turns left, and after one step around. Whoever follows the text turns right. Writers
are told where such bends lead together, as each by itself would mislead them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, takewhile

from arramon_client.world import HEADINGS, TURN
from arramon_collecting.writing.walk import Line, Move, Position, lines
from arramon_server.episodes.episode import Episode

CURVE_PLACES = 3
"""Number of places over which single turns of the line add up to a curve that writers are told of."""

NEAR_PLACES = 2
"""Largest number of places between the first and the last bend of a group, unless it is a curve that goes on."""


@dataclass(frozen=True, slots=True)
class Bend:
    """How the line turned a writer in a move along it. Angles are in degrees in (-180, 180], clockwise positive.

    Attributes:
        angle: of this bend; 0 if the move did not turn the writer with the line. Single turns within the last
            CURVE_PLACES places are added up, if they are a curve: the line also zigzags by single turns, which lead
            nowhere else. A sharper turn before them was told by itself.
        net: of all bends that follow each other closely, of which this is one.
        is_later: whether one of these came before this one.
    """

    angle: int = 0
    net: int = 0
    is_later: bool = False


NO_BEND = Bend()


def bend_of(before: Position, move: Move, after: Position, episode: Episode) -> Bend:
    """Return how the line turned the writer in a move."""
    if move not in (Move.FORWARD, Move.BACK) or before.is_indoors or after.turned == before.turned:
        return NO_BEND
    if move is Move.BACK:
        angle = _degrees(after.turned - before.turned)
        return Bend(angle, angle)
    line = lines(episode)[before.turn - 1]
    bends = bends_of(line)
    if not bends[before.place]:  # The writer had turned away, and faces along the line again.
        return NO_BEND
    group = next(group for group in groups_of(bends) if before.place in group)
    net = sum(bends[group.start : group.stop])
    return Bend(_with_curve(bends, before.place), _wrapped(net), before.place > group.start)


def initial_turn(line: Line) -> int:
    """Return how far the first bends of a line lead together, in degrees in (-180, 180]; 0 if it begins straight."""
    bends = bends_of(line)
    group = groups_of(bends)[0] if bends[0] else range(0)
    return _wrapped(sum(bends[place] for place in group))


def bends_of(line: Line) -> list[int]:
    """Return the angle by which the line turns at each of its places, in degrees in (-180, 180]."""
    return [_degrees(after - before) for before, after in pairwise((line.arrival, *line.headings))]


def groups_of(bends: Sequence[int]) -> list[range]:
    """Return the ranges of places whose bends follow each other closely, each beginning and ending with a bend.

    The last place is a group of its own: there the line turns to the object.
    """
    groups: list[range] = []
    for place, angle in enumerate(bends):
        if not angle:
            continue
        group = groups[-1] if groups else range(0)
        is_near = bool(group) and place - group.start <= NEAR_PLACES
        is_curve = bool(group) and place == group.stop and all(bends[at] * angle > 0 for at in group)
        if place < len(bends) - 1 and (is_near or is_curve):
            groups[-1] = range(group.start, place + 1)
        else:
            groups.append(range(place, place + 1))
    return groups


def _with_curve(bends: Sequence[int], place: int) -> int:
    here = bends[place]
    earlier = bends[max(0, place - CURVE_PLACES + 1) : place]
    single = takewhile(lambda angle: abs(angle) <= TURN, reversed(earlier))
    curve = here + sum(single)
    return curve if curve * here > 0 and abs(curve) > abs(here) else here


def _degrees(turns: int) -> int:
    """Return turns of 30 degrees as degrees in (-180, 180]."""
    half = HEADINGS // 2
    return round(TURN) * (half - (half - turns) % HEADINGS)


def _wrapped(degrees: int) -> int:
    return _degrees(degrees // round(TURN))
