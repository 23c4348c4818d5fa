"""Files of a language's folder: their names, and their content with all keys checked."""

import tomllib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from arramon_client.world import (
    BANNER_SHAPES,
    COLLECTIBLE_COLOURS,
    COLLECTIBLE_PATTERNS,
    COLLECTIBLES,
    FACADES,
    FURNITURE,
    SHOPS,
    WALLS,
)
from arramon_lang.meaning import PLACES, RELATIONS, WAYS, WHICHES

FILES = (
    "language",
    "lexicon",
    "relations",
    "grammar",
    "things",
    "phrases",
    "quality",
    "properties",
    "chunks",
    "latin",
    "typing",
    "preferences",
)
"""Names of the files of a language, without their ending."""

OPTIONAL_FILES = ("chunks", "latin", "typing", "preferences")
"""Those that a language may lack."""

KINDS = frozenset((*COLLECTIBLES, *FURNITURE, *PLACES, "building", "wall", ""))
"""Kinds that may have nouns; "" is a collectible of which only attributes are stated."""

CLAUSES = ("turn", "turn at", "turn before", "turn after", "turn face", "face", *(f"walk {way}" for way in WAYS))
"""Clauses of steps: keys of [steps] in `phrases.toml`, possibly followed by a kind, "same" or "group".

"turn at faced" is a turn at the last thing mentioned, which one faces or walks towards and has not reached;
"turn before faced" and "turn after faced" say that one walks between facing it and the turn; "walk to far" and "walk
towards far" are of a thing in the distance. "walk past to" and "walk past towards" are two walks, past {thing} and on
to {other}; "face to" and "face towards" are facing {thing} and walking there. These are optional."""

ONLY_READ_CLAUSES = (
    *("turn with", "short of", "all sides", "walk past crossed", "walk past zebra_crossing"),
    *("target", "landmark", "not target", "detail"),
)
"""Keys of navigation clauses that are only read: a turn and a walk along something, a place just before something, the
side of all things passed last, crossing a street or a zebra crossing, the target, a passed thing, an object not to pick
up, and a description of the thing before."""

BARE = " bare"
"""Suffix of the keys of clauses without a verb ("left at the bank"), which match only where a clause may begin."""

_LOOKS = {
    "collectible": COLLECTIBLE_PATTERNS,
    "banner": BANNER_SHAPES,
    "shop_sign": SHOPS,
    "building": FACADES,
    "wall": WALLS,
}

_TOP: Mapping[str, frozenset[str]] = {
    name: frozenset(keys.split())
    for name, keys in {
        "language": "code name english_name script letters digits ignored required preview spelt_with",
        "lexicon": "modifiers stand_ins others having not_misspelt kinds patterned_kinds patterns colours",
        "relations": "position conjunctions skipped by_themselves phrases",
        "grammar": "features classes words tables text",
        "things": "noun_phrases pair_phrases pair_marks several_phrases another_phrases same_phrases same another two "
        "several attached nested determiners modifiers pronouns noun_phrases_of pair_phrases_of several_phrases_of "
        "same_phrases_of another_phrases_of nouns also_read also_read_looks colours colours_of whiches looks",
        "phrases": "steps where target assembly joins fragments also_read",
        "quality": "min_words single_letters repeats general navigation assembly wanted suspicious counts landmarks "
        "registers misspelt",
        "properties": "stopwords parts properties",
        "preferences": "navigation assembly",
        "chunks": "position negation soft exactly also written_together suffixes relating_suffixes own slightly "
        "slight_more slightly_behind nominal_before nominal vowels endings verbs relations sides words looks "
        "turn_positions walks target_relations room_relations opposites verb_relations named_places groups",
        "typing": "keyboard common known rewriting short",
        "latin": "borrows known having rewriting conjunctions completions inherent virama nasals "
        "consonants vowels heard folding short senses loans",
    }.items()
}
"""Keys of each file."""

