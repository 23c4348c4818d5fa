"""Count false references in generated navigation instructions: phrases without a matching thing in the street.

    python -m benchmarks.instructions.references DATA [--split NAME ...] [--show N]

This check is independent of the generation's gate: it uses only the files of a data set. It finds the noun phrases of a
text and assigns objects to them in order along the ground truth's path: "the same" must be the same object, "another" a
different one, "two" need two, and no object may be passed long before it is mentioned. A text without such an
assignment contains a false reference. So does a text that names nothing near the target although another object looks
like it. `sides.py` checks the stated sides of things on the way, and targets said to be next to a zebra crossing.

It reads whole words in a language's own script: texts mostly in another one are counted as unread, and of forms with
typing errors or loans it calls texts false whose words it does not know.
"""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from arramon_lang import load
from benchmarks.common import parser_of
from benchmarks.instructions.mentions import ThingMention, mentions
from benchmarks.instructions.sides import crossing_faults, side_faults, stated_sides, things_in_street
from benchmarks.instructions.turn_paths import NavigationPath, turn_path

MAX_FROM_PATH, MAX_WHEN_PASSED, MAX_STEPS_BEHIND, MAX_APART, REFERENCE_FAR = 14.0, 4.0, 6, 9.0, 4.0
"""Maximum distance of a thing from the path, and of one that the path passes, in units; number of steps by which a
thing may lie behind when it is mentioned; maximum distance of two things from each other, and of the target from what
tells its place, in units."""

PLACES = ("intersection", "t_junction", "corner", "building_corner", "street", "alley", "square", "street_end")
SKIPPED = (*PLACES, "wall", "", "building", "you")
"""Kinds that the files do not list individually."""


@dataclass(frozen=True)
class StreetObject:
    """A thing in the street, with the nearest place of the path."""

    kind: str
    colour: str
    look: str
    x: float
    z: float
    index: int
    distance: float


def objects(turn: dict[str, Any], section: dict[str, Any]) -> list[StreetObject]:
    """Return the things near a turn's path."""
    listed = [(p["kind"], p["colour"], p["shape"], p["x"], p["z"]) for p in section["props"]]
    for item in turn["street"]:
        kind, (x, _, z) = item["type"], item["position"]
        listed.append((kind["kind"], kind["colour"], kind["pattern"], x, z))
    found = []
    for kind, colour, look, x, z in listed:
        far = [math.dist(place, (x, z)) for place in turn["path"]]
        index = min(range(len(far)), key=far.__getitem__)
        found.append(StreetObject(kind, colour, look, x, z, index, far[index]))
    return found


def is_consistent(found: Sequence[ThingMention], things: Sequence[StreetObject]) -> bool:
    """Return whether an object can be assigned to each mention."""
    found = [mention for mention in found if mention.kind not in SKIPPED]

    def fits(number: int, chosen: tuple[StreetObject, ...], progress: int) -> bool:
        if number == len(found):
            return True
        mention = found[number]
        earlier = [o for m, o in zip(found, chosen, strict=False) if m.kind == mention.kind]
        repeated = [o for m, o in zip(found, chosen, strict=False) if _is_repeated(mention, m)]
        for thing in things:
            if (thing.kind, thing.distance > MAX_FROM_PATH) != (mention.kind, False):
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
            if thing.distance <= MAX_WHEN_PASSED and thing.index < progress - MAX_STEPS_BEHIND:
                continue
            passed = mention.reached and thing.distance <= MAX_WHEN_PASSED
            if fits(number + 1, (*chosen, thing), max(progress, thing.index) if passed else progress):
                return True
        return False

    return fits(0, (), 0)


def identifies_target(found: Sequence[ThingMention], turn: dict[str, Any], things: Sequence[StreetObject]) -> bool:
    """Return whether a text names something near the target that is not near its look-alike."""
    target, *others = ((item["type"], item["position"][0], item["position"][2]) for item in turn["street"])
    twins = [(x, z) for kind, x, z in others if kind == target[0]]
    found = [_in_full(mention, found[:number]) for number, mention in enumerate(found)]

    def is_by(mention: ThingMention, place: tuple[float, float], limit: float) -> bool:
        return any(
            o.kind == mention.kind
            and mention.colour in ("", o.colour)
            and mention.look in ("", o.look)
            and 0.1 < math.dist((o.x, o.z), place) <= limit
            for o in things
        )

    return not twins or any(
        is_by(mention, target[1:], REFERENCE_FAR) and not any(is_by(mention, twin, REFERENCE_FAR) for twin in twins)
        for mention in found[-3:]
    )


