"""Faults in the sides of things, and in crossings beside targets, that navigation texts state, against the street.

Independent of planner and gate: it uses the words for left, right and next to, and the files of a data set. A side is
true if the thing is on that side of the walker, by the direction of the path there, between the turns that the text
mentions before and after it. A target said to be next to a zebra crossing must not lie on it.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from benchmarks.instructions.mentions import ThingMention, mentions, plain
from benchmarks.instructions.turn_paths import MIN_BEND, MIN_STATED_BEND, Bend, NavigationPath, Place, rectangle

SIDES = {
    "en": {"left": "left", "right": "right"},
    "hi": {
        "बाएँ": "left", "बाईं": "left", "बायाँ": "left", "बाएं": "left",
        "दाएँ": "right", "दाईं": "right", "दायाँ": "right", "दाएं": "right",
    },
}  # fmt: skip
"""Words for sides."""

NO_SIDE = {
    "en": r"(?<=left )right (?:before|after|past|beyond|by)\b|(?<=right )right (?:before|after|past|beyond|by)\b"
    r"|\bright (?:in front|next to|beside|behind|against|between)\b",
    "hi": r"(?!)",
}
"""Phrases with such a word that state no side."""

RELATION = {
    "en": r"\b(?:left|right)(?: hand)?(?: side)? of\b|\bits (?:left|right)\b",
    "hi": r"(?:के|की|(?<!पास )से|उसके|उसकी|जिसके|जिसकी)(?: ठीक)? (?:बाएँ|बाईं|दाएँ|दाईं)"
    r"(?!(?: ओर| तरफ़| हाथ| दिशा में)? (?:मुड़|घूम))(?: ओर| तरफ़| हाथ| दिशा में)?",
}
"""Relations between two things: "left of it", and no turn, as in "from there turn left"."""

SLIGHT = {
    "en": r"(?:slight|slightly|a bit|a little|gentle|bear|bearing|veer|veering)(?: to (?:the|your))?$",
    "hi": r"(?:थोड़ा|सा|ज़रा|हल्का|हल्के|(?:हल्के|ज़रा|थोड़े|धीरे|मामूली) से|मामूली)$",
}
"""Words before the side of a slight turn."""

TOLD_SIDE = {
    "en": re.compile(r"\b(?:on|to) (?:your |the )?(left|right)\b(?! hand side of| side of| of)"),
    "hi": re.compile(r"(बाईं|दाईं) (?:ओर|तरफ़)"),
}

AFTER_THING = re.compile(r"(?: (?:with|showing) (?:an? )?\S+)?(?: is| keeping it)? ?")
"""Words allowed between a noun and the side of its thing, in English."""

AHEAD = r" (?:आएगा|आएगी|मिलेगा|मिलेगी|पड़ेगा|पड़ेगी|दिखेगा|दिखेगी|है) (?:उससे|उसके|उसे पीछे|उसकी|उसी|वहाँ तक)"
"""Words after a thing at the side that one will pass or reach, in Hindi: बाईं ओर बेंच आएगी, उससे आगे."""

BACK = {
    "en": r"\b(?:turn\w*|spin\w*|about|pivot\w*) (?:yourself )?(?:around|turn)\b|(?:other|opposite) (?:way|direction)"
    r"|revers\w+ direction",
    "hi": r"(?:पीछे(?: की ओर| की तरफ़)?|पूरा पीछे|उल्टी दिशा में|उल्टी तरफ़) (?:मुड़|घूम|पलट)|पलटकर|उल्टे मुड़|यू टर्न"
    r"|मुँह (?:पीछे|उल्टी)|वापस (?:मुड़|घूम)|(?<!के )(?<!ठीक )पीछे (?:\S+ ){1,6}की (?:ओर|तरफ़) (?:मुड़|घूम|मुँह)",
}
"""Phrases for turning around."""

FACED = {
    "en": r"^(?:\w+ ){0,2}?(?:fac(?:e|ing)|turn\w* (?:\S+ ){0,3}?(?:towards?|fac(?:e|ing)|see|direction)|look\w*"
    r"|align\w*|orient\w*|position\w*|direct\w*|rotat\w+ (?:to|until)|point\w*)\b",
    "hi": r"^(?:\S+ ){0,7}?(?:की (?:ओर|तरफ़|दिशा में) (?:मुड़|घूम|मुँह|रुख़|नज़र)|अपना मुँह|सामने न|जब तक|तब तक)",
}
"""Phrases at the beginning of a text for turning towards a thing."""

STREETS = ("street", "alley")
"""Kinds of things that one turns into: their side is that of the turn."""

ON_GROUND = {"zebra_crossing": (4.55 / 2, 1.4 / 2)}
"""Kinds of things on which others can lie, with half their sizes across and along their heading, in units."""

BY = {
    "en": r"(?:next to|near|beside|close to|adjacent to|alongside|at the side of|side by side with|adjoining|over by"
    r"|proximity to|front of|ahead of|behind|(?:left|right)(?: hand)?(?: side)? of|side of|back of)$",
    "hi": r"^ ?(?:(?:के|की) (?:ठीक |ही )?(?:पास|बगल|नज़दीक|क़रीब|बराबर|साथ|समीप|सामने|आगे|पीछे|पिछली|बाईं|दाईं|बाएँ"
    r"|दाएँ)|से (?:बाईं|दाईं))(?! (?:से|तक|पहुँच|जाकर|आकर|रुक|मुड़|घूम|छूट|छोड़))",
}
"""Phrases for being next to a thing: before its noun phrase in English, after it in Hindi."""

START_LENGTH = 2.5
"""Length of the path within which a walker told to face a thing at the start has turned to it, in units."""

MAX_SIDESTEP, AROUND, MAY_BE_AROUND = 4.5, 165.0, 120.0
"""Maximum length of a step aside, in units; a turn by more degrees may be called one to either side, and one around."""

IN_NOUN = 14
"""Maximum number of letters of a Hindi noun phrase before the words that `mentions` finds."""

LAST_MENTIONS = 3
"""Number of last mentions that may describe the target's place."""


