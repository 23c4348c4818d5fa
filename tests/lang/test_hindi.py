"""Hindi's paradigms: every noun, adjective, participle and verb that is written, in every form.

The expected forms are written out by hand here, apart from the data that they test.
"""

import unicodedata
from collections.abc import Iterator
from itertools import pairwise, product
from random import Random

import pytest

from lang import load
from lang.grammar import Lexeme
from lang.meaning import Thing, Where
from lang.patterns import Choice, Pattern, Sequence, Slot
from lang.phrasing import Phraser

NOUNS = {
    "ball": ["f गेंद|गेंद|गेंदें|गेंदों", "f बॉल|बॉल|बॉलें|बॉलों"],
    "hourglass": ["f रेतघड़ी|रेतघड़ी|रेतघड़ियाँ|रेतघड़ियों", "f बालू घड़ी|बालू घड़ी|बालू घड़ियाँ|बालू घड़ियों"],
    "mug": ["m मग|मग|मग|मगों", "m कप|कप|कप|कपों", "m प्याला|प्याले|प्याले|प्यालों"],
    "tv": ["m टीवी|टीवी|टीवी|टीवी", "m टेलीविज़न|टेलीविज़न|टेलीविज़न|टेलीविज़नों"],
    "book": ["f किताब|किताब|किताबें|किताबों", "f पुस्तक|पुस्तक|पुस्तकें|पुस्तकों"],
    "bowl": ["m कटोरा|कटोरे|कटोरे|कटोरों", "m बाउल|बाउल|बाउल|बाउलों"],
    "bucket": ["f बाल्टी|बाल्टी|बाल्टियाँ|बाल्टियों"],
    "cone": ["m ट्रैफ़िक कोन|ट्रैफ़िक कोन|ट्रैफ़िक कोन|ट्रैफ़िक कोनों", "m कोन|कोन|कोन|कोनों"],
    "phone_booth": [
        "m फ़ोन बूथ|फ़ोन बूथ|फ़ोन बूथ|फ़ोन बूथों", "m टेलीफ़ोन बूथ|टेलीफ़ोन बूथ|टेलीफ़ोन बूथ|टेलीफ़ोन बूथों",
        "m नीला फ़ोन बूथ|नीले फ़ोन बूथ|नीले फ़ोन बूथ|नीले फ़ोन बूथों",
    ],
    "bench": ["f बेंच|बेंच|बेंचें|बेंचों"],
    "lamp_post": [
        "m लैंप पोस्ट|लैंप पोस्ट|लैंप पोस्ट|लैंप पोस्टों", "m बत्ती का खंभा|बत्ती के खंभे|बत्ती के खंभे|बत्ती के खंभों",
        "f स्ट्रीट लाइट|स्ट्रीट लाइट|स्ट्रीट लाइटें|स्ट्रीट लाइटों", "m बिजली का खंभा|बिजली के खंभे|बिजली के खंभे|बिजली के खंभों",
    ],
    "traffic_light": [
        "f ट्रैफ़िक लाइट|ट्रैफ़िक लाइट|ट्रैफ़िक लाइटें|ट्रैफ़िक लाइटों", "m ट्रैफ़िक सिग्नल|ट्रैफ़िक सिग्नल|ट्रैफ़िक सिग्नल|ट्रैफ़िक सिग्नलों",
        "f यातायात बत्ती|यातायात बत्ती|यातायात बत्तियाँ|यातायात बत्तियों",
    ],
    "dumpster": ["m डंपस्टर|डंपस्टर|डंपस्टर|डंपस्टरों", "f कचरा पेटी|कचरा पेटी|कचरा पेटियाँ|कचरा पेटियों"],
    "barrier": ["m बैरियर|बैरियर|बैरियर|बैरियरों", "m बैरिकेड|बैरिकेड|बैरिकेड|बैरिकेडों", "m अवरोधक|अवरोधक|अवरोधक|अवरोधकों"],
    "barrel": ["m ड्रम|ड्रम|ड्रम|ड्रमों", "m पीपा|पीपे|पीपे|पीपों"],
    "tyre_stack": [
        "m टायरों का ढेर|टायरों के ढेर|टायरों के ढेर|टायरों के ढेरों", "f टायरों की ढेरी|टायरों की ढेरी|टायरों की ढेरियाँ|टायरों की ढेरियों",
    ],
    "hydrant": [
        "m फ़ायर हाइड्रेंट|फ़ायर हाइड्रेंट|फ़ायर हाइड्रेंट|फ़ायर हाइड्रेंटों", "m हाइड्रेंट|हाइड्रेंट|हाइड्रेंट|हाइड्रेंटों",
    ],
    "mailbox": [
        "m लेटर बॉक्स|लेटर बॉक्स|लेटर बॉक्स|लेटर बॉक्सों", "f डाक पेटी|डाक पेटी|डाक पेटियाँ|डाक पेटियों",
        "m डाक का डिब्बा|डाक के डिब्बे|डाक के डिब्बे|डाक के डिब्बों",
    ],
    "bin": [
        "m कूड़ेदान|कूड़ेदान|कूड़ेदान|कूड़ेदानों", "m डस्टबिन|डस्टबिन|डस्टबिन|डस्टबिनों",
        "m कूड़े का डिब्बा|कूड़े के डिब्बे|कूड़े के डिब्बे|कूड़े के डिब्बों",
    ],
    "bags": [
        "m कूड़े की थैलियों का ढेर|कूड़े की थैलियों के ढेर|कूड़े की थैलियों के ढेर|कूड़े की थैलियों के ढेरों",
        "m कचरे के थैलों का ढेर|कचरे के थैलों के ढेर|कचरे के थैलों के ढेर|कचरे के थैलों के ढेरों",
    ],
    "tree": ["m पेड़|पेड़|पेड़|पेड़ों"],
    "stop_sign": [
        "m स्टॉप साइन|स्टॉप साइन|स्टॉप साइन|स्टॉप साइनों", "m रुकने का संकेत|रुकने के संकेत|रुकने के संकेत|रुकने के संकेतों",
    ],
    "speed_sign": [
        "m गति सीमा का बोर्ड|गति सीमा के बोर्ड|गति सीमा के बोर्ड|गति सीमा के बोर्डों",
        "m गति सीमा का संकेत|गति सीमा के संकेत|गति सीमा के संकेत|गति सीमा के संकेतों",
    ],
    "banner": ["m बैनर|बैनर|बैनर|बैनरों", "m झंडा|झंडे|झंडे|झंडों", "m पोस्टर|पोस्टर|पोस्टर|पोस्टरों"],
    "building": ["f इमारत|इमारत|इमारतें|इमारतों", "f बिल्डिंग|बिल्डिंग|बिल्डिंगें|बिल्डिंगों"],
    "wall": ["f दीवार|दीवार|दीवारें|दीवारों"],
    "intersection": ["m चौराहा|चौराहे|चौराहे|चौराहों", "f क्रॉसिंग|क्रॉसिंग|क्रॉसिंगें|क्रॉसिंगों"],
    "corner": ["m नुक्कड़|नुक्कड़|नुक्कड़|नुक्कड़ों", "m मोड़|मोड़|मोड़|मोड़ों"],
    "street": ["f सड़क|सड़क|सड़कें|सड़कों"],
    "alley": ["f गली|गली|गलियाँ|गलियों", "f तंग गली|तंग गली|तंग गलियाँ|तंग गलियों"],
    "street_end": ["m सड़क का छोर|सड़क के छोर|सड़क के छोर|सड़क के छोरों", "m सड़क का अंत|सड़क के अंत|सड़क के अंत|सड़क के अंतों"],
    "": ["m वाला|वाले|वाले|वाले"],
}  # fmt: skip
"""For each kind the gender and the forms: direct and oblique singular, direct and oblique plural."""

