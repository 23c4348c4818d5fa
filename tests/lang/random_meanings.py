"""Random meanings for tests of writing and reading, covering everything that planners may express."""

from collections.abc import Iterable
from dataclasses import replace
from random import Random

from arramon_lang.coreference import map_mentions, repeats
from arramon_lang.meaning import (
    NUMBERS,
    PLACES,
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

KINDS = ("ball", "hourglass", "mug", "tv", "book", "bowl", "bucket")
COLOURS = ("green", "red", "blue", "white", "yellow", "brown", "purple")
PATTERNS = ("dotted", "striped")
FURNITURE: dict[str, tuple[str, ...]] = {
    "cone": ("orange", "red", "blue"),
    "dumpster": ("green", "silver"),
    "barrier": ("concrete", "white", "red"),
    "barrel": ("red", "yellow", "gold"),
    **dict.fromkeys(
        (
            "phone_booth",
            "bench",
            "lamp_post",
            "traffic_light",
            "tyre_stack",
            "hydrant",
            "mailbox",
            "bin",
            "bags",
            "tree",
        ),
        (),
    ),
    "stop_sign": (),
    "speed_sign": (),
}
"""Colours of each kind of street furniture."""

BANNER_COLOURS = ("red", "blue", "green", "yellow", "white", "black")
BANNER_SHAPES = ("star", "diamond", "triangle", "circle", "hexagon", "dot")
FACADES = ("brick", "brown", "concrete", "glass", "white", "arched", "red", "grey")
WALLS = ("wood", "brick", "spotted", "striped")

_OTHER = "other"
"""Placeholder identity of the second of two things with one name."""

_STREET_RELATIONS = ("near", "behind", "in_front_of", "left_of", "right_of", "between")
_ROOM_RELATIONS = ("on_top_of", "left_of", "right_of", "in_front_of", "behind", "between", "near", "diagonal_to")


def navigation(random: Random) -> Navigation:
    """Return a random navigation instruction of up to eight steps."""
    things: list[Thing] = []
    steps: list[Step] = []
    for _ in range(random.choice((1, 2, 2, 3, 3, 4, 4, 5, 6, 8))):
        step = _step(random, things)
        if not steps or not _is_unclear_after(step, steps[-1]):
            steps.append(step)
    if isinstance(steps[-1], Walk) and steps[-1].way == "between":
        steps.append(Walk("ahead"))  # "After moving between two things, get the ball" may say where the ball is.
    places = things[-1:] if things and random.random() < 0.4 else []
    where = tuple(_where(random, _STREET_RELATIONS, places) for _ in range(random.choice((0, 1, 1, 1, 2))))
    meaning = with_identities(Navigation(tuple(steps), collectible(random, where)))
    assert isinstance(meaning, Navigation)
    return meaning


def _is_unclear_after(step: Step, last: Step) -> bool:
    """Return whether a step repeats the last one, or turns on the spot right after a turn at a thing.

    Nobody can tell of the latter which turn "at it" belongs to, and no planner has both.
    """
    is_second_turn = isinstance(step, Rotate) and not step.at and isinstance(last, Rotate) and bool(last.at)
    return step == last or is_second_turn


def assembly(random: Random) -> Assembly:
    """Return a random assembly instruction."""
    turns = (random.choice(TURNS),) if random.random() < 0.3 else ()
    wheres = [_room_where(random) for _ in range(random.choice((1, 1, 1, 2)))]
    kind = random.choice(KINDS)
    thing = random.choice((collectible(random), Thing(kind), Thing(kind, random.choice(COLOURS)), Thing("")))
    meaning = with_identities(Assembly(turns, thing, tuple(dict.fromkeys(wheres))))
    assert isinstance(meaning, Assembly)
    return meaning


def with_identities(meaning: Meaning) -> Meaning:
    """Return a meaning with identities: mentions that repeat a name share the identity and the full description."""
    named: list[Thing] = []

    def identify(thing: Thing) -> Thing:
        earlier = next((each for each in reversed(named) if repeats(thing, each)), None)
        if earlier is not None and earlier.where != thing.where:
            return identify(replace(thing, which="next"))
        others = any(each.kind == thing.kind and each is not earlier for each in named)
        if others and earlier is not None and earlier.which in ("next", "another"):
            # It would be "that tree" from now on, which is clear only if no other tree is named.
            return identify(replace(thing, which="next"))
        if earlier is None or thing.identity == _OTHER:
            earlier = replace(thing, identity=str(len(named) + 1))
            named.append(earlier)
        return earlier

    return map_mentions(meaning, identify)


def meanings(random: Random, count: int) -> Iterable[Meaning]:
    """Yield `count` random instructions of each kind, alternating."""
    for _ in range(count):
        yield navigation(random)
        yield assembly(random)


def collectible(random: Random, where: tuple[Where, ...] = ()) -> Thing:
    """Return a random collectible with pattern and colour."""
    return Thing(random.choice(KINDS), random.choice(COLOURS), random.choice(PATTERNS), where=where)


def landmark(random: Random, nested: float = 0.05) -> Thing:
    """Return a random landmark in the street, with random detail.

    Args:
        random: draws it.
        nested: probability of a relation; if it is 0, the landmark is not called "next" or "another" either.
    """
    if random.random() < 0.15:
        return Thing("banner", random.choice(BANNER_COLOURS), random.choice(("", *BANNER_SHAPES)))
    if random.random() < 0.12:
        return Thing("building", look=random.choice(("", *FACADES)))
    kind = random.choice(tuple(FURNITURE))
    which = ""
    if random.random() < 0.15:
        which = random.choice(WHICHES[1:] if nested else WHICHES[1:-2])
    colour = random.choice(("", *FURNITURE[kind]))
    where = (Where(random.choice(_STREET_RELATIONS[:3]), (landmark(random, 0.0),)),) if random.random() < nested else ()
    return Thing(kind, colour, which=which, where=where)


def _step(random: Random, things: list[Thing]) -> Step:
    draw = random.random()
    if draw < 0.25:
        return Rotate(random.choice(TURNS))
    thing = random.choice(things[-2:]) if things and random.random() < 0.25 else landmark(random)
    if random.random() < 0.25:
        kind = random.choice(PLACES)
        which = random.choice(("", "", "first", "second", "next", "another")) if kind != "building_corner" else ""
        look = "" if which or kind != "building_corner" else random.choice(FACADES)
        thing = Thing(kind, look=look, which=which, arms=random.choice((3, 4)) if kind == "intersection" else 0)
    elif random.random() < 0.15 and not thing.where and thing.which in ("", "next"):
        thing = replace(thing, number=random.choice(NUMBERS[1:]))
    repeatable = [thing] if thing.which not in ("next", "another") and not thing.where else []
    if draw < 0.45:
        things += repeatable
        return Rotate(random.choice(TURNS), random.choice((*TURN_POSITIONS, "at")), thing)
    if draw < 0.55:
        things += repeatable
        return Face(thing)
    if draw < 0.63:
        return Walk("ahead", count=random.choice((0, 0, 0, random.randint(2, 20))))
    if draw < 0.7:
        thing = replace(thing, number="", which="")
        other = random.choice((thing, landmark(random, 0.0)))
        return Walk("between", _two(thing, other))
    things += repeatable
    side = random.choice(("", "", "left", "right"))
    if draw > 0.9 and not thing.number:
        return Walk("beside", (thing,), random.choice(("left", "right")))
    if draw > 0.85 and not thing.number:
        return Walk("until", (thing,))
    if draw > 0.82:
        return Walk("along", (Thing(random.choice(("wall", "street", "alley", "building"))),), side)
    way = random.choice(("to", "towards", "past", "past"))
    return Walk(way, (thing,), side if way == "past" or not thing.number else "")


def _two(one: Thing, other: Thing) -> tuple[Thing, Thing]:
    """Return two things for one phrase, with different identities if the second repeats the first's name."""
    return one, replace(one, identity=_OTHER) if repeats(other, one) else other


def _where(random: Random, relations: tuple[str, ...], things: list[Thing]) -> Where:
    relation = random.choice(relations)
    if relation == "between":
        return Where(relation, _two(landmark(random, 0.0), landmark(random, 0.0)))
    return Where(relation, (random.choice(things) if things else landmark(random),), random.random() < 0.1)


def _room_where(random: Random, nested: float = 0.06) -> Where:
    wall = Thing("wall", look=random.choice(WALLS))
    if random.random() < 0.25:
        return Where("against", (wall,))
    relation = random.choice(_ROOM_RELATIONS)
    if relation == "between":
        return Where(relation, _two(collectible(random), random.choice((wall, collectible(random)))))
    if random.random() < 0.1 and relation in ("left_of", "right_of", "in_front_of", "near"):
        return Where(relation, (Thing("you"),), random.random() < 0.3)
    where = (_room_where(random, 0.0),) if random.random() < nested else ()
    return Where(relation, (collectible(random, where),), random.random() < 0.15)
