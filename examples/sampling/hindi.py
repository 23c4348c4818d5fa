"""Hindi instructions of the sample: the same content as in English, with Hindi grammar."""

import unicodedata
from collections.abc import Sequence
from random import Random
from typing import NamedTuple

from arramon_server.sim.catalogue import ObjectType
from examples.sampling.rooms import Order
from examples.sampling.routes import RouteLeg


class Noun(NamedTuple):
    """A noun in the singular: its direct and its oblique case, and whether it is feminine."""

    direct: str
    oblique: str
    feminine: bool


KINDS = {
    "ball": Noun("गेंद", "गेंद", True),
    "hourglass": Noun("रेतघड़ी", "रेतघड़ी", True),
    "mug": Noun("मग", "मग", False),
    "tv": Noun("टीवी", "टीवी", False),
    "book": Noun("किताब", "किताब", True),
    "bowl": Noun("कटोरा", "कटोरे", False),
    "bucket": Noun("बाल्टी", "बाल्टी", True),
}
PATTERNS = {"dotted": "बिंदीदार", "striped": "धारीदार"}
COLOURS = {
    "green": "हरा", "red": "लाल", "blue": "नीला", "white": "सफ़ेद", "yellow": "पीला", "brown": "भूरा", "purple": "बैंगनी",
}  # fmt: skip


class Register(NamedTuple):
    """Verb forms of a form of address; an instruction uses one."""

    turn: str
    go: str
    walks: tuple[str, ...]
    pick_up: str
    put: str


NEUTRAL = Register("मुड़ें", "जाएँ", ("सीधे चलें", "सीधे चलते रहें"), "उठा लें", "रखें")
POLITE = Register("मुड़िए", "जाइए", ("सीधे चलिए", "सीधे चलते रहिए"), "उठा लीजिए", "रखिए")

TURNS = {1: "दाएँ", -1: "बाएँ", 2: "पीछे"}
ORDINALS = ("", "दूसरे ", "तीसरे ", "चौथे ")
PASSED = ("", "चौराहे से आगे निकलकर ", "दो चौराहों से आगे निकलकर ", "तीन चौराहों से आगे निकलकर ")
SIDES = {
    "+": "चौराहे पर",
    "L": "नुक्कड़ पर",
    "a": "गली में",
    "right": "सड़क के दाईं ओर",
    "left": "सड़क के बाईं ओर",
    "middle": "सड़क के बीच में",
}
RELATIONS = {
    "on_top_of": "के ऊपर",
    "left_of": "के बाईं ओर",
    "right_of": "के दाईं ओर",
    "behind": "के पीछे",
    "in_front_of": "के सामने",
}
PLAIN = {
    "ahead_1": "{it} पीली टाइल से एक खाना आगे {put}।",
    "ahead_2": "{it} पीली टाइल से दो खाने आगे {put}।",
    "brick_wall": "{it} ठीक सामने ईंट की दीवार से सटाकर {put}।",
    "turn_right": "दाएँ {turn} और {it} अपने ठीक सामने {put}।",
    "turn_left": "बाएँ {turn} और {it} अपने ठीक सामने {put}।",
}


def navigate(legs: Sequence[RouteLeg], target: ObjectType, side: str, random: Random) -> str:
    """Return the navigation instruction."""
    register = random.choice((NEUTRAL, POLITE))
    walk = random.choice(register.walks)
    sentences = []
    for number, leg in enumerate(legs):
        turn = ""
        if leg.turn and leg.into_alley:
            turn = f"{TURNS[leg.turn]} मुड़कर गली में {register.go} और "
        elif leg.turn:
            turn = f"{TURNS[leg.turn]} {register.turn} और "
        following = "अगले " if number else ""
        if leg.end == "+":
            where = f"{ORDINALS[leg.passed] or following}चौराहे तक "
        elif leg.end == "L":
            where = f"{PASSED[leg.passed]}{following}नुक्कड़ तक "
        else:
            where = PASSED[leg.passed]
        sentences.append(f"{turn}{where}{walk}।")
    lying = "रखी" if KINDS[target.kind].feminine else "रखा"
    sentences.append(f"{SIDES[side]} {lying} {name(target)} {register.pick_up}।")
    return unicodedata.normalize("NFC", " ".join(sentences))


def assemble(order: Order, target: ObjectType, random: Random) -> str:
    """Return the assembly instruction."""
    register = random.choice((NEUTRAL, POLITE))
    it = random.choice(("उसे", f"{KINDS[target.kind].oblique} को", f"{name(target, oblique=True)} को"))
    if order.landmark is None:
        text = PLAIN[order.relation].format(it=it, put=register.put, turn=register.turn)
    else:
        text = f"{it} {name(order.landmark, oblique=True)} {RELATIONS[order.relation]} {register.put}।"
    return unicodedata.normalize("NFC", text)


def name(thing: ObjectType, *, oblique: bool = False) -> str:
    """Return the object's name, for example "धारीदार लाल मग"; oblique before a postposition."""
    noun = KINDS[thing.kind]
    colour = agreeing(COLOURS[thing.colour], noun.feminine, oblique)
    return f"{PATTERNS[thing.pattern]} {colour} {noun.oblique if oblique else noun.direct}"


def agreeing(adjective: str, feminine: bool, oblique: bool) -> str:
    """Return an adjective (given: masculine direct case) in agreement with its noun: those in -ा are inflected."""
    if not adjective.endswith("ा"):
        return adjective
    return adjective[:-1] + ("ी" if feminine else "े" if oblique else "ा")