KAA = "{} का|{} के|{} की"
VAALA = "{} वाला|{} वाले|{} वाली"

COLOURS = {
    "green": ["हरा|हरे|हरी", KAA.replace("{}", "हरे रंग")],
    "red": ["लाल", KAA.replace("{}", "लाल रंग")],
    "blue": ["नीला|नीले|नीली", KAA.replace("{}", "नीले रंग")],
    "white": ["सफ़ेद", KAA.replace("{}", "सफ़ेद रंग")],
    "yellow": ["पीला|पीले|पीली", KAA.replace("{}", "पीले रंग")],
    "brown": ["भूरा|भूरे|भूरी", KAA.replace("{}", "भूरे रंग")],
    "purple": ["बैंगनी", KAA.replace("{}", "बैंगनी रंग"), "जामुनी"],
    "orange": ["नारंगी", KAA.replace("{}", "नारंगी रंग")],
    "silver": ["रुपहला|रुपहले|रुपहली", KAA.replace("{}", "चाँदी के रंग")],
    "gold": ["सुनहरा|सुनहरे|सुनहरी", KAA.replace("{}", "सुनहरे रंग")],
    "concrete": [KAA.replace("{}", "कंक्रीट")],
    "black": ["काला|काले|काली", KAA.replace("{}", "काले रंग")],
}
"""Before a masculine noun's direct singular, before its other forms, before a feminine noun; or one for all."""

