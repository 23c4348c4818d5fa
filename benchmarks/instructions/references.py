"""Count false references in generated navigation instructions: phrases for which the street holds no fitting thing.

    python -m benchmarks.instructions.references DATA [--split NAME ...] [--show N]

Written apart from the gate of generation: it sees only the files of a data set. It finds the nouns of things in a text
with what stands around them, and looks for objects that all of them can be, in order along the ground truth's path: one
that is called the same must be the same, another must be another, of two there must be two, and nothing may be left
behind long before it is mentioned. A text without such objects holds a false reference. So does one that names nothing
by the target, where another object looks like it.
"""

import argparse
import json
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import takewhile
from pathlib import Path
from typing import Any

from lang import load
from lang.grammar import INSIDE

FAR, PASSED, BEHIND, TOGETHER, BESIDE = 14.0, 4.0, 6, 9.0, 4.0
"""Maximum distance of a thing from the path, and of one that the path passes, in units; number of steps by which a
thing may lie behind when it is mentioned; maximum distance of two things from each other, and of the target from what
tells its place, in units."""

MARKERS = {
    "en": {
        "same": {"that", "same", "this"}, "other": {"another", "next"}, "two": {"both", "two"},
        "first": {"first"}, "second": {"second"}, "third": {"third"}, "": {"the", "a", "an"},
    },
    "hi": {
        "same": {"उस", "उसी", "वही", "वह", "यह", "इस", "इसी"}, "other": {"और_एक", "अगला", "अगले", "अगली"},
        "two": {"दोनों"}, "first": {"पहला", "पहले", "पहली"}, "second": {"दूसरा", "दूसरे", "दूसरी"},
        "third": {"तीसरा", "तीसरे", "तीसरी"}, "": {"एक"},
    },
}  # fmt: skip
"""Words before a noun that say which thing is meant."""

STRIPED = r"orange and white|white and orange|नारंगी-सफ़ेद|नारंगी और सफ़ेद"
WHITE = {"en": "white", "hi": "सफ़ेद"}
"""What a barrier of two colours is called, and the colour that the files give it."""

AWAY = {"en": r"(toward|towards|face|facing|direction of|see|spot|notice|for)$", "hi": r"^(की (ओर|तरफ़|दिशा)|दिख|न दिख)"}
"""What tells of a thing that one does not come to: before its noun phrase in English, behind it in Hindi."""

STANDING = frozenset({"parked", "खड़ी", "खड़ा", "खड़े"})
"""Words that may stand between a noun and its colour, and say nothing else."""

JOINING = frozenset({"with", "वाला", "वाले", "वाली"})
"""Words in looks that join other words too."""

LINKS = frozenset({"of", "in", "and", "has"})
"""Words in looks that may also be the last before a noun phrase."""

PLACES = ("intersection", "t_junction", "corner", "building_corner", "street", "alley", "square", "street_end")
SKIPPED = (*PLACES, "wall", "", "building", "you")
"""Kinds that the files do not list one by one."""


@dataclass(frozen=True)
class Object:
    """A thing in the street, with the place of the path nearest to it."""

    kind: str
    colour: str
    look: str
    x: float
    z: float
    index: int
    distance: float


@dataclass(frozen=True)
class Mention:
    """A noun phrase: its kind, its colour ("" if none is told), its marker, and whether one comes to it.

    `start` and `end` are where its noun begins, with the words before it that describe it, and where it ends in the text
    that `plain` returns.
    """

    kind: str
    colour: str
    look: str
    marker: str
    reached: bool
    words: str
    start: int = 0
    end: int = 0


def plain(text: str, code: str) -> str:
    """Return a text in lower case without punctuation, its words apart by single spaces, as `mentions` reads it."""
    text = re.sub(r"[.,;।]", " ", text.lower())
    text = re.sub(r"\s+", " ", text).replace("एक और ", "और_एक ")
    return re.sub(STRIPED, WHITE[code], text)


