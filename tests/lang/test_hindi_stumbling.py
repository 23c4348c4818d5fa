"""Kinds of Hindi at which a native reader stumbled, and that are no longer written."""

import re
import unicodedata
from collections.abc import Callable
from dataclasses import replace
from random import Random

import pytest

from arramon_lang import load
from arramon_lang.meaning import Assembly, Face, Meaning, Navigation, Rotate, Step, Thing, Walk, Where

HINDI = load("hi")
MUG = Thing("mug", "red", "striped", identity="9")
KIOSK, CONE = Thing("kiosk", "blue", identity="1"), Thing("cone", "red", identity="2")
BENCH, TYRES = Thing("bench", identity="3"), Thing("tyre_stack", identity="4")
CAR, ARCHED = Thing("car", "blue", identity="7"), Thing("building", look="arched", identity="8")
BARRIERS, TREE = Thing("barrier", number="two", identity="11"), Thing("tree", identity="12")
CROSSROADS = Thing("intersection", identity="10", arms=4)
END, CORNER = Thing("street_end", identity="5"), Thing("corner", identity="6")


def written(meaning: Meaning, count: int = 40) -> list[str]:
    return [HINDI.write(meaning, Random(seed)) for seed in range(count)]


def found(texts: list[str], pattern: str) -> list[str]:
    return [text for text in texts if re.search(unicodedata.normalize("NFC", pattern), text)]


@pytest.mark.parametrize(
    ("steps", "never"),
    [
        ((Face(KIOSK), Walk("to", (KIOSK,))), "मुँह कर|मुड़(ें|ो|िए) और"),
        ((Face(KIOSK), Walk("towards", (KIOSK,))), "मुँह कर|मुड़(ें|ो|िए) और"),
        ((Rotate("left"), Face(KIOSK)), "(बाएँ|बाईं ओर|बाईं तरफ़|लेफ़्ट) (नीले|नीली)"),
        ((Walk("to", (CONE,)), Rotate("left", "at", END)), "छोर|सिरे"),
        ((Rotate("around"), Rotate("left", "at", CORNER)), "(मुड़|घूम)कर [^।,]*(मोड़|नुक्कड़) पर (बाएँ|बाईं|लेफ़्ट)"),
        ((Walk("past", (BENCH,)), Walk("past", (TYRES,))), "बेंच और टायरों"),
        ((Rotate("left"), Walk("past", (CONE,))), "कर [^।,]*(दिखेग|मिलेग|नज़र आएग)|(ें|ो|िए) और [^।,]*(दिखेग|मिलेग)"),
        ((Rotate("left"), Face(CAR)), "(इतना|कर|और) [^।]*खड़ी"),
        ((Face(CAR), Walk("past", (CAR,))), "(इतना|कर|और) [^।]*खड़ी|पीछे छोड़"),
        (
            (Walk("towards", (KIOSK,)), Rotate("right")),
            "की (ओर|तरफ़) [^।,]*[।,] (दाएँ|दाईं|राइट)|कर (दाएँ|राइट)",
        ),
        ((Rotate("left", "at", CROSSROADS), Walk("past", (CONE,))), "(चौराहे|क्रॉसिंग) के पास"),
        ((Walk("past", (CONE,)), Walk("past", (ARCHED,))), " और मेहराब[^।,]*वाल[^।,]* से "),
        ((Rotate("slightly left"), Walk("past", (CONE,))), "हल्का बायाँ|गुज़र जा"),
        ((Walk("past", (BENCH,), "left"),), "(रखते|छोड़ते) हुए"),
        ((Walk("until", (CONE,)), Rotate("left")), "(चलते|बढ़ते) (रह|जा)[^ ।,]* और "),
        ((Rotate("around"), Face(CONE), Walk("past", (CONE,)), Rotate("left")), "उस(के|की|से) [^।]*उसके बाद|ी, उसके बाद"),
        ((Walk("past", (CONE,)),), "लीजिएगा|उठा लेना|रेत घड़ी"),
        ((Walk("past", (CONE,)),), "(गुज़र|निकल|बढ़)(?!कर)[^ ।,]*[।,] वहाँ जो"),
        ((Walk("past", (replace(TREE, which="first"),)),), "(^|[।,] |और |फिर )पहले पेड़"),
        ((Walk("to", (MUG,)),), "(मग|कप) आने"),
        ((Walk("to", (BARRIERS,)),), "दोनों [^।,]*ों तक"),
        ((Walk("past", (CONE,)),), "(^|।|,|और|कर) (धारीदार )?लाल (मग|कप)( को)? (उठा|ले)"),
    ],
)
def test_steps(steps: tuple[Step, ...], never: str) -> None:
    meaning = Navigation(steps, MUG)
    texts = written(meaning)
    assert found(texts, never) == []
    assert {HINDI.read(text, "navigation") for text in texts} == {meaning}