WHICHES = {
    "first": ["पहला|पहले|पहली"],
    "second": ["दूसरा|दूसरे|दूसरी"],
    "last": ["आख़िरी", "अंतिम"],
    "nearest": ["सबसे नज़दीकी", "सबसे क़रीबी", VAALA.replace("{}", "सबसे नज़दीक")],
}

LOOKS = {
    ("mug", "dotted"): ["बिंदीदार", VAALA.replace("{}", "बिंदियों"), "चित्तीदार"],
    ("mug", "striped"): ["धारीदार", VAALA.replace("{}", "धारियों")],
    ("banner", "star"): [VAALA.replace("{}", each) for each in ("तारे", "सितारे", "तारे के निशान")],
    ("banner", "diamond"): [VAALA.replace("{}", each) for each in ("हीरे के निशान", "हीरे के आकार")],
    ("banner", "triangle"): [VAALA.replace("{}", each) for each in ("तिकोन", "त्रिकोण", "तिकोने निशान")],
    ("banner", "circle"): [VAALA.replace("{}", each) for each in ("गोले", "गोल निशान")],
    ("banner", "hexagon"): [VAALA.replace("{}", each) for each in ("षट्कोण", "छह कोनों")],
    ("banner", "dot"): [VAALA.replace("{}", each) for each in ("बिंदु", "एक बिंदु")],
    ("building", "brick"): [KAA.replace("{}", each) for each in ("ईंट", "ईंटों")],
    ("building", "brown"): ["भूरा|भूरे|भूरी", KAA.replace("{}", "भूरे रंग")],
    ("building", "concrete"): [KAA.replace("{}", "कंक्रीट")],
    ("building", "glass"): [KAA.replace("{}", each) for each in ("काँच", "शीशे")],
    ("building", "white"): ["सफ़ेद", KAA.replace("{}", "सफ़ेद रंग")],
    ("building", "arched"): ["मेहराबदार", VAALA.replace("{}", "मेहराबदार खिड़कियों"), VAALA.replace("{}", "मेहराबों")],
    ("building", "red"): ["लाल", KAA.replace("{}", "लाल रंग")],
    ("building", "grey"): ["स्लेटी", KAA.replace("{}", "स्लेटी रंग")],
    ("wall", "wood"): [KAA.replace("{}", "लकड़ी")],
    ("wall", "brick"): [KAA.replace("{}", each) for each in ("ईंट", "ईंटों")],
    ("wall", "spotted"): ["धब्बेदार", VAALA.replace("{}", "धब्बों"), "चित्तीदार"],
    ("wall", "striped"): ["धारीदार", VAALA.replace("{}", "धारियों")],
}

