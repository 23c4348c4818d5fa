"""Mentions of things in a meaning: iteration, replacement, and co-reference."""

from collections.abc import Callable, Iterator
from dataclasses import replace

from arramon_lang.meaning import Assembly, Face, Meaning, Navigation, Rotate, Step, Thing, Where


def mentions(meaning: Meaning) -> Iterator[Thing]:
    """Yield every thing that a meaning mentions, in order; each thing before the landmarks of its relations."""
    if isinstance(meaning, Navigation):
        for step in meaning.steps:
            for thing in things_of(step):
                yield from _with_landmarks(thing)
        yield from _with_landmarks(meaning.target)
    else:
        yield from _with_landmarks(meaning.thing)
        for where in meaning.where:
            for thing in where.things:
                yield from _with_landmarks(thing)


def things_of(step: Step) -> tuple[Thing, ...]:
    """Return the things that a step refers to."""
    if isinstance(step, Rotate):
        return () if step.thing is None else (step.thing,)
    return (step.thing,) if isinstance(step, Face) else step.things


def map_mentions(meaning: Meaning, change: Callable[[Thing], Thing]) -> Meaning:
    """Return a copy of a meaning with `change` applied to every mention, in the order of `mentions`.

    `change` receives a thing with its original relations; the landmarks in its result are then changed in turn.
    """
    if isinstance(meaning, Navigation):
        steps = tuple(_map_step(step, change) for step in meaning.steps)
        return Navigation(steps, _map_thing(meaning.target, change))
    thing = _map_thing(meaning.thing, change)
    return Assembly(meaning.turns, thing, tuple(_map_where(where, change) for where in meaning.where))


def first_mentions(meaning: Meaning) -> tuple[int, ...]:
    """Return, for each mention, the index of the first mention of the same thing, as far as identities are known.

    A mention without an identity counts as the first mention of a new thing.
    """
    firsts: dict[str, int] = {}
    return tuple(
        firsts.setdefault(thing.identity, number) if thing.identity else number
        for number, thing in enumerate(mentions(meaning))
    )


def repeats(thing: Thing, earlier: Thing) -> bool:
    """Return whether a name repeats an earlier thing's, in full or with fewer words ("the bench", "the red bench")."""
    if (thing.kind, thing.number) != (earlier.kind, earlier.number) or not thing.kind:
        return False
    return (
        thing.which not in ("next", "another")
        and thing.colour in ("", earlier.colour)
        and thing.look in ("", earlier.look)
        and thing.which in ("", earlier.which)
        and thing.where in ((), earlier.where)
    )


def _with_landmarks(thing: Thing) -> Iterator[Thing]:
    yield thing
    for where in thing.where:
        for landmark in where.things:
            yield from _with_landmarks(landmark)


def _map_step(step: Step, change: Callable[[Thing], Thing]) -> Step:
    if isinstance(step, Rotate):
        return step if step.thing is None else replace(step, thing=_map_thing(step.thing, change))
    if isinstance(step, Face):
        return Face(_map_thing(step.thing, change))
    return replace(step, things=tuple(_map_thing(thing, change) for thing in step.things))


def _map_thing(thing: Thing, change: Callable[[Thing], Thing]) -> Thing:
    changed = change(thing)
    return replace(changed, where=tuple(_map_where(where, change) for where in changed.where))


def _map_where(where: Where, change: Callable[[Thing], Thing]) -> Where:
    return replace(where, things=tuple(_map_thing(thing, change) for thing in where.things))