def mentions(text: str, code: str) -> Iterator[Mention]:
    """Yield the things that a text tells of, in order."""
    text = plain(text, code)
    taken = 0
    for match in _nouns(code).finditer(text):
        if match.start() < taken:
            continue
        taken = match.end()
        kind = _kinds(code)[re.sub(r"\s+", " ", _bare(match))]
        before = text[: match.start()].split()
        told: list[str] = [word for group in match.groups()[1:] if group for word in group.split()]
        while before and before[-1] in _describing(code):
            told.insert(0, before.pop())
        colours = [_colours(code)[word] for word in told if word in _colours(code)]
        shown = re.match(r" (?:with|showing) (?:an? )?(\S+)", text[match.end() :])
        shown_words = [shown[1]] if shown and shown[1] in _looks(code, kind) else []
        looks = [look for word in [*told, *shown_words] for look in _looks(code, kind).get(word, ())]
        markers = [m for word in told for m, words in MARKERS[code].items() if m and word in words]
        if code == "hi" and " जो " in text[match.end() :]:  # "Take that mug which lies there" refers to none before.
            markers = [marker for marker in markers if marker != "same"]
        beside = " ".join(before[-2:]) if code == "en" else text[match.end() :].strip()
        away = re.search(AWAY[code], beside) is not None
        yield Mention(
            kind, colours[0] if colours else "", looks[0] if looks else "", markers[0] if markers else "", not away,
            " ".join(word for word in [*told, *shown_words] if word not in _determiners(code)),
            len(" ".join([*before, *takewhile(LINKS.__contains__, told), ""])), match.end(),
        )  # fmt: skip


@cache
def _forms(code: str) -> dict[str, str]:
    """The kind of each form of each noun, with INSIDE where it has its adjectives."""
    return {
        form.lower(): kind for kind, nouns in load(code).grammar.nouns.items() for n in nouns for _, form in n.forms
    }


@cache
def _nouns(code: str) -> re.Pattern[str]:
    listed = sorted((form for form, kind in _forms(code).items() if kind), key=len, reverse=True)
    inside = r" ?((?:\S+ ){0,4}?)"
    return re.compile(
        r"(?<!\S)(" + "|".join(re.escape(f).replace(re.escape(INSIDE), inside) for f in listed) + r")(?!\S)"
    )


@cache
def _kinds(code: str) -> dict[str, str]:
    return {form.replace(INSIDE, ""): kind for form, kind in _forms(code).items()}


def _bare(match: re.Match[str]) -> str:
    """Return a noun as listed, without the words inside it."""
    inside = [match.span(number) for number in range(2, len(match.groups()) + 1) if match[number]]
    text, (start, _) = match[1], match.span(1)
    for first, last in reversed(inside):
        text = text[: first - start] + text[last - start :]
    return text


@cache
def _colours(code: str) -> dict[str, str]:
    grammar = load(code).grammar
    return {w: c for c, ps in grammar.colours.items() for p in ps for s in grammar.spellings(p) for w in s.split()[:1]}


@cache
def _looks(code: str, kind: str) -> dict[str, list[str]]:
    """For each word of the wordings of a kind's looks, the looks; words of several looks tell nothing."""
    grammar = load(code).grammar
    found: dict[str, set[str]] = {}
    for look, wordings in grammar.looks.get(grammar.look_kind(kind), {}).items():
        for wording in (each for each in wordings if each.weight):
            for text in grammar.spellings(wording.wording):
                for word in set(text.split()) - _determiners(code) - JOINING:
                    found.setdefault(word, set()).add(look)
    return {word: sorted(looks) for word, looks in found.items() if len(looks) == 1}


@cache
def _determiners(code: str) -> frozenset[str]:
    return frozenset(word for words in MARKERS[code].values() for word in words)


@cache
def _describing(code: str) -> frozenset[str]:
    """All words that may stand between a noun and what comes before its phrase."""
    grammar = load(code).grammar
    words = {w for ps in grammar.colours.values() for p in ps for s in grammar.spellings(p) for w in s.split()}
    for looks in grammar.looks.values():
        words |= {w for ws in looks.values() for x in ws for s in grammar.spellings(x.wording) for w in s.split()}
    return frozenset(words - {"a", "with", "on", "it"}) | _determiners(code) | STANDING


def objects(turn: dict[str, Any], section: dict[str, Any]) -> list[Object]:
    """Return the things near a turn's path."""
    listed = [(p["kind"], p["colour"], p["shape"], p["x"], p["z"]) for p in section["props"]]
    for item in turn["street"]:
        kind, (x, _, z) = item["type"], item["position"]
        listed.append((kind["kind"], kind["colour"], kind["pattern"], x, z))
    found = []
    for kind, colour, look, x, z in listed:
        far = [math.dist(place, (x, z)) for place in turn["path"]]
        index = min(range(len(far)), key=far.__getitem__)
        found.append(Object(kind, colour, look, x, z, index, far[index]))
    return found


