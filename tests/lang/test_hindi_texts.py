"""Hindi instructions: spelling, register, quality, and reading back to the meaning."""

import re
import unicodedata
from functools import cache
from random import Random

import pytest

from arramon_lang import load
from arramon_lang.coreference import first_mentions
from arramon_lang.meaning import Assembly, Face, Meaning, Navigation, Rotate, Step, Thing, Walk, Where
from arramon_lang.quality import BLOCKED, check
from tests.lang import random_meanings

REGISTERS = {
    "neutral": "मुड़ें घूमें चलें बढ़ें रहें गुज़रें निकलें करें उठाएँ लें रखें दें टिकाएँ छोड़ें पहुँचें ढूँढ़ें खोजें देखें",
    "polite": "मुड़िए घूमिए चलिए बढ़िए रहिए जाइए गुज़रिए निकलिए कीजिए उठाइए लीजिए रखिए दीजिए टिकाइए छोड़िए पहुँचिए खोजिए",
    "familiar": "मुड़ो घूमो चलो बढ़ो रहो जाओ गुज़रो निकलो करो उठाओ लो रखो टिकाओ छोड़ो पहुँचो खोजो तुमने तुम्हें तुम्हारे",
}
"""Words specific to one register; the two others share आप."""

FEMININE = "गेंद|बॉल|रेतघड़ी|किताब|पुस्तक|बाल्टी|बेंच|इमारत|दीवार|सड़क|गली"
MASCULINE = "मग|कप|प्याला|प्याले|टीवी|कटोरा|कटोरे|बाउल|कोन|पेड़|बैनर|झंडा|झंडे|ड्रम"

MISTAKES = {
    "a space before the danda": r"\s।",
    "no space after a mark": r"[,;।][^\s]",
    "two marks": r"[,;।]\s*[,;।]",
    "Latin letters": r"[A-Za-z]",
    "a joiner": "[\u200c\u200d]",
    "another spelling of बाएँ or दाएँ": r"(बा|दा)(एं|यें|यीं)",
    "no nukta": "सफेद|फोन|तरफ(?!\u093c)|ट्रैफिक|फायर|नजदीक|करीब|गुजर|मुड(?!\u093c)",
    "a direct form before a postposition": "(कटोरा|प्याला|झंडा|चौराहा|खंभा|डिब्बा|पीपा) (के|की|को|से|पर|तक|में)(?=[ ,।])",
    "the agent of an imperative": "(?<=[ ,।])ने(?=[ ,।])",
    "an adjective apart from its feminine noun": f"(हरा|नीला|पीला|भूरा|पहला|हरे|नीले|पीले|भूरे) ({FEMININE})(?=[ ,।])",
    "an adjective apart from its masculine noun": f"(हरी|नीली|पीली|भूरी|काली|पहली|दूसरी) ({MASCULINE})(?=[ ,।])",
}

MUG, BALL, BOOK = Thing("mug", "red", "striped"), Thing("ball", "blue", "dotted"), Thing("book", "white", "striped")
HYDRANT, BENCH, PHONE, TREE = Thing("hydrant"), Thing("bench"), Thing("phone_booth"), Thing("tree")


def near(*things: Thing, relation: str = "near", exactly: bool = False) -> tuple[Where, ...]:
    return (Where(relation, things, exactly),)


def what(thing: Thing, where: tuple[Where, ...]) -> Thing:
    return Thing(thing.kind, thing.colour, thing.look, thing.which, where)


