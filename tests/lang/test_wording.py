"""Wording of many random texts: natural to native speakers, and with one voice per episode."""

import re
import unicodedata
from dataclasses import replace
from functools import cache
from random import Random

import pytest

from arramon_lang import load
from arramon_lang.coreference import mentions
from arramon_lang.grammar import forms_of
from arramon_lang.meaning import Assembly, Face, Navigation, Rotate, Thing, Walk, Where
from tests.lang import random_meanings
from tests.lang.test_hindi_texts import REGISTERS

EPISODES = 130
"""Number of episodes; each has two turns, which makes 260 texts per phase."""

FORBIDDEN = {
    "en": {
        "a pronoun behind a verb's particle": r"\b(pick|scoop) up it\b|\bget hold of it\b",
        "a particle before a place": r"(?<!end )(?<!ends )\bup (to the (left|right)|in front|behind|next to|on top) ",
        "a turn joined to a statement": r"\b[Tt]urn[^.;]*,? (and|then) the [^.]* (belongs|goes|should|needs|has to)\b",
        "a sentence spliced by a comma": r"(^|\. )(Turn|Go|Walk|Head)\b[^.;]*, (there |you will |you'll |pick it )",
        "a place before its verb": r"(^|\. )(On|Atop|Upon|In|To|Behind|Against)\b[^.]*, (place|put|set) ",
        "a place in the middle": r"\b(and|then|after [a-z ]+,) (just )?(at|before|after|once|when) [^.,]*, (turn|take)",
        "bookish": r"\b(left|right)wards\b|\bsqueez|\bonward\b|\bjust short of .* just short of\b|\bpartly\b",
        "a thing that is none": r"\bspeed limit(?! (sign|board|post))",
        "words without a thing": r"\bThere, there\b|\bnow\b.* \bnow see\b|\bstart off as follows\b",
        "a word of walking alone": r"\b(head|travel) (until|till)\b",
        "near in part": r"\b(directly|immediately) (near|by|close to)\b",
        "an article apart from its noun": r"\b[Aa] (?=[aeiou]|hour)|\b[Aa]n (?![aeiou]|hour)",
        "twice the same word": r"\b(\w+) \1\b",
        "a side without whose": r"\b(on|to) (left|right)\b|[^.]\b(left|right) and to the (left|right) of\b",
        "a machine's wording": r"\bgets (placed|put)\b|\b[Tt]ry to\b",
        "another thing's shape": r"\b(star|diamond|triangle|circle|hexagon) (\w+ )?(banner|flag|poster)",
        "a colour of two": r"(?<!orange and )\bwhite (road |traffic |safety )?(barri|road ?block|blockade|divider)",
        "degrees": r"\b(90|180) degrees (?!turn)[^.]*(pick|collect|take|get|grab)",
        "a turn where one only sees": r"\bturn (left|right|to (the|your) (left|right)) (when|where) you see\b",
        "stilted": r"\b(situate|stow|stash|blockade|\w+ colored)\b|\b(all the way|completely|fully) around\b",
        "two forms of a word": r"(?i)\btoward\b.*\btowards\b|\btowards\b.*\btoward\b",
        "vague": r"\b(in the vicinity of|not far from|a (little way|short distance) from)\b",
        "where the diagonal is": r"\bdiagonal(ly)? from\b",
        "an hour of glass": r"\bhour glass",
        "to end": r"\b[Tt]o end,",
        "there, and to it": r"\b[Ff]rom (there|here)[^,.]*, [^.,]*\b(over |up )?to it\b",
        "a verb in another form": r"\b[Aa]fter (look|rotate|take|align|orient|position|leave|set|aim)\b",
        "slightly, of a place": r"\b(left|right) (slightly|a little) (before|after)\b",
    },
    "hi": {
        "another thing's shape": "(हीरे|तारे) के आकार|गोले वाल|कोनों वाल",
        "the order of a heap": "(उस|उसी|वह|वही|इस) (टायरों|कूड़े |कचरे )|ढेर(ों)? (की|के|का) (उस|उसी) ",
        "agreement of अपना": "अपने (बाईं|दाईं)|अपनी (बाएँ|दाएँ|सामने|पीछे)|(आपके|तुम्हारे) (बाईं|दाईं)",
        "officialese": "अवरोधक|यातायात|रुकने का|रुपहल|कचरा पेटी|बिजली का खंभ|तथा|निकट|आरंभ",
        "an old word": "(?<![\u0900-\u097f])पग(?![\u0900-\u097f])",
        "going on, with a count": "क़दम (आगे |सीधे |तक )?(चलते|बढ़ते)",
        "crossing what one passes": "(बैनर|झंडे|बैरिकेड|बैरियर|ड्रम|कोन|बेंच|पेड़|डंपस्टर) को पार",
        "you need": "चाहिए",
        "a state after this": "(इसके|उसके) बाद (?!जहाँ)(?:(?! और | जो )[^।,])* है[,;।]",
        "completely right": "बिल्कुल|एकदम",
        "mixed kinds of clause": "(मुड़ें|मुड़ो|मुड़िए|घूमें|घूमो|घूमिए|जाएँ|जाओ|जाइए) और [^।]*(रखना|रखनी) है",
        "repeated going past": "पार करके आगे निकलकर|आगे निकलकर[^।]* आगे निकलकर",
        "how, where English says nothing": "आराम से|ध्यान से|सावधानी से",
        "from a point": "(ड्रम|कोन|बेंच|पेड़|बैरियर|डंपस्टर|बूथ) से (थोड़ा )?(बाएँ|दाएँ) (मुड़|घूम)",
        "a participle joined to a place": "(सटाकर|लगाकर) और ",
        "a hand to put something in": "(बाएँ|दाएँ) हाथ (रख|टिका)",
        "the order of a parked car": "(लाल|नीली|सफ़ेद|पीली) खड़ी",
        "the upper part": "ऊपरी हिस्से",
        "a crossing of streets": "(?<!ज़ेबरा )क्रॉसिंग",
        "what is done to a thing": "रखा जा|रखी जा|(मुड़|घूम)[^।]*(रखना|रखनी) (है|होगा|होगी)",
        "doing so": "ऐसा करके",
        "slanted": "तिरछे|तिरछी(?! तरफ़| दिशा में)",
        "a word for what is done without": "पीछे छोड़ते|के पास तक|उल्टी दिशा|वापस घूम|इतना [^।]*(मुड़|घूम)|गति सीमा",
        "literary": "समीप|मध्य|दरमियान|तलाश|सायबान|दवाख़ान",
        "a translated turn": "ख़ुद को|(बाईं|दाईं) दिशा|लक्ष्य|की बारी|अगला काम|याद से",
        "a corner of a cone": "(दो|दोनों|कई|सेफ़्टी|ट्रैफ़िक)( लाल| नीले| नारंगी)? कोनों",
        "a field in a town": "मैदान",
        "a cone of traffic": "ट्रैफ़िक कोन",
        "holding": "(?<!सड़क )(?<!रोड )(?<!रास्ता )(?<!गली )पकड़",
        "around, of what is beside": "आसपास",
        "leaving or fixing a thing": "(?<!पीछे )(टिका|लगा|जमा|छोड़) (दें|दो|दीजिए)",
        "gone after having been": "(होकर|होते हुए) (निकल|गुज़र)कर",
        "after, twice": "के बाद [^।,]*के बाद",
        "a turn where one only sees": "दिख(ने पर|ते ही) (थोड़ा )?(बाएँ|दाएँ|बाईं|दाईं)",
        "a colour of two": "(?<!नारंगी-)(?<!नारंगी और )सफ़ेद (बैरियर|बैरिकेड|रोड ब्लॉक)",
    },
}
"""Regular expressions of faulty wordings, by the fault."""


