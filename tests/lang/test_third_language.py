"""A third language, added as a data folder without code: a small Esperanto is written, read and checked."""

from pathlib import Path
from random import Random
from shutil import copytree

import pytest

from arramon_lang.language import ROOT, Language, available, identify, load
from arramon_lang.meaning import Assembly, Meaning, Navigation, Rotate, Thing, Walk, Where
from arramon_lang.quality import check

FILES = {
    "language": r"""
        code = "eo"
        name = "Esperanto"
        english_name = "Esperanto"
        script = "Latin"
        letters = "A-Za-z\u00C0-\u024F"
        digits = ""
        ignored = ""
    """,
    "lexicon": """
        modifiers = []
        stand_ins = ["unu"]
        others = ["muro", "muron"]
        having = ["kun"]
        not_misspelt = []
        [kinds]
        ball = ["pilko", "pilkon"]
        mug = ["taso", "tason"]
        [patterned_kinds]
        [patterns]
        dotted = ["punktita", "punktitan"]
        striped = ["stria", "strian"]
        [colours]
        red = ["ruĝa", "ruĝan"]
        blue = ["blua", "bluan"]
    """,
    "relations": """
        position = "before"
        conjunctions = ["kaj"]
        skipped = ["la"]
        [phrases]
        on_top_of = ["sur"]
        left_of = ["maldekstre de"]
        right_of = ["dekstre de"]
        in_front_of = ["antaŭ"]
        behind = ["malantaŭ"]
        between = ["inter"]
        near = ["apud"]
        against = ["tuŝante"]
    """,
    "grammar": """
        [features]
        form = ["main"]
        case = ["nominative", "accusative"]
        number = ["singular", "plural"]
        [classes]
        noun = { nominative = "o", accusative = "on", "nominative.plural" = "oj", "accusative.plural" = "ojn" }
        adjective = { nominative = "a", accusative = "an", "nominative.plural" = "aj", "accusative.plural" = "ajn" }
        [words]
        go = ["iru", "marŝu", "paŝu"]
        red = { class = "adjective", stem = "ruĝ" }
        blue = { class = "adjective", stem = "blu" }
        dotted = { class = "adjective", stem = "punktit" }
        striped = { class = "adjective", stem = "stri" }
        second = { class = "adjective", stem = "du" }
        [tables.direction]
        of = "direction"
        [tables.direction.values]
        left = ["maldekstren"]
        right = ["dekstren"]
        around = ["malantaŭen"]
        [text]
        per_episode = {}
        sentence_end = "."
        spelling = []
        reading = []
    """,
    "things": """
        noun_phrases = ["la [{which}] [{look}] [{colour}] {noun}", "la [{which}] [{colour}] [{look}] {noun}"]
        pair_phrases = ["ambaŭ {noun}"]
        pair_marks = ["plural"]
        several_phrases = ["pluraj {noun}"]
        another_phrases = ["alia {noun}"]
        same_phrases = ["tiu {noun}"]
        same = ["tiu"]
        another = ["alia"]
        two = ["ambaŭ"]
        several = ["pluraj"]
        attached = ["{thing} {where}"]
        nested = ["{thing} kiu staras {where}"]
        determiners = ["la"]
        modifiers = []
        pronouns = ["ĝi", "ĝin"]
        [nouns]
        ball = { class = "noun", stem = "pilk" }
        mug = { class = "noun", stem = "tas" }
        bench = { class = "noun", stem = "benk" }
        corner = [{ class = "noun", stem = "angul" }, { class = "noun", stem = "stratangul" }]
        wall = { class = "noun", stem = "mur" }
        [also_read]
        bench = ["sidbenko"]
        [colours]
        red = ["{red}"]
        blue = ["{blue}"]
        [whiches]
        second = ["{second}"]
        [looks.collectible]
        dotted = ["{dotted}"]
        striped = ["{striped}"]
        [looks.wall]
        brick = ["brika"]
    """,
    "phrases": """
        [steps]
        turn = ["turnu vin {direction}"]
        "turn at" = ["turnu vin {direction} ĉe {thing}", "^ĉe {thing}, turnu vin {direction}"]
        "walk to" = ["{go} [rekte] ĝis {thing}", "{go} [rekte] al {thing}"]
        "walk between" = ["{go} inter ({thing} kaj {other}|{pair})"]
        [where]
        near = ["apud {thing}", "proksime al {thing}"]
        behind = ["malantaŭ {thing}"]
        on_top_of = ["sur {thing}"]
        "near same" = ["apud ĝi"]
        [target]
        clause = ["prenu {target:accusative}", "kolektu {target:accusative}"]
        sentences = ["{where} (estas|kuŝas) {target}. Prenu ĝin"]
        same = ["prenu ĝin"]
        [assembly]
        turn = ["turnu vin {direction}"]
        place = ["metu {thing:accusative} {where}", "{where} metu {thing:accusative}"]
        "place it" = ["metu ĝin {where}"]
        [joins]
        sentence = ["{a}", "{a} kaj {b}", "{a}, poste {b}", "{a}, {b} kaj {c}"]
        assembly = ["{a}", "{a} kaj {b}", "{a}, poste {b}"]
        first = ["unue {a}"]
        later = ["poste {a}"]
        last = ["fine {a}"]
        where = ["{a} kaj {b}"]
        "where of more" = ["{a}, {b}"]
        "where after clause" = ["{a}, kaj {b}"]
        "nested where" = ["{a} kaj {b}"]
        [also_read]
        near = ["ĉe {thing}"]
    """,
    "quality": """
        single_letters = []
        repeats = []
        [general]
        time = ["fojo", "fojojn"]
        [navigation]
        arrow = ["sago"]
        [assembly]
        go = ["iru"]
        [wanted]
        turn = ["turn*"]
        pick_up = ["pren*", "kolekt*"]
        place = ["met*"]
        [suspicious]
        movement = ["marŝu"]
        interface = []
        grey_building = []
        earlier = []
        [counts]
        numbers = ["du"]
        units = ["metroj"]
        [landmarks]
        words = ["muro"]
        [registers]
        [misspelt]
    """,
}
"""Content of the folder's files, with five kinds of things and two colours."""

