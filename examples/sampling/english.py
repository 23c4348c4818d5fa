"""English instructions of the sample."""

from collections.abc import Sequence
from random import Random

from arramon_server.sim.catalogue import ObjectType
from examples.sampling.rooms import Order
from examples.sampling.routes import RouteLeg

TURNS = {0: "", 1: "turn right", -1: "turn left", 2: "turn around"}
WALKS = ("walk forward", "go straight", "walk straight ahead")
PICKS = ("Pick it up.", "Collect it.", "Grab it.")
PLACES = {"+": "intersection", "L": "corner"}
PASSED = ("", "past the intersection ", "past two intersections ", "past three intersections ")
ORDINALS = ("", "second ", "third ", "fourth ")
SIDES = {
    "+": "at the intersection",
    "L": "at the corner",
    "a": "in the alley",
    "right": "on the right side of the street",
    "left": "on the left side of the street",
    "middle": "in the middle of the street",
}
RELATIONS = {
    "on_top_of": "on top of",
    "left_of": "to the left of",
    "right_of": "to the right of",
    "behind": "behind",
    "in_front_of": "in front of",
}
PLAIN = {
    "ahead_1": "{put} {it} one space ahead of the yellow tile.",
    "ahead_2": "{put} {it} two spaces ahead of the yellow tile.",
    "brick_wall": "{put} {it} against the brick wall, straight ahead of you.",
    "turn_right": "Turn right and {put} {it} right in front of you.",
    "turn_left": "Turn left and {put} {it} right in front of you.",
}


def navigate(legs: Sequence[RouteLeg], target: ObjectType, side: str, random: Random) -> str:
    """Return the navigation instruction."""
    walk = random.choice(WALKS)
    sentences = []
    for number, leg in enumerate(legs):
        turn = TURNS[leg.turn] + (" into the alley" if leg.into_alley and leg.turn else "")
        go = f"{turn} and {walk}" if turn else walk
        if leg.end == "+":
            which = ORDINALS[leg.passed] or ("next " if number else "")
            where = f"to the {which}intersection"
        elif leg.end == "L":
            where = f"{PASSED[leg.passed]}to the {'next ' if number else ''}corner"
        else:
            where = f"{PASSED[leg.passed]}to the {name(target)} {SIDES[side]}"
        sentences.append(f"{go} {where}.")
    return " ".join(sentence[0].upper() + sentence[1:] for sentence in [*sentences, random.choice(PICKS)])


def assemble(order: Order, target: ObjectType, random: Random) -> str:
    """Return the assembly instruction."""
    it = random.choice(("it", f"the {spelt(target.kind)}", f"the {name(target)}"))
    put = random.choice(("put", "place"))
    if order.landmark is None:
        text = PLAIN[order.relation].format(put=put, it=it)
    else:
        text = f"{put} {it} {RELATIONS[order.relation]} the {name(order.landmark)}."
    return text[0].upper() + text[1:]


def name(thing: ObjectType) -> str:
    """Return the object's name, for example "striped red mug"."""
    return f"{thing.pattern} {thing.colour} {spelt(thing.kind)}"


def spelt(kind: str) -> str:
    """Return the kind as it is spelt in texts."""
    return "TV" if kind == "tv" else kind
