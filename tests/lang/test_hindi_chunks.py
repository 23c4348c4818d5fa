"""Reading of free Hindi texts by chunks, beyond the written phrases."""

import pytest

from arramon_lang import load
from arramon_lang.meaning import Assembly, Face, Navigation, Rotate, Step, Thing, Walk, Where

CONE, BOOTH, BANK = Thing("cone", "blue"), Thing("phone_booth"), Thing("shop_sign", look="bank")
BALL, YOU = Thing("ball", "red", "striped"), Thing("you")

STEPS: list[tuple[str, tuple[Step, ...]]] = [
    ("फ़ोन बूथ, नीला कोन दाहिने। लाल धारीदार गेंद", (Walk("past", (BOOTH,), "right"), Walk("past", (CONE,), "right"))),
    ("बाईं तरफ़ फ़ोन बूथ छूटेगा, आगे लाल धारीदार गेंद है", (Walk("past", (BOOTH,), "left"),)),
    ("बैंक तक आ जाओ और वहां राइट। लाल धारीदार गेंद", (Walk("to", (BANK,)), Rotate("right", "at", BANK))),
    ("फोन बूथ के थोड़ा आगे लेफ्ट लो, लाल धारीदार गेंद है", (Rotate("left", "after", BOOTH),)),
    ("दाएँ पलटकर नीले कोन के पास से निकलके लाल धारीदार बॉल", (Rotate("around"), Walk("past", (CONE,)))),
    ("BANK की ओर ज़रा-सा दाएँ घूमो, लाल धारीदार गेंद", (Rotate("slightly right"), Walk("towards", (BANK,)))),
    ("बाएं - नीले कोन तक - फिर दाएं — लाल धारीदार गेंद", (Rotate("left"), Walk("to", (CONE,)), Rotate("right"))),
    ("दाएं हो जा भाई, नीले वाले कोन तक चल, लाल धारीदार गेंद", (Rotate("right"), Walk("to", (CONE,)))),
    ("नीला कोन दिखेगा, उसे पार करो, लाल धारीदार गेंद", (Walk("until", (CONE,)), Walk("past", (CONE,)))),
    ("से पीछे, नीले कोन तक, लाल धारीदार गेंद", (Walk("to", (CONE,)),)),
    ("जब तक फ़ोन बूथ आपके बाएँ न आए, चलो; लाल धारीदार गेंद", (Walk("beside", (BOOTH,), "left"),)),
]


@pytest.mark.parametrize(("text", "steps"), STEPS)
def test_steps_of_free_texts(text: str, steps: tuple[Step, ...]) -> None:
    meaning = load("hi").read(text, "navigation")
    assert isinstance(meaning, Navigation)
    assert tuple(step for step in meaning.steps if step != Walk("ahead")) == steps
    assert (meaning.target.kind, meaning.target.colour, meaning.target.look) == ("ball", "red", "striped")


TREE, STREET, MUG = Thing("tree"), Thing("street", which="first"), Thing("mug", "green", "dotted")

NOTES: list[tuple[str, tuple[Step, ...], tuple[Where, ...]]] = [
    ("वापस, पेड़ तक, लाल धारीदार गेंद", (Rotate("around"), Walk("to", (TREE,))), ()),
    ("थोड़ा बाएँ, सीधे, पेड़ के पीछे लाल धारीदार गेंद", (Rotate("slightly left"),), (Where("behind", (TREE,)),)),
    ("थोड़ा दाएँ, पेड़ की बगल में लाल धारीदार गेंद", (Rotate("slightly right"),), (Where("near", (TREE,)),)),
    ("नीले कोन के पास से, बाएँ, पेड़ तक, लाल धारीदार गेंद", (Walk("past", (CONE,)), Rotate("left"), Walk("to", (TREE,))), ()),
    ("नीले कोन के पास से बाएँ, लाल धारीदार गेंद", (Rotate("left", "at", CONE),), ()),
    ("नीले कोन के बाद दाएँ, लाल धारीदार गेंद", (Rotate("right", "after", CONE),), ()),
    ("दाएँ, सामने पेड़ दिखेगा, वहाँ तक, लाल धारीदार गेंद", (Rotate("right"), Face(TREE), Walk("to", (TREE,))), ()),
    ("पीछे, सामने पेड़, सीधे, लाल धारीदार गेंद", (Rotate("around"), Face(TREE)), ()),
    ("पेड़ के पास, नीले कोन के पास से, लाल धारीदार गेंद", (Walk("to", (TREE,)), Walk("past", (CONE,))), ()),
    ("बाईं ओर वाली पहली सड़क पर, पेड़ की ओर, लाल धारीदार गेंद", (Rotate("left", "at", STREET), Walk("towards", (TREE,))), ()),
    ("दाईं ओर वाली पहली सड़क पकड़ लो, लाल धारीदार गेंद", (Rotate("right", "at", STREET),), ()),
    ("बाईं ओर वाली सड़क पर, लाल धारीदार गेंद", (Rotate("left", "at", Thing("street")),), ()),
    ("पहली सड़क पर बाएँ, पेड़ तक, लाल धारीदार गेंद", (Rotate("left", "at", STREET), Walk("to", (TREE,))), ()),
    (
        "पेड़ की ओर, लेकिन वहाँ पहुँचने से पहले बाएँ, बैंक तक, लाल धारीदार गेंद",
        (Face(TREE), Walk("towards", (TREE,)), Rotate("left", "before", TREE), Walk("to", (BANK,))),
        (),
    ),
    ("पेड़ के पास से, वह आपकी बाईं तरफ़ रहेगा, लाल धारीदार गेंद", (Walk("past", (TREE,), "left"),), ()),
    ("पेड़ के उस पार लाल धारीदार गेंद", (), (Where("behind", (TREE,)),)),
    ("पेड़ तक, उसके आगे रखी लाल धारीदार गेंद", (Walk("to", (TREE,)),), (Where("in_front_of", (TREE,)),)),
    ("दाएँ, लाल धारीदार गेंद, हरे बिंदीदार मग के पास", (Rotate("right"),), (Where("near", (MUG,)),)),
]  # fmt: skip