BALL, MUG, BENCH = Thing("ball", "blue", "dotted"), Thing("mug", "red", "striped"), Thing("bench")

MEANINGS: list[Meaning] = [
    Navigation((Rotate("left"), Walk("to", (BENCH,))), BALL),
    Navigation(
        (Rotate("right", "at", Thing("corner", which="second")), Walk("between", (BENCH, BENCH))),
        Thing("mug", "red", "striped", where=(Where("near", (BENCH,)),)),
    ),
    Assembly((), Thing("ball"), (Where("on_top_of", (MUG,)),)),
    Assembly(("around",), Thing(""), (Where("behind", (BALL,)), Where("near", (Thing("wall", look="brick"),)))),
]


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("lang")
    for code in ("en", "hi"):
        copytree(ROOT / code, root / code)
    (root / "eo").mkdir()
    for name, content in FILES.items():
        (root / "eo" / f"{name}.toml").write_text(content, encoding="utf-8")
    return root


@pytest.fixture(scope="module")
def esperanto(root: Path) -> Language:
    return load("eo", root)


def test_third_language_is_available_and_identified(root: Path, esperanto: Language) -> None:
    assert available(root) == ("en", "eo", "hi")
    assert esperanto.name == "Esperanto"
    assert identify("prenu la punktitan bluan pilkon apud la taso", root) == "eo"


@pytest.mark.parametrize("meaning", MEANINGS)
def test_written_texts_are_read_back_to_their_meaning(esperanto: Language, meaning: Meaning) -> None:
    phase = "navigation" if isinstance(meaning, Navigation) else "assembly"
    texts = {esperanto.write(meaning, Random(seed)) for seed in range(20)}
    assert len(texts) > 2
    for text in texts:
        assert esperanto.read(text, phase) == meaning, text


def test_third_language_follows_its_own_grammar(esperanto: Language) -> None:
    """Esperanto has a case that English and Hindi lack, in which adjectives agree."""
    texts = {esperanto.write(MEANINGS[0], Random(seed)) for seed in range(30)}
    assert all("pilkon." in text for text in texts)
    assert any("la punktitan bluan pilkon" in text for text in texts)
    plural = {esperanto.write(MEANINGS[1], Random(seed)) for seed in range(10)}
    assert all("ambaŭ benkoj" in text for text in plural)


def test_human_written_text_is_read(esperanto: Language) -> None:
    text = "Turnu vin dekstren ĉe la dua stratangulo kaj iru ĝis la benko. Prenu la strian ruĝan tason ĉe la sidbenko."
    steps = (Rotate("right", "at", Thing("corner", which="second")), Walk("to", (BENCH,)))
    assert esperanto.read(text, "navigation") == Navigation(
        steps, Thing("mug", "red", "striped", where=(Where("near", (BENCH,)),))
    )


@pytest.mark.parametrize(
    ("text", "phase", "failed"),
    [
        ("Turnu vin maldekstren kaj prenu la bluan pilkon.", "navigation", []),
        ("Turnu vin maldekstren ĉe la sago kaj prenu la pilkon.", "navigation", ["term"]),
        ("Iru rekte kaj metu la pilkon sur la tason.", "assembly", ["term"]),
        ("Turnu vin maldekstren kaj marŝu ĝis la benko.", "navigation", ["no_pick_up"]),
    ],
)
def test_quality_checks_apply_to_the_third_language(root: Path, text: str, phase: str, failed: list[str]) -> None:
    assert [failure.check for failure in check(text, "eo", phase, root=root)] == failed