@cache
def episodes(code: str) -> tuple[list[str], ...]:
    """Return the four texts of each episode, written in one voice; once, as they take half a minute."""
    random, language = Random(21), load(code)
    voices = (replace(language.draw_voice(random), has_articles=True) for _ in range(EPISODES))
    return tuple(
        [language.write(meaning, random, voice) for meaning in random_meanings.meanings(random, 2)] for voice in voices
    )


@pytest.mark.parametrize("code", FORBIDDEN)
def test_nothing_forbidden_is_written(code: str) -> None:
    texts = [text for four in episodes(code) for text in four]
    for wrong, pattern in FORBIDDEN[code].items():
        found = [text for text in texts if re.search(unicodedata.normalize("NFC", pattern), text)]
        assert found == [], wrong


def test_an_episode_keeps_to_one_register() -> None:
    words = {name: set(unicodedata.normalize("NFC", listed).split()) for name, listed in REGISTERS.items()}
    seen = set()
    for four in episodes("hi"):
        said = {re.sub(r"[,;।]", "", word) for text in four for word in text.split()}
        used = {name for name, of_it in words.items() if said & of_it}
        assert len(used) == 1, four
        seen |= used
    assert seen == set(words)


@pytest.mark.parametrize("code", FORBIDDEN)
def test_an_episode_has_one_noun_for_a_kind(code: str) -> None:
    language, random = load(code), Random(23)
    for kind in random_meanings.KINDS:
        names = {form: lexeme for lexeme in language.grammar.nouns[kind] for form in forms_of([lexeme])}
        for _ in range(12):
            voice = language.draw_voice(random)
            things = [Thing(kind, colour, look) for colour in ("red", "blue") for look in ("dotted", "striped")]
            texts = [language.write(Assembly((), thing, ()), random, voice) for thing in things]
            said = [max((form for form in names if form in text), key=len) for text in texts]
            assert len({names[form] for form in said}) == 1, texts


