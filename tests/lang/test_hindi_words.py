"""Hindi words: every noun and verb of the grammar in every form."""

import pytest

from arramon_lang import load
from arramon_lang.grammar import INSIDE
from tests.lang.hindi_forms import COLOURS, FORMS, LOOKS, NOUNS, POSTPOSITIONS, WHICHES, nfc, nouns

VERBS = {
    "go": [
        "चले_चलें चले_चलिए चले_चलो चलकर चले_चलने", "पैदल_चलें पैदल_चलिए पैदल_चलो पैदल_चलकर पैदल_चलने",
        "बढ़ते_चलें बढ़ते_चलिए बढ़ते_चलो बढ़कर बढ़ते_चलने",
        "चलते_जाएँ चलते_जाइए चलते_जाओ चलकर चलते_जाने", "चले_जाएँ चले_जाइए चले_जाओ जाकर चले_जाने",
        "बढ़ते_जाएँ बढ़ते_जाइए बढ़ते_जाओ बढ़कर बढ़ते_जाने",
        "चलें चलिए चलो चलकर चलने", "बढ़ें बढ़िए बढ़ो बढ़कर बढ़ने", "जाएँ जाइए जाओ जाकर जाने",
        "चलते_रहें चलते_रहिए चलते_रहो चलकर चलते_रहने", "बढ़ते_रहें बढ़ते_रहिए बढ़ते_रहो बढ़कर बढ़ते_रहने",
    ],
    "extend": ["बढ़ाएँ बढ़ाइए बढ़ाओ बढ़ाकर बढ़ाने"],
    "swing": ["घुमाएँ घुमाइए घुमाओ घुमाकर घुमाने", "मोड़ें मोड़िए मोड़ो मोड़कर मोड़ने"],
    "stop": ["रुकें रुकिए रुको रुककर रुकने", "रुक_जाएँ रुक_जाइए रुक_जाओ रुककर रुक_जाने"],
    "turn": [
        "मुड़_लें मुड़_लीजिए मुड़_लो मुड़कर मुड़_लेने",
        "मुड़ें मुड़िए मुड़ो मुड़कर मुड़ने", "घूमें घूमिए घूमो घूमकर घूमने",
        "मुड़_जाएँ मुड़_जाइए मुड़_जाओ मुड़कर मुड़_जाने",
        "घूम_जाएँ घूम_जाइए घूम_जाओ घूमकर घूम_जाने",
    ],
    "pass": [
        "निकलते_चलें निकलते_चलिए निकलते_चलो निकलकर निकलते_चलने",
        "निकल_जाएँ निकल_जाइए निकल_जाओ निकलकर निकल_जाने", "गुज़र_जाएँ गुज़र_जाइए गुज़र_जाओ गुज़रकर गुज़र_जाने",
        "गुज़रें गुज़रिए गुज़रो गुज़रकर गुज़रने", "निकलें निकलिए निकलो निकलकर निकलने",
    ],
    "get_past": [
        "बढ़_जाएँ बढ़_जाइए बढ़_जाओ बढ़कर बढ़_जाने",
        "निकलें निकलिए निकलो निकलकर निकलने", "बढ़ें बढ़िए बढ़ो बढ़कर बढ़ने",
        "निकल_जाएँ निकल_जाइए निकल_जाओ निकलकर निकल_जाने",
    ],
    "cross": ["पार_करें पार_कीजिए पार_करो पार_करके पार_करने"],
    "do": ["करें कीजिए करो करके करने"],
    "be_there": ["हो_जाएँ हो_जाइए हो_जाओ होकर हो_जाने"],
    "take": ["लें लीजिए लो लेकर लेने"],
    "leave": [
        "छोड़_दें छोड़_दीजिए छोड़_दो छोड़कर छोड़_देने", "छोड़ें छोड़िए छोड़ो छोड़कर छोड़ने",
        "छोड़ते_जाएँ छोड़ते_जाइए छोड़ते_जाओ छोड़कर छोड़ते_जाने",
    ],
    "reach": ["पहुँचें पहुँचिए पहुँचो पहुँचकर पहुँचने", "पहुँच_जाएँ पहुँच_जाइए पहुँच_जाओ पहुँचकर पहुँच_जाने"],
    "grab": [
        "हासिल_करें हासिल_कीजिए हासिल_करो हासिल_करके हासिल_करने", "थाम_लें थाम_लीजिए थाम_लो थामकर थाम_लेने",
        "साथ_ले_लें साथ_ले_लीजिए साथ_ले_लो साथ_लेकर साथ_ले_लेने",
        "हाथ_में_ले_लें हाथ_में_ले_लीजिए हाथ_में_ले_लो हाथ_में_लेकर हाथ_में_लेने",

        "उठाएँ उठाइए उठाओ उठाकर उठाने", "उठा_लें उठा_लीजिए उठा_लो उठाकर उठा_लेने",
        "ले_लें ले_लीजिए ले_लो लेकर ले_लेने", "पकड़_लें पकड़_लीजिए पकड़_लो पकड़कर पकड़_लेने",
    ],
    "look_for": [
        "ढूँढ़ें ढूँढ़िए ढूँढ़ो ढूँढ़कर ढूँढ़ने", "खोजें खोजिए खोजो खोजकर खोजने",
        "तलाश_करें तलाश_कीजिए तलाश_करो तलाश_करके तलाश_करने",
    ],
    "look": ["देखें देखिए देखो देखकर देखने"],
    "place": [
        "सजाएँ सजाइए सजाओ सजाकर सजाने", "सजा_दें सजा_दीजिए सजा_दो सजाकर सजा_देने",
        "पहुँचा_दें पहुँचा_दीजिए पहुँचा_दो पहुँचाकर पहुँचा_देने", "उतार_दें उतार_दीजिए उतार_दो उतारकर उतार_देने",
        "बिठा_दें बिठा_दीजिए बिठा_दो बिठाकर बिठा_देने", "डाल_दें डाल_दीजिए डाल_दो डालकर डाल_देने",
        "ले_आएँ ले_आइए ले_आओ ले_आकर ले_आने",
        "रखें रखिए रखो रखकर रखने", "रख_दें रख_दीजिए रख_दो रखकर रख_देने",
        "छोड़_दें छोड़_दीजिए छोड़_दो छोड़कर छोड़_देने",
        "लगा_दें लगा_दीजिए लगा_दो लगाकर लगा_देने",
        "जमा_दें जमा_दीजिए जमा_दो जमाकर जमा_देने",
        "टिका_दें टिका_दीजिए टिका_दो टिकाकर टिका_देने",
        "टिकाएँ टिकाइए टिकाओ टिकाकर टिकाने",
    ],
}  # fmt: skip
"""Neutral, polite and familiar imperative; conjunctive participle; oblique infinitive."""