@pytest.mark.parametrize(("text", "steps", "where"), NOTES)
def test_notes_without_verbs(text: str, steps: tuple[Step, ...], where: tuple[Where, ...]) -> None:
    meaning = load("hi").read(text, "navigation")
    assert isinstance(meaning, Navigation)
    assert tuple(step for step in meaning.steps if step != Walk("ahead")) == steps
    assert (meaning.target.kind, meaning.target.colour, meaning.target.look) == ("ball", "red", "striped")
    assert meaning.target.where == where


TARGETS: list[tuple[str, str, tuple[Where, ...]]] = [
    ("बैंक के सामने लाल गेंद है धारियों वाली", "striped", (Where("in_front_of", (BANK,)),)),
    ("नीले कोन से ज़रा पहले लाल धारीदार गेंद; हरा मग नहीं", "striped", (Where("in_front_of", (CONE,)),)),
    ("आगे पीली गेंद भी है, वो नहीं चाहिए। फ़ोन बूथ के बाएँ लाल धारीदार गेंद", "striped", (Where("left_of", (BOOTH,)),)),
]


@pytest.mark.parametrize(("text", "look", "where"), TARGETS)
def test_targets_of_free_texts(text: str, look: str, where: tuple[Where, ...]) -> None:
    meaning = load("hi").read(text, "navigation")
    assert isinstance(meaning, Navigation)
    assert (meaning.target.colour, meaning.target.look, meaning.target.where) == ("red", look, where)


ROOMS: list[tuple[str, tuple[str, ...], str, tuple[Where, ...]]] = [
    ("टाइल की ठीक बाईं बगल में", (), "", (Where("left_of", (YOU,), exactly=True),)),
    ("तुम्हारे और लाल धारीदार गेंद के बीच में मग रख दो", (), "mug", (Where("between", (YOU, BALL)),)),
    ("अपनी बाईं तरफ़ देखो, मग लाल धारीदार गेंद पे रख दो", ("left",), "mug", (Where("on_top_of", (BALL,)),)),
    ("लाल धारीदार गेंद से एक ख़ाना इधर", (), "", (Where("in_front_of", (BALL,)),)),
    ("लाल धारीदार गेंद से तिरछा पीछे", (), "", (Where("diagonal_to", (BALL,)),)),
]


@pytest.mark.parametrize(("text", "turns", "kind", "where"), ROOMS)
def test_assemblies_of_free_texts(text: str, turns: tuple[str, ...], kind: str, where: tuple[Where, ...]) -> None:
    meaning = load("hi").read(text, "assembly")
    assert isinstance(meaning, Assembly)
    assert (meaning.turns, meaning.thing.kind, meaning.where) == (turns, kind, where)


def test_what_is_said_of_a_landmark_is_not_said_of_the_place() -> None:
    meaning = load("hi").read("बाईं तरफ़ लाल धारीदार गेंद है, मग को उसके पीछे रखो", "assembly")
    assert isinstance(meaning, Assembly)
    ball = Thing("ball", "red", "striped", where=(Where("left_of", (YOU,)),))
    assert meaning.where == (Where("behind", (ball,)),)


@pytest.mark.parametrize(
    ("spelling", "thing"),
    [
        ("ग्रीन डम्पस्टर", Thing("dumpster", "green")),
        ("ऑरेंज वाइट बैरियर", Thing("barrier", "white")),
        ("स्टॉप बोर्ड", Thing("stop_sign")),
        ("stop board", Thing("stop_sign")),
        ("T-point", Thing("t_junction")),
        ("per", Thing("tree")),
        ("chowk", Thing("square")),
        ("orange-white barrier", Thing("barrier", "white")),
        ("स्ट्रीट के आख़िर", Thing("street_end")),
    ],
)
def test_loans_and_their_spellings(spelling: str, thing: Thing) -> None:
    if spelling.isascii():
        text = f"{spelling} tak jao. laal dhaaridaar gend uthao"
    else:
        text = f"{spelling} तक जाओ। रेड स्ट्राइप्ड बॉल पिक करो"
    meaning = load("hi").read(text, "navigation")
    assert isinstance(meaning, Navigation)
    assert meaning.steps == (Walk("to", (thing,)),)
    assert (meaning.target.kind, meaning.target.colour, meaning.target.look) == ("ball", "red", "striped")


@pytest.mark.parametrize("spelling", ["काँच", "कांच"])
@pytest.mark.parametrize("verb", ["मुड़ो", "मुडो"])
def test_spellings_are_folded(spelling: str, verb: str) -> None:
    meaning = load("hi").read(f"{spelling} वाली बिल्डिंग पे लेफ्ट {verb}, लाल धारीदार गेंद", "navigation")
    assert isinstance(meaning, Navigation)
    assert meaning.steps == (Rotate("left", "at", Thing("building", look="glass")),)