@pytest.mark.parametrize(
    ("code", "styles"),
    [("en", [r"\b\d+ paces", r"\b[a-z]+ paces"]), ("hi", ["[0-9]+ क़दम", "[०-९]+ क़दम", "(^| )[^0-9०-९ ]+ क़दम"])],
)
def test_an_episode_writes_numbers_in_one_way(code: str, styles: list[str]) -> None:
    language, random, seen = load(code), Random(24), set()
    for _ in range(60):
        voice = language.draw_voice(random)
        said = set()
        for count in (3, 7, 12):
            text = language.write(
                Navigation((Walk("ahead", count=count),), Thing("mug", "red", "striped")), random, voice
            )
            said |= {n for n, style in enumerate(styles) if re.search(unicodedata.normalize("NFC", style), text)}
        assert len(said) == 1
        seen |= said
    assert seen == set(range(len(styles)))


@pytest.mark.parametrize("code", FORBIDDEN)
def test_what_is_only_read_is_never_drawn(code: str) -> None:
    language = load(code)
    never = [p for group in (language.grammar.steps, language.grammar.where) for ps in group.values() for p in ps]
    assert any(pattern.weight == 0 for pattern in never)
    for seed in range(200):
        voice = language.draw_voice(Random(seed))
        weights = [noun.weight for noun in voice.nouns.values()]
        weights += [each.weight for each in (*voice.colours.values(), *voice.whiches.values())]
        assert all(weights + [look.weight for look in voice.looks.values()])


def test_what_is_only_read_is_read() -> None:
    mug = Thing("mug", "red", "striped")
    for text in ("Turn leftwards and snatch the striped red mug.", "Go left and pick the striped red mug up."):
        read = load("en").read(text, "navigation")
        assert isinstance(read, Navigation)
        assert read.target == mug
    text = unicodedata.normalize("NFC", "बैनर को पार करें। धारीदार लाल मग को ध्यान से टीवी के ऊपर रखें।")
    placed = load("hi").read(text, "assembly")
    assert isinstance(placed, Assembly)
    assert placed.thing == mug


BARREL, BARRIER = Thing("barrel", "gold", identity="b"), Thing("barrier", "white", identity="w")
MUG = Thing("mug", "red", "dotted", identity="m")
BRICK, YOU = Thing("wall", look="brick", identity="wall/brick"), Thing("you")


@pytest.mark.parametrize("code", FORBIDDEN)
def test_one_goes_straight_only_to_what_is_straight_ahead(code: str) -> None:
    language = load(code)
    assert language.grammar.straight
    for way in ("to", "towards", "until"):
        for is_straight in (True, False):
            meaning = Navigation((Walk(way, (BARREL,), straight=is_straight),), MUG)
            texts = [language.write(meaning, Random(seed)) for seed in range(60)]
            assert any(re.search(language.grammar.straight, text) for text in texts) == is_straight, way


