"""Consistent names within one instruction: each thing keeps one name, and things of one kind get distinct names."""

from collections.abc import Mapping
from dataclasses import replace
from random import Random

from arramon_client.world import COLLECTIBLES
from arramon_dataset.instructions.navigation.landmark_names import NEVER_BARE
from arramon_lang.coreference import map_mentions, mentions
from arramon_lang.meaning import PLACES, Navigation, Thing

NEXT_SHARE = 0.5
"""Probability that a second thing of a kind farther on is called "the next bench" rather than "another bench"."""


COUNTED_ON_SHARE = 0.25
"""Probability that a second thing of a kind is called "the next one" although its colour would distinguish it."""

NOT_COUNTED_ON = (*COLLECTIBLES, *NEVER_BARE, "building")
"""Kinds never called "the next one" if their colour distinguishes them: too many are in sight."""


class NoDistinctName(ValueError):
    """Two things of an instruction have no names that distinguish them."""


def with_distinct_names(meaning: Navigation, full_names: Mapping[str, Thing], random: Random) -> Navigation | None:
    """Return the meaning with a distinct name for each of its things, or None if that is not possible.

    Args:
        meaning: whose things have identities.
        full_names: by identity, a name with all that can be seen of a landmark.
        random: draws the words.
    """
    counts = _counts(meaning)
    many = frozenset(kind for kind, number in counts.items() if number > 1)
    target = meaning.target.identity
    named: dict[str, Thing] = {}
    steps = sum(1 for _ in mentions(replace(meaning, target=Thing(""))))
    count = 0

    def name(thing: Thing) -> Thing:
        nonlocal count
        count += 1
        if thing.identity in named:
            earlier = named[thing.identity]
            if (earlier.kind, earlier.number) != (thing.kind, thing.number):
                raise NoDistinctName(thing.identity)
            return replace(earlier, where=thing.where)
        if thing.kind in many and thing.identity in full_names and thing.identity != target:
            full = full_names[thing.identity]
            thing = replace(thing, colour=full.colour, look=full.look)
            before = [other for other in named.values() if other.kind == thing.kind]
            is_next = count < steps and counts[thing.kind] == 2 and _may_be_next(thing, before)
            if is_next and random.random() < COUNTED_ON_SHARE:
                named[thing.identity] = thing = replace(thing, colour="", look="", which="next")
                return thing
        named[thing.identity] = distinct = _distinct_name(thing, named, random, is_step=count < steps)
        return distinct

    try:
        renamed = map_mentions(meaning, name)
    except NoDistinctName:
        return None
    assert isinstance(renamed, Navigation)
    return renamed


def _counts(meaning: Navigation) -> dict[str, int]:
    """Return how many things of each kind an instruction mentions."""
    seen: dict[str, set[str]] = {}
    for thing in mentions(meaning):
        seen.setdefault(thing.kind, set()).add(thing.identity)
    return {kind: len(identities) for kind, identities in seen.items()}


def _may_be_next(thing: Thing, earlier: list[Thing]) -> bool:
    """Return whether a thing may be called the next one of its kind after another."""
    is_one = not thing.which and not thing.number and thing.kind not in NOT_COUNTED_ON
    return is_one and len(earlier) == 1 and not earlier[0].which and not earlier[0].number


def _distinct_name(thing: Thing, named: Mapping[str, Thing], random: Random, *, is_step: bool) -> Thing:
    """Return a thing under a name that matches none of the things named before.

    Raises:
        Indistinct: if there is no such name.
    """
    alike = [other for other in named.values() if _may_be_taken_for(thing, other)]
    if not alike:
        return thing
    if thing.which or thing.number or any(other.number for other in alike):
        raise NoDistinctName(thing.identity)
    if thing.kind in PLACES:
        return replace(thing, which="next")
    return replace(thing, which="next" if is_step and random.random() < NEXT_SHARE else "another")


def _may_be_taken_for(thing: Thing, other: Thing) -> bool:
    """Return whether the names of two things are compatible: same kind, and no stated attribute differs."""
    return (
        thing.kind == other.kind
        and (not thing.colour or not other.colour or thing.colour == other.colour)
        and (not thing.look or not other.look or thing.look == other.look)
    )
