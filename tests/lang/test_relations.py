"""Spatial relations to mentioned landmarks in texts."""

import tomllib

import pytest

from arramon_lang.language import ROOT, available, load
from arramon_lang.lexicon import Lexicon
from arramon_lang.reading.relations import RELATIONS, Relations
from arramon_lang.tokens import ScriptTokenizer
from tests.lang.test_lexicon import EMPTY

OutlineEntry = tuple[str, str | None]


def relations(code: str, text: str) -> list[OutlineEntry]:
    """Return each mention's attributes, and the relation whose landmark it is."""
    language = load(code)
    return [(text[m.start : m.end], language.relation_of(text, m)) for m in language.find_objects(text)]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Put the ball on top of the mug.", [("ball", None), ("mug", "on_top_of")]),
        ("Place the ball on top the red book", [("ball", None), ("red book", "on_top_of")]),
        ("Place it Atop the Red Book", [("Red Book", "on_top_of")]),
        ("place the bowl ontop of the dotted tv", [("bowl", None), ("dotted tv", "on_top_of")]),
        ("drop the mug on the white bucket", [("mug", None), ("white bucket", "on_top_of")]),
        ("Place bowl on the top of that green one that is striped", [("bowl", None), ("green one", "on_top_of")]),
        ("put it to the left of the tv", [("tv", "left_of")]),
        ("put it on the right side of the tv", [("tv", "right_of")]),
        ("put it on the right-hand side of the tv", [("tv", "right_of")]),
        ("directly in front of the red book", [("red book", "in_front_of")]),
        ("infront of teh stiped book", [("stiped book", "in_front_of")]),
        ("behind the dotted blue bowl", [("dotted blue bowl", "behind")]),
        ("behing the bowl, agaisnt the bucket", [("bowl", "behind"), ("bucket", "against")]),
        ("next to the bowl and close to a mug", [("bowl", "near"), ("mug", "near")]),
        ("closest to the bowl", [("bowl", "near")]),
        # Both landmarks that a conjunction joins; a wall is one too.
        ("between the red mug and the green ball", [("red mug", "between"), ("green ball", "between")]),
        ("between the brick wall and the mug", [("mug", "between")]),
        ("in between the mug and the striped wall", [("mug", "between")]),
        ("behind the stack of the green book and the mug", [("green book", "behind"), ("mug", "behind")]),
        # A conjunction that joins something else.
        ("Turn right and the striped mug is there", [("striped mug", None)]),
        ("Look behind you and put the mug down", [("mug", None)]),
        ("Turn to the right. Place the mug there", [("mug", None)]),
        ("on your right, the mug", [("mug", None)]),
        ("the mug", [("mug", None)]),
        # A chain.
        (
            "the ball on the book that is behind the tv to the right of the bowl",
            [("ball", None), ("book", "on_top_of"), ("tv", "behind"), ("bowl", "right_of")],
        ),
    ],
)
def test_english_relations_are_found(text: str, expected: list[OutlineEntry]) -> None:
    assert relations("en", text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("मग को बिंदीदार हरे टीवी के पीछे रखें।", [("मग", None), ("बिंदीदार हरे टीवी", "behind")]),
        ("गेंद को धारीदार भूरी किताब के बाईं ओर रख दीजिए।", [("गेंद", None), ("धारीदार भूरी किताब", "left_of")]),
        (
            "दाएँ मुड़ें और पीले कटोरे को बिंदीदार सफ़ेद बाल्टी के ऊपर रखें।",
            [("पीले कटोरे", None), ("बिंदीदार सफ़ेद बाल्टी", "on_top_of")],
        ),
        (
            "रेतघड़ी को ईंट की दीवार और धारीदार नीले मग के बीच रखें।",
            [("रेतघड़ी", None), ("धारीदार नीले मग", "between")],
        ),
        ("उसे धब्बेदार दीवार के सामने, हरे कटोरे के दाईं ओर रख दो।", [("हरे कटोरे", "right_of")]),
        ("बाल्टी को लाल गेंद के पीछे, लकड़ी की दीवार से सटाकर रखिए।", [("बाल्टी", None), ("लाल गेंद", "behind")]),
        ("बाएँ मुड़ें। इस टीवी को बिंदीदार पीले टीवी के ऊपर रखें।", [("टीवी", None), ("बिंदीदार पीले टीवी", "on_top_of")]),
        (
            "लाल कटोरे को धारीदार हरी किताब और बिंदीदार सफ़ेद मग के ढेर के पीछे रखें।",
            [("लाल कटोरे", None), ("धारीदार हरी किताब", "behind"), ("बिंदीदार सफ़ेद मग", "behind")],
        ),
        (
            "हरी गेंद को भूरी रेतघड़ी के ठीक दाईं ओर, धारीदार दीवार के पास रखें।",
            [("हरी गेंद", None), ("भूरी रेतघड़ी", "right_of")],
        ),
        (
            "सफ़ेद रेतघड़ी को उस नीली बाल्टी के ऊपर रखिए जो बिंदीदार टीवी के सामने है।",
            [("सफ़ेद रेतघड़ी", None), ("नीली बाल्टी", "on_top_of"), ("बिंदीदार टीवी", "in_front_of")],
        ),
        ("मग को लाल किताब पर रख दें।", [("मग", None), ("लाल किताब", "on_top_of")]),
        ("गेंद को मग और ईंट की दीवार के बीच रखें।", [("गेंद", None), ("मग", "between")]),
        ("मग को गेंद से सटाकर, टीवी के बगल में रखें।", [("मग", None), ("गेंद", "against"), ("टीवी", "near")]),
        # One letter wrong; but what is one letter from left and from right alike is neither.
        ("मग के सामनें, गेंद से सटाककर", [("मग", "in_front_of"), ("गेंद", "against")]),
        ("मग के गायीं ओर", [("मग", None)]),
        ("मग के दायीं ओर", [("मग", "right_of")]),
        ("मग उठाएँ और टीवी के पीछे जाएँ।", [("मग", None), ("टीवी", "behind")]),
    ],
)
def test_hindi_relations_are_found(text: str, expected: list[OutlineEntry]) -> None:
    assert relations("hi", text) == expected


@pytest.mark.parametrize("code", available())
def test_every_relation_phrase_is_recognised(code: str) -> None:
    data = tomllib.loads((ROOT / code / "relations.toml").read_text(encoding="utf-8"))
    ball = tomllib.loads((ROOT / code / "lexicon.toml").read_text(encoding="utf-8"))["kinds"]["ball"][0]
    assert tuple(data["phrases"]) == RELATIONS
    for relation, phrases in data["phrases"].items():
        for phrase in phrases:
            text = f"{phrase} {ball}" if data["position"] == "before" else f"{ball} {phrase}"
            assert relations(code, text) == [(ball, relation)], text


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"position": "around"}, "position 'around' is not one of before, after"),
        ({"phrases": {"behind": ["behind"]}}, "phrases for behind; expected on_top_of"),
        ({"phrases": {key: [] for key in (*RELATIONS, "under")}}, "under; expected"),
    ],
)
def test_invalid_relation_data_is_refused(changes: dict[str, object], message: str) -> None:
    data = {"position": "before", "conjunctions": [], "skipped": [], "phrases": {key: [] for key in RELATIONS}}
    tokenizer = ScriptTokenizer("a-z")
    lexicon = Lexicon(EMPTY | {"kinds": {"ball": ["ball"]}}, tokenizer)
    Relations(data, tokenizer, lexicon)
    with pytest.raises(ValueError, match=message):
        Relations(data | changes, tokenizer, lexicon)