POSTPOSITIONS = {
    "on_top_of": ["के ऊपर", "पर"],
    "left_of": ["के बाईं ओर", "के बाईं तरफ़", "के बाएँ", "की बाईं ओर"],
    "right_of": ["के दाईं ओर", "के दाईं तरफ़", "के दाएँ", "की दाईं ओर"],
    "in_front_of": ["के सामने", "के आगे", "के सामने की ओर"],
    "behind": ["के पीछे", "के पीछे की ओर", "के पीछे की तरफ़"],
    "near": ["के पास", "के बगल में", "के नज़दीक", "के क़रीब", "के निकट"],
    "against": ["से सटाकर", "से लगाकर", "के सहारे"],
    "diagonal_to": ["के तिरछे", "से तिरछे", "से तिरछी दिशा में"],
}

PARTICIPLES = ["रखा|रखे|रखी", "पड़ा|पड़े|पड़ी", "रखा हुआ|रखे हुए|रखी हुई", "पड़ा हुआ|पड़े हुए|पड़ी हुई"]

VERBS = {
    "go": [
        "चलें चलिए चलो चलकर चलने", "बढ़ें बढ़िए बढ़ो बढ़कर बढ़ने", "जाएँ जाइए जाओ जाकर जाने",
        "चलते_रहें चलते_रहिए चलते_रहो चलकर चलते_रहने", "बढ़ते_रहें बढ़ते_रहिए बढ़ते_रहो बढ़कर बढ़ते_रहने",
    ],
    "turn": [
        "मुड़ें मुड़िए मुड़ो मुड़कर मुड़ने", "घूमें घूमिए घूमो घूमकर घूमने", "मुड़_जाएँ मुड़_जाइए मुड़_जाओ मुड़कर मुड़_जाने",
        "घूम_जाएँ घूम_जाइए घूम_जाओ घूमकर घूम_जाने",
    ],
    "pass": ["गुज़रें गुज़रिए गुज़रो गुज़रकर गुज़रने", "निकलें निकलिए निकलो निकलकर निकलने"],
    "get_past": [
        "निकलें निकलिए निकलो निकलकर निकलने", "बढ़ें बढ़िए बढ़ो बढ़कर बढ़ने", "निकल_जाएँ निकल_जाइए निकल_जाओ निकलकर निकल_जाने",
    ],
    "cross": ["पार_करें पार_कीजिए पार_करो पार_करके पार_करने"],
    "do": ["करें कीजिए करो करके करने"],
    "be_there": ["हो_जाएँ हो_जाइए हो_जाओ होकर हो_जाने"],
    "take": ["लें लीजिए लो लेकर लेने"],
    "leave": ["छोड़ें छोड़िए छोड़ो छोड़कर छोड़ने", "छोड़ते_जाएँ छोड़ते_जाइए छोड़ते_जाओ छोड़कर छोड़ते_जाने"],
    "reach": ["पहुँचें पहुँचिए पहुँचो पहुँचकर पहुँचने", "पहुँच_जाएँ पहुँच_जाइए पहुँच_जाओ पहुँचकर पहुँच_जाने"],
    "grab": ["उठाएँ उठाइए उठाओ उठाकर उठाने", "उठा_लें उठा_लीजिए उठा_लो उठाकर उठा_लेने", "ले_लें ले_लीजिए ले_लो लेकर ले_लेने"],
    "look_for": [
        "ढूँढ़ें ढूँढ़िए ढूँढ़ो ढूँढ़कर ढूँढ़ने", "खोजें खोजिए खोजो खोजकर खोजने",
        "तलाश_करें तलाश_कीजिए तलाश_करो तलाश_करके तलाश_करने",
    ],
    "look": ["देखें देखिए देखो देखकर देखने"],
    "place": [
        "रखें रखिए रखो रखकर रखने", "रख_दें रख_दीजिए रख_दो रखकर रख_देने", "टिका_दें टिका_दीजिए टिका_दो टिकाकर टिका_देने",
    ],
}  # fmt: skip
"""Neutral, polite and familiar imperative; having done so; the oblique infinitive."""

VERB_FEATURES = (
    {"form": "finite", "register": "neutral"},
    {"form": "finite", "register": "polite"},
    {"form": "finite", "register": "familiar"},
    {"form": "having", "register": "polite"},
    {"form": "infinitive", "register": "familiar"},
)

FORMS = tuple(product(("singular", "plural"), ("direct", "oblique")))

DRAWS = 8
"""Enough to see every wording: what a text has used already is not drawn again before the others."""