@dataclass(frozen=True)
class StatedSide:
    """A thing with its stated side, the stated turns around it, and whether the text begins by facing a thing."""

    mention: ThingMention
    side: str
    before: tuple[str, ...]
    after: tuple[str, ...]
    faced: bool


def stated_sides(text: str, code: str) -> list[StatedSide]:
    """Return the things on the way whose side a text states, in order."""
    text, named_things = plain(text, code), list(mentions(text, code))
    aside = [
        (match, found)
        for match in TOLD_SIDE[code].finditer(text)
        if (found := _thing_of(text, code, named_things, match))
    ]
    taken = [match.span() for match, _ in aside]
    for pattern in (RELATION[code], NO_SIDE[code]):
        taken += [match.span() for match in re.finditer(pattern, text)]
    turns = []
    for match in re.finditer("|".join(rf"(?<!\S){word}(?!\S)" for word in SIDES[code]), text):
        if not any(first <= match.start() < last for first, last in taken):
            slight = re.search(SLIGHT[code], text[: match.start()].strip()) is not None
            turns.append((match.start(), f"{'slightly ' if slight else ''}{SIDES[code][match[0]]}"))
    turns = sorted([*turns, *((match.start(), "around") for match in re.finditer(BACK[code], text))])
    faced = re.match(FACED[code], text)
    is_faced = faced is not None and (not turns or faced.end() <= turns[0][0])
    return [
        StatedSide(
            found,
            SIDES[code][match[1]],
            tuple(turn for at, turn in turns if at < match.start()),
            tuple(turn for at, turn in turns if at > match.start()),
            is_faced,
        )
        for match, found in aside
    ]


def _thing_of(text: str, code: str, named_things: Sequence[ThingMention], match: re.Match[str]) -> ThingMention | None:
    """Return the mention that side words refer to; None if they describe a turn, or a relation of two things."""
    before = [mention for mention in named_things if mention.end <= match.start()]
    lead, rest = text[: match.start()], text[match.end() :]
    found = None
    if code == "en":
        is_it = re.search(r"\bit(?: is)? $", lead) is not None and re.search(r"\bat it $", lead) is None
        if before and (is_it or AFTER_THING.fullmatch(text[before[-1].end : match.start()])):
            found = before[-1]
    elif re.search(r"(?:के|की|से|उसके|उसकी)(?: ठीक)? $", lead) is None or re.match(r" (?:न आ|आने)", rest):
        joined = re.match(r" (?:वाला|वाले|वाली|के|की|का) ", rest)
        following = [mention for mention in named_things if mention.end > match.end()]
        if joined and following and following[0].start <= match.end() + joined.end() + IN_NOUN:
            found = following[0]
        elif following and re.match(AHEAD, text[following[0].end :]) and not joined:
            is_turn = re.match(r" (?:मुड़|घूम)", rest) is not None
            found = None if is_turn or following[0].start > match.end() + IN_NOUN else following[0]
        elif before and (re.match(r" (?:रख|छोड़|न आ|आने)", rest) or (" जो " in lead and re.match(r" है", rest))):
            found = before[-1]
    return None if found is None or found.kind in STREETS else found


