"""Routes as token sequences, to which the words of a text are aligned.

The tokens follow from the path and from what the camera shows along it, not from a plan of an instruction: directions
of turns, kinds, colours and sides of the landmarks passed, and the target with its surroundings.
"""

import re
from collections.abc import Iterator, Sequence

from arramon_dataset.paraphrases.route_facts import PassedLandmark, RouteFacts
from arramon_dataset.path_tolerances import FACTS_AROUND, FACTS_ASIDE, FACTS_SLIGHT, FACTS_STRAIGHT
from arramon_server.sim.catalogue import ObjectType

Tokens = tuple[str, ...]

_MIRRORED = {"left": "right", "right": "left"}

_WORD = re.compile(r"[a-z_]+")


def tokens_of(facts: RouteFacts, target: ObjectType) -> Tokens:
    """Return the tokens of a route, in order."""
    return tuple(_tokens(facts, target))


def mirrored(tokens: Sequence[str]) -> Tokens:
    """Return the tokens of the same route with left and right exchanged."""
    return tuple(_mirrored(token) for token in tokens)


def _mirrored(token: str) -> str:
    label, _, value = token.partition(":")
    return f"{label}:{_MIRRORED[value]}" if value in _MIRRORED else token


def _tokens(facts: RouteFacts, target: ObjectType) -> Iterator[str]:
    for leg in facts.legs:
        yield from _turn(leg.turn)
        for passed in leg.passed:
            yield from _thing("pass", passed.name)
            yield from _side(passed)
        yield from _thing("ahead", leg.ahead[0].partition(" (")[0]) if leg.ahead else ()
    yield from _turn(facts.last_turn, "last")
    yield from (f"target:{word}" for word in (target.pattern, target.colour, target.kind))
    for around in facts.around:
        yield from _thing("around", around.partition(":")[0])


def _turn(degrees: float, label: str = "turn") -> Iterator[str]:
    if abs(degrees) >= FACTS_AROUND:
        yield f"{label}:around"
    elif abs(degrees) >= FACTS_STRAIGHT:
        if abs(degrees) < FACTS_SLIGHT:
            yield f"{label}:slight"
        yield f"{label}:{'right' if degrees > 0 else 'left'}"


def _thing(label: str, name: str) -> Iterator[str]:
    for word in _WORD.findall(name.lower()):
        yield f"{label}:{word}" if label == "around" else f"thing:{word}"


def _side(passed: PassedLandmark) -> Iterator[str]:
    if abs(passed.aside) >= FACTS_ASIDE:
        yield f"side:{'right' if passed.aside > 0 else 'left'}"