@pytest.fixture(scope="module")
def hindi() -> Phraser:
    return Phraser(load("hi").grammar, Random(0))


def nfc(text: str) -> str:
    return unicodedata.normalize("NFC", text)


def forms(listed: str) -> tuple[str, str, str]:
    """An adjective's three forms."""
    each = nfc(listed).split("|")
    return (each[0], each[0], each[0]) if len(each) == 1 else (each[0], each[1], each[2])


def agreeing(listed: list[str], gender: str, number: str, case: str) -> set[str]:
    """The adjectives' forms before a noun."""
    place = 2 if gender == "f" else 0 if (number, case) == ("singular", "direct") else 1
    return {forms(each)[place] for each in listed}


def nouns(kind: str) -> Iterator[tuple[Lexeme, str, tuple[str, ...]]]:
    """Each noun of a kind as the language has it, its expected gender, and its expected forms in the order of FORMS."""
    expected = {}
    for entry in NOUNS[kind]:
        gender, listed = entry.split(" ", 1)
        expected[nfc(listed).split("|")[0]] = (gender, tuple(nfc(listed).split("|")))
    lexemes = {
        lexeme.form({"number": "singular", "case": "direct"}): lexeme for lexeme in load("hi").grammar.nouns[kind]
    }
    assert set(lexemes) == set(expected), kind
    for form, lexeme in lexemes.items():
        assert form is not None
        yield lexeme, *expected[form]


def test_the_tables_are_of_the_words_that_there_are() -> None:
    grammar = load("hi").grammar
    assert set(grammar.nouns) == set(NOUNS)
    assert set(grammar.colours) == set(COLOURS)
    assert set(grammar.whiches) == set(WHICHES)
    assert {
        (kind.replace("collectible", "mug"), look) for kind, looks in grammar.looks.items() for look in looks
    } == set(LOOKS)
    assert {key.split()[0] for key in grammar.where} - {"between"} == set(POSTPOSITIONS)


@pytest.mark.parametrize("kind", NOUNS)
def test_nouns(kind: str) -> None:
    for lexeme, gender, expected in nouns(kind):
        assert dict(lexeme.given) == {"gender": {"m": "masculine", "f": "feminine"}[gender]}
        assert tuple(lexeme.form({"number": n, "case": c, **dict(lexeme.given)}) for n, c in FORMS) == expected


def things(kind: str) -> Iterator[tuple[Thing, list[str]]]:
    """The kind with each adjective that it can have, and the adjective's expected wordings."""
    for colour, wordings in COLOURS.items():
        yield Thing(kind, colour=colour), wordings
    for which, wordings in WHICHES.items():
        yield Thing(kind, which=which), wordings
    for (of, look), wordings in LOOKS.items():
        if of == kind or (of == "mug" and kind in ("ball", "hourglass", "tv", "book", "bowl", "bucket")):
            yield Thing(kind, look=look), wordings


@pytest.mark.parametrize("kind", NOUNS)
def test_every_noun_with_every_adjective_in_every_form(kind: str) -> None:
    for lexeme, gender, expected in nouns(kind):
        for (number, case), form in zip(FORMS, expected, strict=True):
            for thing, wordings in things(kind):
                phraser = Phraser(load("hi").grammar, Random(0))
                fill = phraser.thing(thing, lexeme, (), top=False)
                written = {" ".join(fill({"number": number, "case": case}).split()) for _ in range(DRAWS)}
                assert written == {f"{word} {form}" for word in agreeing(wordings, gender, number, case)}


@pytest.mark.parametrize("relation", POSTPOSITIONS)
def test_every_noun_with_every_adjective_before_every_postposition(relation: str) -> None:
    seen = set()
    for kind in NOUNS:
        for lexeme, gender, expected in nouns(kind):
            for thing, wordings in things(kind):
                phraser = Phraser(load("hi").grammar, Random(0))
                heads = {f"{word} {expected[1]}" for word in agreeing(wordings, gender, "singular", "oblique")}
                fillers = {"thing": phraser.thing(thing, lexeme, (), top=False)}
                for pattern in dict.fromkeys(phraser.grammar.where[relation]):
                    text = " ".join(phraser.render(pattern, fillers, phraser.features).split())
                    (head,) = (head for head in heads if text.startswith(f"{head} "))
                    seen.add(text.removeprefix(f"{head} "))
    assert seen == {nfc(each) for each in POSTPOSITIONS[relation]}