def _in_full(mention: ThingMention, earlier: Sequence[ThingMention]) -> ThingMention:
    """Resolve "the same" or "that" to the earlier mention, with its full description.

    It is the latest of the kind that is no "same" itself: after "a blue car" and "the next car", "that car" is the
    next one.
    """
    if mention.marker != "same" or mention.colour or mention.look:
        return mention
    meant = next(
        (m for m in reversed(earlier) if m.kind == mention.kind and (m.marker != "same" or m.colour or m.look)), None
    )
    return mention if meant is None else replace(mention, colour=meant.colour, look=meant.look)


def _is_repeated(mention: ThingMention, earlier: ThingMention) -> bool:
    return (mention.kind, mention.words, mention.marker) == (earlier.kind, earlier.words, earlier.marker)


def _is_one_of_two(thing: StreetObject, mention: ThingMention, things: Sequence[StreetObject]) -> bool:
    return any(
        o is not thing
        and o.kind == thing.kind
        and mention.colour in ("", o.colour)
        and math.dist((o.x, o.z), (thing.x, thing.z)) <= MAX_APART
        for o in things
    )


@dataclass
class ReferenceCounts:
    """Counts of references, sides and crossings in a section's texts in one language, and of the false ones."""

    texts: int = 0
    things: int = 0
    false_references: int = 0
    sides: int = 0
    false_sides: int = 0
    crossings: int = 0
    false_crossings: int = 0
    unread: int = 0

    def __str__(self) -> str:
        return (
            f"{self.texts} texts, {self.things} things, {self.false_references} texts false; {self.sides} sides on the "
            f"way, {self.false_sides} texts false; {self.crossings} by a crossing, {self.false_crossings} on it"
            + (f"; {self.unread} texts unread, in another script" if self.unread else "")
        )

    def add(
        self, text: str, code: str, turn: dict[str, Any], section: dict[str, Any], way: NavigationPath
    ) -> list[str]:
        """Count one text, and return descriptions of what is false in it."""
        if not load(code).is_in_own_script(text):
            self.unread += 1
            return []
        found, things, grounds = list(mentions(text, code)), objects(turn, section), things_in_street(turn, section)
        x, _, z = turn["street"][0]["position"]
        is_true = is_consistent(found, things) and identifies_target(found, turn, things)
        aside = side_faults(text, code, way, grounds)
        by, on = crossing_faults(text, code, (x, z), grounds)
        self.texts += 1
        self.things += len(found)
        self.false_references += not is_true
        self.sides += len(stated_sides(text, code))
        self.false_sides += bool(aside)
        self.crossings += by
        self.false_crossings += bool(on)
        return [*([] if is_true else ["there are no such things"]), *aside, *on]


def check(data: Path, splits: Sequence[str], show: int) -> None:
    """Print the numbers of texts with false references, sides or crossings by split, section and language."""
    for split in sorted(path for path in (data / "splits").iterdir() if not splits or path.name in splits):
        counts: dict[tuple[str, str], ReferenceCounts] = {}
        sections = {path.stem: json.loads(path.read_text()) for path in (split / "sections").glob("*.json")}
        for line in (split / "episodes.jsonl").read_text().splitlines()[1:]:
            episode = json.loads(line)
            before: list[int] = []
            for number, turn in enumerate(episode["turns"]):
                way, before = turn_path(turn, episode["start"], before), turn["actions"]
                for code, texts in episode["instructions"].items():
                    count = counts.setdefault((episode["section"], code), ReferenceCounts())
                    text = texts[number]["navigation"]
                    faults = count.add(text, code, turn, sections[episode["section"]], way)
                    if faults and show > 0:
                        show -= 1
                        print(f"  {episode['episode_id']} {code}: {text} ({'; '.join(faults)})")
        for (section, code), count in sorted(counts.items()):
            print(f"{split.name} section {section} {code}: {count}")


def main() -> None:
    """Run the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder of `arramon-server generate`")
    parser.add_argument("--split", nargs="*", default=[], help="splits (default: all)")
    parser.add_argument("--show", type=int, default=0, help="number of false texts to show")
    arguments = parser.parse_args()
    check(arguments.data, arguments.split, arguments.show)


if __name__ == "__main__":
    main()