@pytest.mark.parametrize("way", ["to", "towards"])
def test_only_what_is_far_is_in_the_distance(way: str) -> None:
    language = load("en")
    for is_far in (True, False):
        meaning = Navigation((Walk(way, (BARREL,), far=is_far),), MUG)
        texts = [language.write(meaning, Random(seed)) for seed in range(60)]
        assert any("in the distance" in text for text in texts) == is_far
        assert {language.read(text, "navigation") for text in texts} == {meaning}


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ((Where("on_top_of", (BARREL,)), Where("against", (BRICK,))), "barrel against the"),
        ((Where("on_top_of", (BARREL,)), Where("right_of", (YOU,))), "barrel (on|to) your right"),
        ((Where("against", (BRICK,)), Where("in_front_of", (YOU,))), "wall (right |directly |just )?in front of you"),
        ((Where("in_front_of", (YOU,)), Where("against", (BRICK,))), "you (right )?(up )?against the"),
    ],
)
def test_a_wall_or_the_reader_is_named_in_one_breath(where: tuple[Where, ...], said: str) -> None:
    language = load("en")
    meaning = Assembly((), MUG, where)
    texts = [language.write(meaning, Random(seed)) for seed in range(40)]
    assert any(re.search(said, text) for text in texts)
    assert not any(re.search(" and (against|in front|right|up|on|to)", text) for text in texts)
    assert {language.read(text, "assembly") for text in texts} == {meaning}


@pytest.mark.parametrize(
    ("arms", "named", "not_named"), [(3, "तिराह", "चौराह"), (4, "चौराह", "तिराह"), (0, "चौराह", "तिराह")]
)
def test_a_hindi_intersection_is_named_by_how_many_streets_meet_there(arms: int, named: str, not_named: str) -> None:
    meaning = Navigation((Rotate("left", "at", Thing("intersection", identity="1", arms=arms)),), MUG)
    for seed in range(20):
        text = load("hi").write(meaning, Random(seed))
        assert named in text, text
        assert not_named not in text, text
        read = load("hi").read(text, "navigation")
        assert read == meaning
        assert [thing.arms for thing in mentions(read) if thing.kind == "intersection"] == [arms if arms == 3 else 0]


def test_one_turns_there_at_the_intersection_that_one_has_walked_to() -> None:
    place = Thing("intersection", identity="1")
    meaning = Navigation((Walk("to", (place,)), Rotate("left", "at", place)), MUG)
    for code, word in (("en", "intersection|junction|crossing"), ("hi", "चौराह")):
        for seed in range(40):
            text = load(code).write(meaning, Random(seed))
            assert len(re.findall(word, text)) == 1, text


@pytest.mark.parametrize(("code", "there"), [("en", r"(?<!From )\bthere\b|\bat it\b"), ("hi", "वहाँ|वहीं|उसी के पास")])
def test_one_turns_there_only_where_one_has_come_to(code: str, there: str) -> None:
    pattern = unicodedata.normalize("NFC", there)
    for step, is_at_thing in (
        (Walk("to", (BARREL,)), True),
        (Face(BARREL), False),
        (Walk("towards", (BARREL,)), False),
    ):
        meaning = Navigation((step, Rotate("left", "at", BARREL)), MUG)
        texts = [load(code).write(meaning, Random(seed)) for seed in range(60)]
        bare = [re.sub("वहाँ पहुँचकर|जहाँ[^,]*, वहाँ|वहाँ[^,।]*(गा|गी|है)(?=[,।])", "", text) for text in texts]
        said = [text for text in bare if re.search(pattern, text)]
        assert bool(said) == is_at_thing, said


@pytest.mark.parametrize(
    ("code", "said", "also_read"),
    [
        ("en", "orange and white", ["orange", "white", "orange striped"]),
        ("hi", "नारंगी-सफ़ेद", ["सफ़ेद", "नारंगी", "नारंगी और सफ़ेद"]),
    ],
)
def test_a_barrier_of_two_colours_is_called_so(code: str, said: str, also_read: list[str]) -> None:
    language = load(code)
    meaning = Navigation((Walk("to", (BARRIER,)),), MUG)
    wordings = {
        "en": "Walk to the {} barrier. Pick up the dotted red mug.",
        "hi": "{} बैरियर तक चलें। बिंदीदार लाल मग उठाएँ।",
    }
    assert any(unicodedata.normalize("NFC", said) in language.write(meaning, Random(seed)) for seed in range(20))
    for words in (said, *also_read):
        assert language.read(wordings[code].format(words), "navigation") == meaning, words