VERB_FEATURES = (
    {"form": "finite", "register": "neutral"},
    {"form": "finite", "register": "polite"},
    {"form": "finite", "register": "familiar"},
    {"form": "having", "register": "polite"},
    {"form": "infinitive", "register": "familiar"},
)


def test_expected_forms_cover_every_word_of_the_grammar() -> None:
    grammar = load("hi").grammar
    assert set(grammar.nouns) == set(NOUNS)
    assert set(grammar.colours) == set(COLOURS)
    assert set(grammar.whiches) == set(WHICHES)
    assert {
        (kind.replace("collectible", "mug"), look) for kind, looks in grammar.looks.items() for look in looks
    } == set(LOOKS)
    assert {key.split()[0] for key in grammar.where} - {"between"} == set(POSTPOSITIONS)


@pytest.mark.parametrize("kind", NOUNS)
def test_nouns_have_the_expected_forms(kind: str) -> None:
    for lexeme, gender, expected in nouns(kind):
        assert dict(lexeme.given) == {"gender": {"m": "masculine", "f": "feminine"}[gender]}
        forms = [lexeme.form({"number": n, "case": c, **dict(lexeme.given)}) or "" for n, c in FORMS]
        assert tuple(form.replace(INSIDE, "") for form in forms) == expected


@pytest.mark.parametrize("verb", VERBS)
def test_verbs_have_the_expected_forms(verb: str) -> None:
    written = {
        tuple(str(lexeme.form(features)) for features in VERB_FEATURES) for lexeme in load("hi").grammar.words[verb]
    }
    assert written == {tuple(each.replace("_", " ") for each in nfc(forms).split()) for forms in VERBS[verb]}
