"""Free texts in Spanish, with prepositions, and in Telugu, with postpositions and suffixes, read by data alone."""

from pathlib import Path

import pytest

from arramon_lang.language import Language, load
from arramon_lang.meaning import Assembly, Meaning, Navigation, Rotate, Thing, Walk, Where
from arramon_lang.reading.parser import CannotRead
from tests.lang.test_third_language import FILES

SPANISH = {
    "language": r"""
        code = "es"
        name = "español"
        english_name = "Spanish"
        script = "Latin"
        letters = "A-Za-z\u00C0-\u024F"
        digits = ""
        ignored = ""
    """,
    "lexicon": """
        modifiers = []
        stand_ins = []
        others = []
        having = []
        not_misspelt = []
        [kinds]
        ball = ["pelota"]
        [patterned_kinds]
        [patterns]
        striped = ["rayada"]
        [colours]
        red = ["roja"]
    """,
    "things": """
        noun_phrases = ["(el|la) {noun} [{look}] [{colour}]"]
        pair_phrases = ["ambos {noun}"]
        pair_marks = ["plural"]
        several_phrases = ["varios {noun}"]
        another_phrases = ["otro {noun}"]
        same_phrases = ["ese {noun}"]
        same = ["ese"]
        another = ["otro"]
        two = ["ambos"]
        several = ["varios"]
        attached = ["{thing} {where}"]
        nested = ["{thing} que está {where}"]
        determiners = ["el", "la"]
        modifiers = []
        pronouns = ["él"]
        [nouns]
        ball = ["pelota"]
        bench = ["banco"]
        tree = ["árbol"]
        [also_read]
        [colours]
        red = ["roja"]
        [whiches]
        second = ["segundo"]
        [looks.collectible]
        striped = ["rayada"]
    """,
    "chunks": """
        position = "before"
        negation = "before"
        soft = ["el", "la"]
        written_together = [["al", "a el"], ["del", "de el"]]
        [verbs.turn]
        words = ["gira", "girando"]
        [verbs.walk]
        words = ["ve", "camina"]
        [verbs.be]
        words = ["está", "hay"]
        [relations]
        to = ["a", "hasta"]
        past = ["pasando por"]
        before = ["antes de"]
        near = ["junto a"]
        behind = ["detrás de"]
        [sides]
        left = ["a la izquierda"]
        right = ["a la derecha"]
        [words]
        comma = [","]
        and = ["y"]
        stop = ["."]
        not = ["no"]
        [turn_positions]
        before = "before"
        near = "at"
        [walks]
        to = "to"
        [target_relations]
        behind = "behind"
        [groups]
        moving = ["turn", "walk"]
        standing = ["be"]
        leading = ["to", "past"]
        at_turn = ["near", "before"]
        placing = ["near", "before", "behind"]
    """,
}

TELUGU = SPANISH | {
    "language": r"""
        code = "te"
        name = "తెలుగు"
        english_name = "Telugu"
        script = "Telugu"
        letters = "\u0C00-\u0C65\u0C70-\u0C7F"
        digits = "\u0C66-\u0C6F"
        ignored = "\u200C\u200D"
    """,
    "lexicon": """
        modifiers = []
        stand_ins = []
        others = []
        having = []
        not_misspelt = []
        [kinds]
        ball = ["బంతి"]
        mug = ["కప్పు"]
        [patterned_kinds]
        [patterns]
        striped = ["చారల"]
        [colours]
        red = ["ఎర్ర"]
    """,
    "things": """
        noun_phrases = ["[{look}] [{colour}] {noun}"]
        pair_phrases = ["రెండు {noun}"]
        pair_marks = ["plural"]
        several_phrases = ["కొన్ని {noun}"]
        another_phrases = ["ఇంకో {noun}"]
        same_phrases = ["ఆ {noun}"]
        same = ["ఆ"]
        another = ["ఇంకో"]
        two = ["రెండు"]
        several = ["కొన్ని"]
        attached = ["{where} {thing}"]
        nested = ["{where} ఉన్న {thing}"]
        determiners = []
        modifiers = []
        pronouns = ["అది"]
        [nouns]
        ball = ["బంతి"]
        mug = ["కప్పు"]
        bench = ["బెంచీ"]
        tree = ["చెట్టు"]
        [also_read]
        [colours]
        red = ["ఎర్ర"]
        [whiches]
        second = ["రెండవ"]
        [looks.collectible]
        striped = ["చారల"]
    """,
    "chunks": """
        position = "after"
        negation = "after"
        relating_suffixes = ["కి", "పై", "ను"]
        [verbs.turn]
        words = ["తిరుగు"]
        [verbs.walk]
        words = ["వెళ్ళు", "వెళ్ళి"]
        [verbs.be]
        words = ["ఉంది"]
        [verbs.place]
        words = ["పెట్టు"]
        [relations]
        to = ["కి", "వరకు"]
        before = ["కి ముందు"]
        near = ["దగ్గర"]
        behind = ["వెనుక"]
        on = ["పై"]
        object = ["ను"]
        [sides]
        left = ["ఎడమ", "ఎడమకి"]
        right = ["కుడి", "కుడికి"]
        [words]
        comma = [","]
        stop = ["."]
        [turn_positions]
        before = "before"
        [walks]
        to = "to"
        before = "until"
        [target_relations]
        near = "near"
        [room_relations]
        on = "on_top_of"
        behind = "behind"
        [groups]
        moving = ["turn", "walk"]
        standing = ["be"]
        leading = ["to"]
    """,
}