_TABLES: Mapping[tuple[str, ...], frozenset[str]] = {
    ("lexicon", "kinds"): frozenset(COLLECTIBLES),
    ("lexicon", "patterned_kinds"): frozenset(COLLECTIBLES),
    ("lexicon", "patterns"): frozenset(COLLECTIBLE_PATTERNS),
    ("lexicon", "colours"): frozenset(COLLECTIBLE_COLOURS),
    ("relations", "phrases"): frozenset(RELATIONS),
    ("grammar", "text"): frozenset(
        (
            *("per_episode", "sentence_end", "spelling", "reading", "free_reading", "folding", "openers", "owners"),
            *(
                "asides",
                "clumsy",
                "straight",
                "first_mention",
                "ends",
                "small_letters",
                "articles",
                "evenness",
                "favourites",
            ),
        )
    ),
    ("grammar", "text", "owners"): frozenset(("of", "own")),
    ("grammar", "text", "articles"): frozenset(("words", "left_out")),
    ("things", "nouns"): KINDS,
    ("things", "also_read"): KINDS,
    ("things", "whiches"): frozenset(WHICHES),
    ("things", "looks"): frozenset(_LOOKS),
    **{("things", "looks", kind): frozenset(looks) for kind, looks in _LOOKS.items()},
    ("phrases", "target"): frozenset(("clause", "sentences", "alone", "purpose", "same")),
    ("phrases", "assembly"): frozenset(("turn", "place", "place it")),
    ("phrases", "joins"): frozenset(
        (
            *("sentence", "purpose", "assembly", "first", "later", "last"),
            *("where", "where of more", "where of you", "where of room", "where after clause", "nested where"),
        )
    ),
    ("chunks", "endings"): frozenset(("consonant", "vowel")),
    ("chunks", "sides"): frozenset(("left", "right", "back", "around")),
    ("chunks", "looks"): frozenset(COLLECTIBLE_PATTERNS),
    ("latin", "completions"): frozenset(("own", "foreign")),
}
"""Keys of tables within files, by the path to the table."""


ENGLISH = Path(__file__).parent / "en"
"""The folder whose values show the types of all languages' values."""


def read_file(folder: Path, name: str) -> Mapping[str, Any]:
    """Return the content of one of the `FILES`.

    Raises:
        FileNotFoundError: if the file does not exist.
        ValueError: if it is not TOML in UTF-8, has an unknown key, or a text where lang/en has a list, or the reverse;
            names the file and the key.
    """
    path, english = folder / f"{name}.toml", _english(name)
    data = english if english and folder == ENGLISH else _parsed(path)
    _check(path, "", data, _TOP[name])
    _check_types(path, "", data, english)
    for at, known in _TABLES.items():
        table = data if at[0] == name else {}
        for key in at[1:]:
            table = table.get(key, {})
        _check(path, ".".join(at[1:]), table, known)
    if name == "phrases":
        _check_phrases(path, data)
    for slot, table in data.get("tables", {}).items() if name == "grammar" else ():
        _check(path, f"tables.{slot}", table, frozenset(("of", "values")))
    return data


def _parsed(path: Path) -> Mapping[str, Any]:
    try:
        with path.open("rb") as file:
            return tomllib.load(file)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: {error}") from error


def _check_phrases(path: Path, data: Mapping[str, Any]) -> None:
    steps = {f"{clause}{end}" for clause in CLAUSES for end in ("", " same", " group", *(f" {kind}" for kind in KINDS))}
    steps |= {"turn at faced", "turn before faced", "turn after faced", "walk to far", "walk towards far"}
    steps |= {"walk past to", "walk past towards", "face to", "face towards"}
    wheres = {
        f"{relation}{end}" for relation in RELATIONS for end in ("", " same", " group", " you", " nested", " placed")
    }
    _check(path, "steps", data.get("steps", {}), steps)
    _check(path, "where", data.get("where", {}), wheres)
    read = {*steps, *ONLY_READ_CLAUSES, *wheres, *(f"{relation} {kind}" for relation in RELATIONS for kind in KINDS)}
    read |= {f"{key}{BARE}" for key in read} | {"nested", "turn", "place", "place it"}
    _check(path, "also_read", data.get("also_read", {}), read)


@cache
def _english(name: str) -> Mapping[str, Any]:
    """Return the content of lang/en's file of this name, which shows the types of values; empty if it has none."""
    path = ENGLISH / f"{name}.toml"
    return _parsed(path) if path.exists() else {}


def _check_types(path: Path, key: str, found: object, english: object) -> None:
    """Refuse a text in place of a list, which would be taken for a list of its letters, and all that is as different.

    A list may stand for a table and a table for a list, where the loader reads both.
    """
    if isinstance(found, Mapping) and isinstance(english, Mapping):
        for name in found.keys() & english.keys():
            _check_types(path, f"{key}.{name}" if key else name, found[name], english[name])
    elif _type_of(found) != _type_of(english):
        raise ValueError(f"{path}: {key}: {found!r} is {_type_of(found)}; expected {_type_of(english)}, as in lang/en")


def _type_of(value: object) -> str:
    if isinstance(value, list | Mapping):
        return "a list or table"
    return "a text" if isinstance(value, str) else "true or false" if isinstance(value, bool) else "a number"


def _check(path: Path, table: str, found: Iterable[str], known: Iterable[str]) -> None:
    unknown = sorted(set(found) - set(known))
    if unknown:
        within = f" in [{table}]" if table else ""
        listed = sorted(filter(None, known))
        expected = ", ".join(listed) if len(listed) <= 40 else f"one of {len(listed)} keys as in lang/en"
        raise ValueError(f"{path}: unknown key {unknown[0]!r}{within}; expected {expected}")