BY_HAND: list[tuple[str, Meaning]] = [
    (
        "बाएँ मुड़ें और फ़ायर हाइड्रेंट तक सीधे चलें। बेंच के पास रखा धारीदार लाल मग उठा लें।",
        Navigation((Rotate("left"), Walk("to", (HYDRANT,))), what(MUG, near(BENCH))),
    ),
    (
        "पीछे मुड़िए, फ़ोन बूथ से आगे निकलकर चौराहे पर दाएँ मुड़िए। पेड़ के नीचे बिंदीदार नीली गेंद है, उसे उठा लीजिए।",
        Navigation(
            (Rotate("around"), Walk("past", (PHONE,)), Rotate("right", "at", Thing("intersection"))),
            what(BALL, near(TREE)),
        ),
    ),
    (
        "कूड़ेदान के आगे से सीधे निकलें, फिर भूरी इमारत के पास से बाएँ मुड़ें। लेटर बॉक्स के सामने रखी बिंदीदार बैंगनी रेतघड़ी उठा लें।",
        Navigation(
            (Walk("past", (Thing("bin"),)), Rotate("left", "at", Thing("building", look="brown"))),
            what(Thing("hourglass", "purple", "dotted"), near(Thing("mailbox"), relation="in_front_of")),
        ),
    ),
    (
        "थोड़ा दाएँ मुड़ो और दीवार के साथ-साथ चलते रहो। ड्रम के पीछे रखी धारीदार सफ़ेद किताब उठा लो।",
        Navigation(
            (Rotate("slightly right"), Walk("along", (Thing("wall"),))),
            what(BOOK, near(Thing("barrel"), relation="behind")),
        ),
    ),
    (
        "ट्रैफ़िक लाइट तक जाइए, दाएँ मुड़िए और फ़ायर हाइड्रेंट तक चलते रहिए। "
        "हाइड्रेंट के बाईं ओर एक बिंदीदार भूरी बाल्टी रखी है। उसे उठाइए।",
        Navigation(
            (Walk("to", (Thing("traffic_light"),)), Rotate("right"), Walk("to", (HYDRANT,))),
            what(Thing("bucket", "brown", "dotted"), near(HYDRANT, relation="left_of")),
        ),
    ),
    (
        "हरी इमारत की ओर मुँह करें और सड़क पार करें। दूसरे पेड़ के पास एक धारीदार बैंगनी टीवी है, उसे उठा लें।",
        Navigation(
            (Face(Thing("building", look="green")), Walk("past", (Thing("street"),))),
            what(Thing("tv", "purple", "striped"), near(Thing("tree", which="second"))),
        ),
    ),
    (
        "नुक्कड़ पर बाएं मुड़ें और बेंच से आगे निकलें। फोन बूथ के पास रखा बिंदीदार लाल कटोरा उठाएं ।",
        Navigation(
            (Rotate("left", "at", Thing("corner")), Walk("past", (BENCH,))),
            what(Thing("bowl", "red", "dotted"), near(PHONE)),
        ),
    ),
    (
        "तब तक आगे चलें जब तक बेंच आपके बाईं ओर न आ जाए, फिर पीछे मुड़ें। सफेद धारीदार किताब उठा लें।",
        Navigation((Walk("beside", (BENCH,), "left"), Rotate("around")), BOOK),
    ),
    (
        "पीले बैनर के बाद दाएँ मुड़िए, लैंप पोस्ट के पास से होते हुए ट्रैफ़िक कोन तक जाइए और रुकिए। बिंदीदार नीली गेंद ले लीजिए।",
        Navigation(
            (
                Rotate("right", "after", Thing("banner", "yellow")),
                Walk("past", (Thing("lamp_post"),)),
                Walk("to", (Thing("cone"),)),
            ),
            BALL,
        ),
    ),
    (
        "मग को बिंदीदार हरे टीवी के पीछे रखें।",
        Assembly((), Thing("mug"), near(Thing("tv", "green", "dotted"), relation="behind")),
    ),
    (
        "दाएँ मुड़ें और पीले कटोरे को बिंदीदार सफ़ेद बाल्टी के ऊपर रखें।",
        Assembly(("right",), Thing("bowl", "yellow"), near(Thing("bucket", "white", "dotted"), relation="on_top_of")),
    ),
    (
        "रेतघड़ी को ईंट की दीवार और धारीदार लाल मग के बीच रखें।",
        Assembly((), Thing("hourglass"), near(Thing("wall", look="brick"), MUG, relation="between")),
    ),
    (
        "उसे धब्बेदार दीवार के सामने, हरे कटोरे के दाईं ओर रख दो।",
        Assembly(
            (),
            Thing(""),
            near(Thing("wall", look="spotted"), relation="in_front_of")
            + near(Thing("bowl", "green"), relation="right_of"),
        ),
    ),
    (
        "बाल्टी को लाल गेंद के पीछे, लकड़ी की दीवार से सटाकर रखिए।",
        Assembly(
            (),
            Thing("bucket"),
            near(Thing("ball", "red"), relation="behind") + near(Thing("wall", look="wood"), relation="against"),
        ),
    ),
    (
        "हरी गेंद को भूरी रेतघड़ी के ठीक दाईं ओर, धारीदार दीवार के पास रखें।",
        Assembly(
            (),
            Thing("ball", "green"),
            near(Thing("hourglass", "brown"), relation="right_of", exactly=True) + near(Thing("wall", look="striped")),
        ),
    ),
]
"""Texts written by hand, some with variant spellings."""