MOVABLE = [
    Thing(kind, identity="7") for kind, nouns in HINDI.grammar.nouns.items() if ("motion", "movable") in nouns[0].given
]


def test_cars_are_movable() -> None:
    assert [thing.kind for thing in MOVABLE] == ["car"]


@pytest.mark.parametrize("thing", [*MOVABLE, CONE], ids=lambda thing: thing.kind)
@pytest.mark.parametrize(
    "step",
    [
        *(lambda thing, at=at: Rotate("left", at, thing) for at in ("at", "before", "after")),
        *(lambda thing, way=way: Walk(way, (thing,)) for way in ("to", "past", "towards", "until")),
        lambda thing: Walk("beside", (thing,), "left"),
        lambda thing: Walk("past", (thing,), "right"),
        Face,
        lambda thing: Walk("to", (replace(thing, number="two"),)),
    ],
)
def test_only_what_does_not_move_comes(thing: Thing, step: Callable[[Thing], Step]) -> None:
    meaning = Navigation((step(thing),), MUG)
    texts = written(meaning, 20)
    assert {HINDI.read(text, "navigation") for text in texts} == {meaning}
    if thing in MOVABLE:
        assert found(texts, "(?<![\u0900-\u097f])(?<!नज़र )(आने|आए|आ जाए|आएग[ाी]|आते)(?![\u0900-\u097f])") == []


def test_a_still_thing_comes() -> None:
    texts = written(Navigation((Walk("to", (CONE,)), Rotate("left")), MUG))
    assert found(texts, "कोन (आने|न आ जाए)")


@pytest.mark.parametrize("position", ["before", "after"])
def test_one_walks_between_facing_a_thing_and_a_turn(position: str) -> None:
    meaning = Navigation((Face(KIOSK), Rotate("right", position, KIOSK)), MUG)
    texts = written(meaning)
    assert len(found(texts, "उस(की|ी) (ओर|तरफ़) |आगे निकल")) == len(texts)
    assert {HINDI.read(text, "navigation") for text in texts} == {meaning}


@pytest.mark.parametrize("relation", ["on_top_of", "left_of", "in_front_of", "behind", "near"])
def test_a_landmark_with_a_place_of_its_own_is_told_in_a_clause_of_its_own(relation: str) -> None:
    hourglass = Thing("hourglass", "blue", "dotted", identity="1")
    tv = Thing("tv", "green", "striped", where=(Where("in_front_of", (hourglass,)),), identity="2")
    meaning = Assembly((), MUG, (Where(relation, (tv,)),))
    texts = written(meaning)
    assert len(found(texts, "^((?! को ).)*सामने जो [^।]* है, (उस|उसके|उसकी) ")) == len(texts)
    assert {HINDI.read(text, "assembly") for text in texts} == {meaning}