@pytest.mark.parametrize("kind", NOUNS)
def test_two_of_a_kind_are_plural(kind: str) -> None:
    plurals = {forms[3] for _, _, forms in nouns(kind)}
    for seed in range(DRAWS):
        wheres = (Where("between", (Thing(kind), Thing(kind))),)
        text = " ".join(Phraser(load("hi").grammar, Random(seed)).wheres(wheres, top=True).split())
        assert text.startswith(("दो ", "दोनों "))
        assert any(f" {plural} के बीच" in text for plural in plurals), text


@pytest.mark.parametrize("kind", NOUNS)
def test_participles_agree_with_what_lies_there(kind: str) -> None:
    where = (Where("near", (Thing("tree"),)),)
    for lexeme, gender, expected in nouns(kind):
        for (number, case), form in zip(FORMS, expected, strict=True):
            for attached, wordings in (("attached", PARTICIPLES), ("nested", ["वाला|वाले|वाली"])):
                allowed = {f"{word} {form}" for word in agreeing(wordings, gender, number, case)}
                for seed in range(4):
                    phraser = Phraser(load("hi").grammar, Random(seed))
                    patterns: tuple[Pattern, ...] = getattr(phraser.grammar, attached)
                    fill = phraser.thing(Thing(kind, where=where), lexeme, patterns, top=True)
                    text = " ".join(fill({"number": number, "case": case}).split())
                    assert any(text.endswith(f" {each}") for each in allowed), text


@pytest.mark.parametrize("verb", VERBS)
def test_verbs(verb: str) -> None:
    written = {
        tuple(str(lexeme.form(features)) for features in VERB_FEATURES) for lexeme in load("hi").grammar.words[verb]
    }
    assert written == {tuple(each.replace("_", " ") for each in nfc(forms).split()) for forms in VERBS[verb]}


def readings(body: Sequence) -> list[list[str | Slot]]:
    """All sequences of words and slots that a pattern can be."""
    found: list[list[str | Slot]] = [[]]
    for part in body:
        options = [each for option in part.options for each in readings(option)] if isinstance(part, Choice) else []
        more = options or [[part] if isinstance(part, Slot) else list(str(part).split())]
        found = [[*before, *after] for before in found for after in more]
    return found


def test_what_stands_before_a_postposition_is_oblique() -> None:
    """Of all patterns: a thing before a postposition has the mark for it, and no other one has."""
    grammar = load("hi").grammar
    postpositions = {"के", "की", "को", "से", "पर", "तक", "में", "और"}
    checked = 0
    for group in (grammar.steps, grammar.where, grammar.target, grammar.assembly, grammar.also_read):
        for pattern in (pattern for patterns in group.values() for pattern in patterns):
            for parts in readings(pattern.body):
                for slot, after in pairwise([*parts, ""]):
                    if isinstance(slot, Slot) and slot.name in ("thing", "other", "pair", "target"):
                        assert ("oblique" in slot.marks) == (after in postpositions), pattern.text
                        checked += 1
    assert checked > 1000


def test_a_participle_has_the_case_of_its_noun() -> None:
    """बेंच के पास रखे मग को, not रखा: of all patterns, a word that agrees has the marks of the thing that follows it."""
    grammar = load("hi").grammar
    checked = 0
    for group in (grammar.steps, grammar.where, grammar.target, grammar.assembly, grammar.also_read):
        for pattern in (pattern for patterns in group.values() for pattern in patterns):
            for parts in readings(pattern.body):
                for word, noun in pairwise(parts):
                    if (
                        isinstance(word, Slot)
                        and isinstance(noun, Slot)
                        and word.name in ("lying", "been", "vala", "of")
                    ):
                        assert word.marks == noun.marks, pattern.text
                        checked += 1
    assert checked