BENCH, TREE, BALL = Thing("bench"), Thing("tree"), Thing("ball", "red", "striped")


def found(relation: str, thing: Thing) -> Thing:
    return Thing("ball", "red", "striped", where=(Where(relation, (thing,)),))


TEXTS: list[tuple[str, str, Meaning]] = [
    (
        "es",
        "Camina hasta el banco y gira a la izquierda antes del árbol. Detrás del banco está la pelota rayada roja.",
        Navigation((Walk("to", (BENCH,)), Rotate("left", "before", TREE)), found("behind", BENCH)),
    ),
    (
        "es",
        "Junto al banco gira a la derecha, pasando por el árbol. Hay la pelota roja rayada.",
        Navigation((Rotate("right", "at", BENCH), Walk("past", (TREE,))), BALL),
    ),
    (
        "te",
        "బెంచీకి వెళ్ళి ఎడమకి తిరుగు. చెట్టు దగ్గర చారల ఎర్ర బంతి ఉంది.",
        Navigation((Walk("to", (BENCH,)), Rotate("left")), found("near", TREE)),
    ),
    (
        "te",
        "చెట్టుకి ముందు కుడికి తిరుగు, బెంచీ వరకు వెళ్ళు. ఎర్ర చారల బంతి ఉంది.",
        Navigation((Rotate("right", "before", TREE), Walk("to", (BENCH,))), BALL),
    ),
    ("te", "కప్పును ఎర్ర చారల బంతిపై పెట్టు.", Assembly((), Thing("mug"), (Where("on_top_of", (BALL,)),))),
    ("te", "కప్పును ఎర్ర చారల బంతి వెనుక పెట్టు.", Assembly((), Thing("mug"), (Where("behind", (BALL,)),))),
]


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("lang")
    for code, files in (("es", SPANISH), ("te", TELUGU)):
        write(root / code, FILES | files)
    return root


def write(folder: Path, files: dict[str, str]) -> None:
    folder.mkdir()
    for name, content in files.items():
        (folder / f"{name}.toml").write_text(content, encoding="utf-8")


@pytest.mark.parametrize(("code", "text", "meaning"), TEXTS)
def test_free_texts_are_read_by_data_alone(root: Path, code: str, text: str, meaning: Meaning) -> None:
    assert load(code, root).read(text, "navigation" if isinstance(meaning, Navigation) else "assembly") == meaning


def test_a_suffix_that_is_not_listed_is_not_read(tmp_path: Path) -> None:
    chunks = TELUGU["chunks"].replace('["కి", "పై", "ను"]', '["కి", "ను"]')
    write(tmp_path / "te", FILES | TELUGU | {"chunks": chunks})
    with pytest.raises(CannotRead, match="బంతిపై"):
        Language(tmp_path / "te").read("కప్పును ఎర్ర చారల బంతిపై పెట్టు.", "assembly")


def test_suffixes_that_begin_no_relation_are_named(tmp_path: Path) -> None:
    chunks = TELUGU["chunks"].replace('["కి", "పై", "ను"]', '["కి", "లో"]')
    write(tmp_path / "te", FILES | TELUGU | {"chunks": chunks})
    with pytest.raises(ValueError, match="relating_suffixes: no relation begins with 'లో'"):
        Language(tmp_path / "te").read("బెంచీలో", "navigation")