def test_the_object_stands_before_two_places() -> None:
    wall, book = Thing("wall", look="wood"), Thing("book", "white", "dotted", identity="1")
    meaning = Assembly((), MUG, (Where("against", (wall,)), Where("diagonal_to", (book,))))
    texts = written(meaning)
    assert found(texts, "(के तिरछे|तिरछे वाल|लेकर )|(मग|कप) रख") == []
    assert {HINDI.read(text, "assembly") for text in texts} == {meaning}


def test_two_walls_and_one_noun_for_two_things() -> None:
    walls = tuple(Where("against", (Thing("wall", look=look),)) for look in ("wood", "striped"))
    between = Assembly((), MUG, walls)
    texts = written(between)
    assert len(found(texts, "दीवार दोनों से सटाकर")) > len(texts) / 2
    assert {HINDI.read(text, "assembly") for text in texts} == {between}
    tv = Thing("tv", "blue", "dotted", identity="1")
    on_another = Assembly((), Thing("tv"), (Where("on_top_of", (tv,)),))
    texts = written(on_another)
    assert found(texts, "(^|। )टीवी (को )?(?!.*टेलीविज़न).*टीवी (के|पर)|बस ") == []
    assert {HINDI.read(text, "assembly") for text in texts} == {on_another}


def test_beside_another_place_a_landmark_is_told_in_few_words() -> None:
    hourglass, bucket = Thing("hourglass", "blue", "dotted", identity="1"), Thing("bucket", "white", identity="3")
    tv = Thing("tv", "green", "striped", where=(Where("behind", (hourglass,)),), identity="2")
    meaning = Assembly((), MUG, (Where("right_of", (bucket,)), Where("diagonal_to", (tv,))))
    texts = written(meaning)
    assert found(texts, "जो .*जो ") == []
    assert len(found(texts, "पीछे वाले [^।]*से तिरछी दिशा में ")) == len(texts)
    assert {HINDI.read(text, "assembly") for text in texts} == {meaning}


def test_two_things_beside_a_landmark_are_joined() -> None:
    beside = tuple(Where("near", (thing,)) for thing in (CONE, BENCH))
    mug = Thing("mug", "red", "striped", where=beside, identity="9")
    meaning = Navigation((Rotate("left"), Walk("to", (mug,))), mug)
    texts = written(meaning)
    assert found(texts, " व ") == []
    assert {HINDI.read(text, "navigation") for text in texts} == {meaning}


def test_one_walks_to_what_one_picks_up() -> None:
    meaning = Navigation((Rotate("left"), Walk("towards", (MUG,))), MUG)
    texts = written(meaning)
    assert len(found(texts, "की (ओर|तरफ़) (सीधे |आगे )?((जा|चले जा)(एँ|इए|ओ) और( फिर)?|(जा|चल|बढ़)कर) उस(े|को) ")) == len(
        texts
    )
    assert {HINDI.read(text, "navigation") for text in texts} == {meaning}


@pytest.mark.parametrize("relation", ["on_top_of", "left_of", "in_front_of", "behind"])
def test_the_object_in_hand_beside_another_of_its_kind_is_told_apart(relation: str) -> None:
    ball = Thing("ball", "green", "dotted", identity="1")
    meaning = Assembly((), Thing("ball"), (Where(relation, (ball,)),))
    texts = written(meaning)
    assert len(found(texts, "((^| )इस|हाथ में जो|(आप|तुम)ने जो) (गेंद|बॉल) ")) == len(texts)
    assert {HINDI.read(text, "assembly") for text in texts} == {meaning}


def test_placing_is_told_in_one_form() -> None:
    book = Thing("book", "green", "dotted", identity="1")
    for turns in ((), ("left",)):
        meaning = Assembly(turns, MUG, (Where("behind", (book,)),))
        texts = written(meaning)
        assert found(texts, "दीजिएगा|रख देना|^फिर |बस ") == []
        assert not turns or found(texts, "रखना है") == []
        assert {HINDI.read(text, "assembly") for text in texts} == {meaning}
