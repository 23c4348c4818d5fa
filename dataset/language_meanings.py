"""Every kind of meaning that planners express, for the check of a language: each clause, thing and relation in turn."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

from arramon_client.world import BANNER_COLOURS, BANNER_SHAPES, FACADES, FURNITURE, SHOPS, WALLS
from arramon_lang.meaning import (
    PLACES,
    RELATIONS,
    TURN_POSITIONS,
    TURNS,
    WHICHES,
    Assembly,
    Face,
    Meaning,
    Navigation,
    Rotate,
    Step,
    Thing,
    Walk,
    Where,
)
from arramon_server.sim.assets.furniture import COLOURS
from arramon_server.sim.catalogue import ALL_TYPES

MUG = Thing("mug", "red", "dotted", identity="target")
BALL, BOOK = Thing("ball", "blue", "striped", identity="ball"), Thing("book", "green", "dotted", identity="book")
BENCH, TREE = Thing("bench", identity="bench"), Thing("tree", identity="tree")
CONE = Thing("cone", "red", identity="cone")
WALL = Thing("wall", look="brick", identity="wall")

STREET_RELATIONS = ("near", "behind", "in_front_of", "left_of", "right_of", "between", "on_top_of")
COUNTS = range(2, 21)


def all_meanings() -> Iterator[tuple[str, Meaning]]:
    """Yield each kind of meaning with a name; every further step or relation is one that every language has."""
    yield from ((name, Navigation((step,), MUG)) for name, step in _steps())
    yield from _things()
    yield from _references()
    yield from _targets()
    yield from _assemblies()


def _steps() -> Iterator[tuple[str, Step]]:
    """Yield each clause, with each value of its attributes, alone and with two and several things."""
    for direction in TURNS:
        yield f"turn {direction}", Rotate(direction)
        for at, thing in product(TURN_POSITIONS, _landmarks()):
            yield f"turn {direction} {at} {_called(thing)}", Rotate(direction, at, thing)
    for thing in _landmarks():
        yield f"face {_called(thing)}", Face(thing)
        for way, side in product(("to", "towards", "past"), ("", "left", "right")):
            if way == "past" or not (thing.number and side):
                yield f"walk {way} {_called(thing)} {side}", Walk(way, (thing,), side)
                yield f"walk {way} {_called(thing)} {side}, not straight", Walk(way, (thing,), side, straight=False)
    for way, thing in product(("to", "towards"), (BENCH, CONE)):
        yield f"walk {way} {_called(thing)}, far", Walk(way, (thing,), far=True)
    for thing in (BENCH, CONE):
        yield f"walk until {_called(thing)}", Walk("until", (thing,))
        for side in ("left", "right"):
            yield f"walk beside {_called(thing)} {side}", Walk("beside", (thing,), side)
    yield "walk ahead", Walk("ahead")
    for count in COUNTS:
        yield f"walk ahead {count}", Walk("ahead", count=count)
    for kind, side in product(("wall", "street", "alley", "building"), ("", "left", "right")):
        yield f"walk along {kind} {side}", Walk("along", (Thing(kind, identity="way"),), side)
    for one, other in ((BENCH, TREE), (CONE, BENCH), (BENCH, replace(BENCH, identity="bench 2"))):
        yield f"walk between {_called(one)} and {_called(other)}", Walk("between", (one, other))


def _landmarks() -> Iterator[Thing]:
    yield from (BENCH, CONE, replace(BENCH, number="two"), replace(CONE, number="several"))
    yield from (replace(BENCH, which=which) for which in ("second", "next"))
    yield from (Thing(kind, identity=kind) for kind in PLACES if kind != "building_corner")
    yield Thing("building_corner", look="brick", identity="building_corner")


def _things() -> Iterator[tuple[str, Meaning]]:
    """Yield each kind with each of its colours and looks, and with each of `WHICHES`."""
    things = [Thing(kind, colour) for kind in FURNITURE for colour in ("", *COLOURS.get(kind, ()))]
    things += [Thing("banner", colour, shape) for colour in BANNER_COLOURS for shape in ("", *BANNER_SHAPES)]
    things += [Thing("building", look=look) for look in ("", *FACADES)]
    things += [Thing("shop_sign", look=shop) for shop in SHOPS]
    things += [Thing("building_corner", look=look) for look in FACADES]
    things += [Thing(kind, which=which) for kind, which in product(("bench", "tree", "building", "street"), WHICHES)]
    for thing in dict.fromkeys(things):
        yield f"walk to {_called(thing)}", Navigation((Walk("to", (replace(thing, identity="thing"),)),), MUG)
    for look in WALLS:
        wall = Thing("wall", look=look, identity="wall")
        yield f"put against {_called(wall)}", Assembly((), MUG, (Where("against", (wall,)),))
    for type_ in ALL_TYPES:
        target = Thing(type_.kind, type_.colour, type_.pattern, identity="target")
        yield f"pick up {_called(target)}", Navigation((Rotate("left"),), target)
        landmark = replace(target, identity="landmark")
        yield f"put near {_called(landmark)}", Assembly((), Thing("", identity="mug"), (Where("near", (landmark,)),))


def _references() -> Iterator[tuple[str, Meaning]]:
    """Yield each clause for the thing that the clause before it mentioned, and for another of its kind."""
    for thing in (BENCH, CONE, Thing("intersection", identity="place"), replace(BENCH, number="two")):
        before = Walk("towards", (thing,))
        steps: list[Step] = [
            Walk("to", (thing,)),
            Walk("past", (thing,)),
            *(Rotate("left", at, thing) for at in TURN_POSITIONS),
        ]
        for step in steps:
            yield f"towards {_called(thing)}, then {_named(step)} it", Navigation((before, step), MUG)
        if not thing.number:
            another = replace(thing, which="another", identity="another")
            yield f"towards {_called(thing)}, then another", Navigation((before, Walk("past", (another,))), MUG)
    three = (Rotate("right"), Walk("past", (BENCH,)), Rotate("left", "at", TREE), Walk("to", (CONE,)))
    yield "four steps", Navigation(three, replace(MUG, where=(Where("near", (CONE,)),)))


def _targets() -> Iterator[tuple[str, Meaning]]:
    """Yield each relation of the target to things in the street."""
    for relation in STREET_RELATIONS:
        for where in _wheres(relation, BENCH, TREE):
            target = replace(MUG, where=(where,))
            yield f"pick up {_described(where)}", Navigation((Rotate("left"),), target)
    for one, other in product(("near", "behind", "left_of"), ("in_front_of", "right_of")):
        both = (Where(one, (BENCH,)), Where(other, (TREE,)))
        yield f"pick up {one} and {other}", Navigation((Rotate("left"),), replace(MUG, where=both))
    for relation in ("near", "behind", "in_front_of"):
        nested = replace(BENCH, where=(Where(relation, (TREE,)),))
        yield f"walk to a bench {relation} a tree", Navigation((Walk("to", (nested,)),), MUG)
        target = replace(MUG, where=(Where("near", (nested,)),))
        yield f"pick up near a bench {relation} a tree", Navigation((Rotate("left"),), target)


def _assemblies() -> Iterator[tuple[str, Meaning]]:
    """Yield each relation in the room, each description of the object to place, and turns."""
    for relation in RELATIONS:
        for where in _wheres(relation, BALL, BOOK):
            if relation == "against":
                where = replace(where, things=(WALL,))
            for thing in (MUG, Thing("", identity="mug")):
                yield f"put {thing.kind} {_described(where)}", Assembly((), thing, (where,))
    for relation in ("left_of", "right_of", "in_front_of", "near"):
        own = Where(relation, (Thing("you"),))
        yield f"put {_described(own)}", Assembly((), MUG, (own,))
    for relation in ("near", "behind", "left_of", "in_front_of"):
        both = (Where("against", (WALL,)), Where(relation, (BALL,)))
        yield f"put against and {relation}", Assembly((), MUG, both)
        nested = replace(BALL, where=(Where(relation, (BOOK,)),))
        yield f"put on a ball {relation} a book", Assembly((), MUG, (Where("on_top_of", (nested,)),))
    yield (
        "put against, near, behind",
        Assembly((), MUG, (Where("against", (WALL,)), Where("near", (BALL,)), Where("behind", (BOOK,)))),
    )
    yield "put between a ball and a wall", Assembly((), MUG, (Where("between", (BALL, WALL)),))
    behind = Where("behind", (BALL,))
    for thing in (Thing("mug", identity="mug"), Thing("mug", "red", identity="mug"), MUG):
        yield f"put {_called(thing)}", Assembly((), thing, (behind,))
    for direction in TURNS:
        yield f"turn {direction} and put", Assembly((direction,), MUG, (behind,))
        yield f"turn {direction} and put it", Assembly((direction,), Thing("", identity="mug"), (behind,))


def _wheres(relation: str, one: Thing, other: Thing) -> Iterator[Where]:
    if relation == "between":
        yield Where(relation, (one, other))
        yield Where(relation, (one, replace(one, identity="second")))
        return
    yield Where(relation, (one,))
    if relation != "near":
        yield Where(relation, (one,), exactly=True)
    if relation in ("near", "behind", "in_front_of", "left_of", "right_of") and one is BENCH:
        yield Where(relation, (replace(one, number="two"),))


def _called(thing: Thing) -> str:
    return " ".join(filter(None, (thing.number, thing.which, thing.look, thing.colour, thing.kind)))


def _described(where: Where) -> str:
    return f"{'exactly ' if where.exactly else ''}{where.relation} {' and '.join(map(_called, where.things))}"


def _named(step: Step) -> str:
    return f"turn {step.at}" if isinstance(step, Rotate) else f"walk {step.way}" if isinstance(step, Walk) else "face"
