"""Shares of instructions with certain words: `python -m benchmarks.instructions.route_words DATA`.

Prints the share of instructions that name a building, a crossing, a corner, a street, another or the next thing,
several things, and so on, in a generated data set, in English and Hindi, and, if the environment variable
ARRAMON_RELEASE names its folder, in the official release's val-seen file. What is counted is the same in all columns:
a pile of bags or tyres is one thing, a shop sign is no shop, and "Next, turn left" names nothing. "Until" is a clause
in Hindi too (जब तक ... न, ... आने तक); बेंच तक चलें, which says "walk to" as well as "until you reach", is not counted.
Two mentions of collectibles may be of one: of the target, most of all.
"""

import json
import os
import re
import sys
import unicodedata
from collections.abc import Sequence
from pathlib import Path

from benchmarks.common import parser_of, text_table

_THINGS = (
    "cones|benches|barrels|drums|bins|cans|signs|posts|lights|lamps|banners|flags|posters|trees|booths|barriers|"
    "barricades|dumpsters|buildings|mailboxes|hydrants|boxes|cars|kiosks|crossings|planters|awnings|tapestries|vehicles"
)
_OBJECTS = "ball|hourglass|mug|cup|tv|television|book|bowl|bucket"

SHARES = {
    "building, house, store": r"\b(buildings?|houses?|(stores?|shops?)(?! (sign|awning|board|banner)))\b",
    "intersection, junction": r"\b(intersections?|t-intersections?|junctions?|t-junctions?|crossroads?"
    r"|(?<!zebra )(?<!pedestrian )crossings?)\b",
    "corner": r"\bcorners?\b",
    "street, road, alley": r"\b(streets?|roads?|alleys?|alleyways?|lanes?|path|pathway)\b"
    r"(?! (light|lamp|sign|cone|block|barrier|barricade|kiosk|stall|bench|post|corner)s?)",
    "second, next, another": r"\b(second|third|another|other|(the|your|very|take|at) next(?! to))\b",
    "until": r"\b(until|till|untill|til)\b",
    "several of a kind": rf"\b({_THINGS})\b",
    "two collectibles mentioned": rf"\b({_OBJECTS})s?\b.*\b({_OBJECTS})s?\b",
    "collectibles of two kinds": rf"\b({_OBJECTS})s?\b.*\b(?!\1\b)({_OBJECTS})s?\b",
    "counted paces": r"\b\w+ (paces|steps|feet)\b",
}
"""Regular expressions over a text's words, in small letters, without marks."""

_HINDI_OBJECTS = "गेंद|बॉल|घड़ी|मग|कप|प्याल|टीवी|टेलीविज़न|किताब|पुस्तक|कटोर|बाउल|बाल्टी"

HINDI = {
    "building, house, store": "इमारत|बिल्डिंग|भवन",
    "intersection, junction": "चौराह|तिराह|टी-पॉइंट|टी-जंक्शन|(?<!ज़ेबरा )क्रॉसिंग",
    "corner": "नुक्कड़|मोड़ (पर|से|के)|कोने (पर|से|के)",
    "street, road, alley": "सड़क|गली|रोड(?! ब्लॉक)",
    "second, next, another": "दूसर|तीसर|अगल|एक और",
    "until": "जब तक|(आने|दिखने|छूटने|मिलने|पहुँचने) तक",
    "several of a kind": "(दोनों|कई) |(?<!टायर)(?<!थैलिय)(?<!खिड़किय)(?<!बिंदिय)(?<!धारिय)(?<!मेहराब)(?<!ईंट)"
    "(?<!दोन)ों (के|से|की|तक) ",
    "two collectibles mentioned": f"({_HINDI_OBJECTS}).*({_HINDI_OBJECTS})",
    "collectibles of two kinds": f"({_HINDI_OBJECTS}).*(?!\\1)({_HINDI_OBJECTS})",
    "counted paces": "क़दम",
}
"""The same over Hindi texts without marks; nouns of several things are recognised by their oblique plural."""

PATTERNS = {"en": SHARES, "hi": HINDI}


def shares(texts: Sequence[str], patterns: dict[str, str] = SHARES) -> dict[str, float]:
    """Return the percentage of texts that match each pattern."""
    words = [" ".join(re.sub(r"[.,;:।]", " ", text.lower()).split()) + " " for text in texts]
    return {
        name: 100.0
        * sum(re.search(unicodedata.normalize("NFC", pattern), text) is not None for text in words)
        / len(words)
        for name, pattern in patterns.items()
    }


def generated_texts(data: Path, language: str) -> list[str]:
    """Return all navigation instructions of a data folder in a language; some episodes may have none."""
    found = []
    for path in sorted(data.glob("splits/*/episodes.jsonl")):
        for line in path.read_text(encoding="utf-8").splitlines()[1:]:
            found += [turn["navigation"] for turn in json.loads(line)["instructions"].get(language, ())]
    return found


def main() -> None:
    """Run the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder of `arramon-server generate`")
    arguments = parser.parse_args()
    texts = {language: generated_texts(arguments.data, language) for language in PATTERNS}
    columns = {language: shares(found, PATTERNS[language]) for language, found in texts.items() if found}
    if not columns:
        sys.exit(f"{arguments.data} has no instructions in {' or '.join(PATTERNS)}; expected a folder of `generate`")
    release = Path(os.environ.get("ARRAMON_RELEASE", "")) / "val_seen.json"
    if release.is_file():
        episodes = json.loads(release.read_text(encoding="utf-8"))
        columns["release"] = shares([text for e in episodes for text in e["instructions"]["navi_inst_gt"]])
    rows = [[name, *(f"{column[name]:.1f}%" for column in columns.values())] for name in SHARES]
    print(text_table(["", *columns], rows))


if __name__ == "__main__":
    main()