def is_consistent(told: Sequence[Mention], things: Sequence[Object]) -> bool:
    """Return whether there is an object for each mention."""
    told = [mention for mention in told if mention.kind not in SKIPPED]

    def fits(number: int, chosen: tuple[Object, ...], progress: int) -> bool:
        if number == len(told):
            return True
        mention = told[number]
        earlier = [o for m, o in zip(told, chosen, strict=False) if m.kind == mention.kind]
        repeated = [o for m, o in zip(told, chosen, strict=False) if _is_repeated(mention, m)]
        for thing in things:
            if (thing.kind, thing.distance > FAR) != (mention.kind, False):
                continue
            if mention.colour not in ("", thing.colour) or mention.look not in ("", thing.look):
                continue
            if mention.marker == "same" and (not earlier or thing is not earlier[-1]):
                continue
            if mention.marker == "other" and (not earlier or thing in earlier):
                continue
            if mention.marker == "" and repeated and thing is not repeated[-1]:
                continue
            if mention.marker == "two" and not _is_one_of_two(thing, mention, things):
                continue
            if thing.distance <= PASSED and thing.index < progress - BEHIND:
                continue
            passed = mention.reached and thing.distance <= PASSED
            if fits(number + 1, (*chosen, thing), max(progress, thing.index) if passed else progress):
                return True
        return False

    return fits(0, (), 0)


def is_told_apart(told: Sequence[Mention], turn: dict[str, Any], things: Sequence[Object]) -> bool:
    """Return whether a text names something by the target that is not by another object that looks like it."""
    target, *others = ((item["type"], item["position"][0], item["position"][2]) for item in turn["street"])
    twins = [(x, z) for kind, x, z in others if kind == target[0]]
    told = [_in_full(mention, told[:number]) for number, mention in enumerate(told)]

    def is_by(mention: Mention, place: tuple[float, float], limit: float) -> bool:
        return any(
            o.kind == mention.kind
            and mention.colour in ("", o.colour)
            and mention.look in ("", o.look)
            and 0.1 < math.dist((o.x, o.z), place) <= limit
            for o in things
        )

    return not twins or any(
        is_by(mention, target[1:], BESIDE) and not any(is_by(mention, twin, BESIDE) for twin in twins)
        for mention in told[-3:]
    )


def _in_full(mention: Mention, earlier: Sequence[Mention]) -> Mention:
    """Return what "the same" or "that" repeats, with the words that it was first told by."""
    alike = [each for each in earlier if each.kind == mention.kind and (each.colour or each.look)]
    if mention.marker != "same" or mention.colour or mention.look or not alike:
        return mention
    return replace(mention, colour=alike[-1].colour, look=alike[-1].look)


def _is_repeated(mention: Mention, earlier: Mention) -> bool:
    return (mention.kind, mention.words, mention.marker) == (earlier.kind, earlier.words, earlier.marker)


def _is_one_of_two(thing: Object, mention: Mention, things: Sequence[Object]) -> bool:
    return any(
        o is not thing
        and o.kind == thing.kind
        and mention.colour in ("", o.colour)
        and math.dist((o.x, o.z), (thing.x, thing.z)) <= TOGETHER
        for o in things
    )


def check(data: Path, splits: Sequence[str], show: int) -> None:
    """Print how many texts of each split, section and language hold a false reference, and some of them."""
    for split in sorted(path for path in (data / "splits").iterdir() if not splits or path.name in splits):
        counts: dict[tuple[str, str], list[int]] = {}
        sections = {path.stem: json.loads(path.read_text()) for path in (split / "sections").glob("*.json")}
        for line in (split / "episodes.jsonl").read_text().splitlines()[1:]:
            episode = json.loads(line)
            for code, texts in episode["instructions"].items():
                for turn, text in zip(episode["turns"], texts, strict=True):
                    things = objects(turn, sections[episode["section"]])
                    told = list(mentions(text["navigation"], code))
                    count = counts.setdefault((episode["section"], code), [0, 0, 0])
                    count[0] += 1
                    count[1] += len(told)
                    if not is_consistent(told, things) or not is_told_apart(told, turn, things):
                        count[2] += 1
                        if show > 0:
                            show -= 1
                            print(f"  {episode['episode_id']} {code}: {text['navigation']}")
        for (section, code), (texts_read, phrases, false) in sorted(counts.items()):
            print(f"{split.name} section {section} {code}: {texts_read} texts, {phrases} things, {false} texts false")


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, help="folder of `arramon-server generate`")
    parser.add_argument("--split", nargs="*", default=[], help="splits (default: all)")
    parser.add_argument("--show", type=int, default=0, help="number of false texts to show")
    arguments = parser.parse_args()
    check(arguments.data, arguments.split, arguments.show)


if __name__ == "__main__":
    main()