def applicable_spans(stated: StatedSide, way: NavigationPath) -> Iterator[tuple[float, float]]:
    """Yield the parts of a path where a stated side may apply: between the bends that match the turns around it.

    Turns are matched so that the fewest bends and turns are left over. A sidestep need not be stated, and the last turn
    need not match a bend, as it may be made at the target.
    """
    turns = [turn for turn in (*stated.before, *stated.after) if not turn.startswith("slightly")]
    number = sum(not turn.startswith("slightly") for turn in stated.before)
    bends = [
        bend for bend in way.bends if abs(bend.angle) >= MIN_BEND and not (stated.faced and bend.end <= START_LENGTH)
    ]
    found: list[tuple[int, tuple[Bend, ...]]] = []
    for listed in (bends, _without_steps_aside(bends)):
        for count in {len(turns), max(len(turns) - 1, 0)}:
            for chosen in combinations(listed, count):
                if all(map(_may_be, turns, chosen)):
                    unstated = sum(bend not in chosen for bend in listed if abs(bend.angle) >= MIN_STATED_BEND)
                    found.append((unstated + len(turns) - count, chosen))
    fewest = min((left_over for left_over, _ in found), default=0)
    for left_over, chosen in found:
        if left_over == fewest and number <= len(chosen):
            yield (
                chosen[number - 1].start if number else 0.0,
                chosen[number].end if number < len(chosen) else way.length,
            )


def _without_steps_aside(bends: Sequence[Bend]) -> list[Bend]:
    """Drop bends that the next one reverses at once."""
    kept: list[Bend] = []
    for bend in bends:
        if kept and bend.start - kept[-1].end <= MAX_SIDESTEP and abs(bend.angle + kept[-1].angle) < MIN_BEND:
            kept.pop()
        else:
            kept.append(bend)
    return kept


def _may_be(turn: str, bend: Bend) -> bool:
    if turn == "around" or abs(bend.angle) > AROUND:
        return abs(bend.angle) > MAY_BE_AROUND
    return (turn == "right") == (bend.angle > 0.0)


def side_faults(
    text: str, code: str, way: NavigationPath, grounds: Sequence[tuple[ThingMention, list[Place]]]
) -> list[str]:
    """Return a fault message for each stated side of a thing that is false.

    Args:
        text: an instruction of navigation.
        code: of its language.
        way: path of the turn.
        grounds: all things in the street, each as a mention with its outline.
    """
    faults = []
    for stated in stated_sides(text, code):
        fitting = [ground for thing, ground in grounds if _fits(stated.mention, thing)]
        spans = list(applicable_spans(stated, way))
        if spans and not any(way.is_passed(ground, stated.side, *span) for ground in fitting for span in spans):
            faults.append(f"{stated.mention.words} {stated.mention.kind} is not passed on the {stated.side}".strip())
    return faults


def crossing_faults(
    text: str, code: str, target: Place, grounds: Sequence[tuple[ThingMention, list[Place]]]
) -> tuple[int, list[str]]:
    """Check the zebra crossings that a text states to be next to its target.

    Returns:
        Their number, and a fault message for each on which the target lies.
    """
    text, named_things = plain(text, code), list(mentions(text, code))
    count, faults = 0, []
    for mention in named_things[-LAST_MENTIONS:]:
        around = text[: mention.start].strip() if code == "en" else text[mention.end :]
        if mention.kind not in ON_GROUND or re.search(BY[code], around) is None:
            continue
        count += 1
        if any(_fits(mention, thing) and contains_place(ground, target) for thing, ground in grounds):
            faults.append(f"the target lies on the {mention.kind}, not by it")
    return count, faults


def things_in_street(turn: dict[str, Any], section: dict[str, Any]) -> list[tuple[ThingMention, list[Place]]]:
    """Return all things in a turn's street, each as a mention with its corners or its place."""
    found = []
    for prop in section["props"]:
        place = prop["x"], prop["z"]
        halves = ON_GROUND.get(prop["kind"])
        ground = [place] if halves is None else rectangle(*place, prop["heading"], halves)
        found.append((_named(prop["kind"], prop["colour"], prop["shape"]), ground))
    for item in turn["street"]:
        kind, (x, _, z) = item["type"], item["position"]
        found.append((_named(kind["kind"], kind["colour"], kind["pattern"]), [(x, z)]))
    for house in section["buildings"]:
        halves = house["half_width"], house["half_length"]
        found.append(
            (_named("building", "", house["facade"]), rectangle(house["x"], house["z"], house["heading"], halves))
        )
    return found


def contains_place(ground: Sequence[Place], place: Place) -> bool:
    """Return whether a place lies on a rectangle."""
    inside = [
        (b[0] - a[0]) * (place[1] - a[1]) - (b[1] - a[1]) * (place[0] - a[0])
        for a, b in zip(ground, [*ground[1:], ground[0]], strict=True)
    ]
    return all(each <= 0.0 for each in inside) or all(each >= 0.0 for each in inside)


def _named(kind: str, colour: str, look: str) -> ThingMention:
    return ThingMention(kind, colour, look, "", False, "")


def _fits(stated: ThingMention, thing: ThingMention) -> bool:
    is_colour = stated.colour in ("", thing.colour) or thing.kind == "building"  # Its look has the colour.
    return stated.kind == thing.kind and is_colour and stated.look in ("", thing.look)