@pytest.mark.parametrize(("text", "meaning"), BY_HAND)
def test_human_written_texts_are_read(text: str, meaning: Meaning) -> None:
    phase = "navigation" if isinstance(meaning, Navigation) else "assembly"
    assert load("hi").read(text, phase) == meaning


@cache
def written() -> tuple[tuple[Meaning, str], ...]:
    """Return texts of random meanings; written once, as such meanings take a third of a second each."""
    random = Random(1)
    return tuple((meaning, load("hi").write(meaning, random)) for meaning in random_meanings.meanings(random, 150))


def phase_of(meaning: Meaning) -> str:
    return "navigation" if isinstance(meaning, Navigation) else "assembly"


def test_written_texts_have_no_spelling_or_agreement_mistakes() -> None:
    for _, text in written():
        assert text[-1] not in ",;."
        assert text == unicodedata.normalize("NFC", text)
        assert text == " ".join(text.split())
        for mistake, pattern in MISTAKES.items():
            assert not re.search(unicodedata.normalize("NFC", pattern), text), (mistake, text)


def test_written_texts_keep_to_one_register() -> None:
    words = {name: set(unicodedata.normalize("NFC", listed).split()) for name, listed in REGISTERS.items()}
    seen = set()
    for _, text in written():
        said = {re.sub(r"[,;।]", "", word) for word in text.split()}
        used = {name for name, of_it in words.items() if said & of_it}
        assert len(used) <= 1, (used, text)
        seen |= used
    assert seen == set(words)


def test_written_texts_pass_the_quality_checks() -> None:
    for meaning, text in written():
        failures = check(text, "hi", phase_of(meaning))
        assert [f for f in failures if f.severity == BLOCKED] == [], text
        # Random meanings are of grey buildings, counted paces and many steps; what planners choose is not.
        assert {f.check for f in failures} <= {"grey_building", "count", "long"}, (text, failures)


def test_written_texts_are_read_back_to_their_meaning() -> None:
    texts = written()
    wrong = []
    for meaning, text in texts:
        read = load("hi").read(text, phase_of(meaning))
        if read != meaning or first_mentions(read) != first_mentions(meaning):
            wrong.append(text)
    assert len(wrong) <= 0.01 * len(texts), wrong


STEPS: list[Step] = [Rotate("left"), Walk("ahead"), Walk("to", (HYDRANT,)), Face(TREE)]


def test_written_texts_vary_with_the_seed() -> None:
    meaning = Navigation(tuple(STEPS), what(MUG, near(BENCH)))
    texts = {load("hi").write(meaning, Random(seed)) for seed in range(50)}
    assert len(texts) == 50
    assert load("hi").write(meaning, Random(7)) == load("hi").write(meaning, Random(7))
