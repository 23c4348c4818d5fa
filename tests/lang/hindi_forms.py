"""Expected forms of Hindi nouns and adjectives, written by hand, independent of the tested data."""

import unicodedata
from collections.abc import Iterable, Iterator
from functools import cache
from itertools import product
from typing import Any

from arramon_lang import load
from arramon_lang.grammar import INSIDE, Lexeme
from arramon_lang.writing.voice import MANNERS, Voice

MOVABLE = ("car",)
"""Kinds that can drive up: of these nothing says that they come."""

NOUNS = {
    "ball": ["f गेंद|गेंद|गेंदें|गेंदों", "f बॉल|बॉल|बॉलें|बॉलों"],
    "hourglass": [
        "f रेतघड़ी|रेतघड़ी|रेतघड़ियाँ|रेतघड़ियों", "f रेत घड़ी|रेत घड़ी|रेत घड़ियाँ|रेत घड़ियों",
        "f बालू घड़ी|बालू घड़ी|बालू घड़ियाँ|बालू घड़ियों",
    ],
    "mug": ["m मग|मग|मग|मगों", "m कप|कप|कप|कपों", "m प्याला|प्याले|प्याले|प्यालों", "m कॉफ़ी मग|कॉफ़ी मग|कॉफ़ी मग|कॉफ़ी मगों"],
    "tv": ["m टीवी|टीवी|टीवी|टीवी", "m टेलीविज़न|टेलीविज़न|टेलीविज़न|टेलीविज़नों", "m टीवी सेट|टीवी सेट|टीवी सेट|टीवी सेटों"],
    "book": ["f किताब|किताब|किताबें|किताबों", "f पुस्तक|पुस्तक|पुस्तकें|पुस्तकों", "f बुक|बुक|बुकें|बुकों"],
    "bowl": ["m कटोरा|कटोरे|कटोरे|कटोरों", "m बाउल|बाउल|बाउल|बाउलों", "f कटोरी|कटोरी|कटोरियाँ|कटोरियों"],
    "bucket": ["f बाल्टी|बाल्टी|बाल्टियाँ|बाल्टियों", "f बकेट|बकेट|बकेटें|बकेटों"],
    "cone": [
        "m ट्रैफ़िक कोन|ट्रैफ़िक कोन|ट्रैफ़िक कोन|ट्रैफ़िक कोनों", "m कोन|कोन|कोन|कोन",
        "m सेफ़्टी कोन|सेफ़्टी कोन|सेफ़्टी कोन|सेफ़्टी कोनों",
    ],
    "phone_booth": [
        "m फ़ोन बूथ|फ़ोन बूथ|फ़ोन बूथ|फ़ोन बूथों", "m टेलीफ़ोन बूथ|टेलीफ़ोन बूथ|टेलीफ़ोन बूथ|टेलीफ़ोन बूथों",
        "m नीला बूथ|नीले बूथ|नीले बूथ|नीले बूथों", "m नीला फ़ोन बूथ|नीले फ़ोन बूथ|नीले फ़ोन बूथ|नीले फ़ोन बूथों",
    ],
    "bench": [
        "f बेंच|बेंच|बेंचें|बेंचों", "f लकड़ी की बेंच|लकड़ी की बेंच|लकड़ी की बेंचें|लकड़ी की बेंचों",
        "f पार्क बेंच|पार्क बेंच|पार्क बेंचें|पार्क बेंचों",
    ],
    "lamp_post": [
        "m लैंप पोस्ट|लैंप पोस्ट|लैंप पोस्ट|लैंप पोस्टों", "m बत्ती का खंभा|बत्ती के खंभे|बत्ती के खंभे|बत्ती के खंभों",
        "m लाइट का खंभा|लाइट के खंभे|लाइट के खंभे|लाइट के खंभों", "f स्ट्रीट लाइट|स्ट्रीट लाइट|स्ट्रीट लाइटें|स्ट्रीट लाइटों",
        "m बिजली का खंभा|बिजली के खंभे|बिजली के खंभे|बिजली के खंभों",
        "m लाइट पोल|लाइट पोल|लाइट पोल|लाइट पोलों", "m स्ट्रीट लैंप|स्ट्रीट लैंप|स्ट्रीट लैंप|स्ट्रीट लैंपों",
    ],
    "traffic_light": [
        "f ट्रैफ़िक लाइट|ट्रैफ़िक लाइट|ट्रैफ़िक लाइटें|ट्रैफ़िक लाइटों", "m ट्रैफ़िक सिग्नल|ट्रैफ़िक सिग्नल|ट्रैफ़िक सिग्नल|ट्रैफ़िक सिग्नलों",
        "m सिग्नल|सिग्नल|सिग्नल|सिग्नलों", "f यातायात बत्ती|यातायात बत्ती|यातायात बत्तियाँ|यातायात बत्तियों",
    ],
    "dumpster": [
        "m डंपस्टर|डंपस्टर|डंपस्टर|डंपस्टरों", "m कूड़ा कंटेनर|कूड़ा कंटेनर|कूड़ा कंटेनर|कूड़ा कंटेनरों",
        "f कचरा पेटी|कचरा पेटी|कचरा पेटियाँ|कचरा पेटियों", "m कचरा कंटेनर|कचरा कंटेनर|कचरा कंटेनर|कचरा कंटेनरों",
    ],
    "barrier": [
        "m रोड ब्लॉक|रोड ब्लॉक|रोड ब्लॉक|रोड ब्लॉकों", "m बैरियर|बैरियर|बैरियर|बैरियरों",
        "m बैरिकेड|बैरिकेड|बैरिकेड|बैरिकेडों", "m अवरोधक|अवरोधक|अवरोधक|अवरोधकों",
    ],
    "barrel": [
        "m बैरल|बैरल|बैरल|बैरलों", "m ड्रम|ड्रम|ड्रम|ड्रमों", "m पीपा|पीपे|पीपे|पीपों",
        "m तेल का ड्रम|तेल के ड्रम|तेल के ड्रम|तेल के ड्रमों",
    ],
    "tyre_stack": [
        "m टायरों का ढेर|टायरों के ढेर|टायरों के ढेर|टायरों के ढेरों", "f टायरों की ढेरी|टायरों की ढेरी|टायरों की ढेरियाँ|टायरों की ढेरियों",
    ],
    "hydrant": [
        "m फ़ायर हाइड्रेंट|फ़ायर हाइड्रेंट|फ़ायर हाइड्रेंट|फ़ायर हाइड्रेंटों", "m हाइड्रेंट|हाइड्रेंट|हाइड्रेंट|हाइड्रेंटों",
        "m लाल हाइड्रेंट|लाल हाइड्रेंट|लाल हाइड्रेंट|लाल हाइड्रेंटों",
    ],
    "mailbox": [
        "m लेटर बॉक्स|लेटर बॉक्स|लेटर बॉक्स|लेटर बॉक्सों", "f डाक पेटी|डाक पेटी|डाक पेटियाँ|डाक पेटियों",
        "m मेलबॉक्स|मेलबॉक्स|मेलबॉक्स|मेलबॉक्सों", "m नीला लेटर बॉक्स|नीले लेटर बॉक्स|नीले लेटर बॉक्स|नीले लेटर बॉक्सों",
        "m डाक का डिब्बा|डाक के डिब्बे|डाक के डिब्बे|डाक के डिब्बों", "m पोस्ट बॉक्स|पोस्ट बॉक्स|पोस्ट बॉक्स|पोस्ट बॉक्सों",
    ],
    "bin": [
        "m कूड़ेदान|कूड़ेदान|कूड़ेदान|कूड़ेदानों", "m डस्टबिन|डस्टबिन|डस्टबिन|डस्टबिनों",
        "m कचरादान|कचरादान|कचरादान|कचरादानों", "m हरा कूड़ेदान|हरे कूड़ेदान|हरे कूड़ेदान|हरे कूड़ेदानों",
        "m कूड़े का डिब्बा|कूड़े के डिब्बे|कूड़े के डिब्बे|कूड़े के डिब्बों", "m ट्रैश कैन|ट्रैश कैन|ट्रैश कैन|ट्रैश कैनों",
    ],
    "bags": [
        "m कूड़े की थैलियों का ढेर|कूड़े की थैलियों के ढेर|कूड़े की थैलियों के ढेर|कूड़े की थैलियों के ढेरों",
        "m कचरे के थैलों का ढेर|कचरे के थैलों के ढेर|कचरे के थैलों के ढेर|कचरे के थैलों के ढेरों",
        "f कूड़े की थैलियों की ढेरी|कूड़े की थैलियों की ढेरी|कूड़े की थैलियों की ढेरियाँ|कूड़े की थैलियों की ढेरियों",
    ],
    "tree": ["m पेड़|पेड़|पेड़|पेड़ों", "m हरा पेड़|हरे पेड़|हरे पेड़|हरे पेड़ों", "m वृक्ष|वृक्ष|वृक्ष|वृक्षों"],
    "stop_sign": [
        "m स्टॉप साइन|स्टॉप साइन|स्टॉप साइन|स्टॉप साइनों", "m स्टॉप बोर्ड|स्टॉप बोर्ड|स्टॉप बोर्ड|स्टॉप बोर्डों",
        "m लाल स्टॉप साइन|लाल स्टॉप साइन|लाल स्टॉप साइन|लाल स्टॉप साइनों", "m रुकने का संकेत|रुकने के संकेत|रुकने के संकेत|रुकने के संकेतों",
    ],
    "speed_sign": [
        "m स्पीड लिमिट साइन|स्पीड लिमिट साइन|स्पीड लिमिट साइन|स्पीड लिमिट साइनों",
        "m स्पीड लिमिट बोर्ड|स्पीड लिमिट बोर्ड|स्पीड लिमिट बोर्ड|स्पीड लिमिट बोर्डों",
        "m गति सीमा का बोर्ड|गति सीमा के बोर्ड|गति सीमा के बोर्ड|गति सीमा के बोर्डों",
        "m गति सीमा का संकेत|गति सीमा के संकेत|गति सीमा के संकेत|गति सीमा के संकेतों",
        "m रफ़्तार का बोर्ड|रफ़्तार के बोर्ड|रफ़्तार के बोर्ड|रफ़्तार के बोर्डों",
    ],
    "banner": ["m बैनर|बैनर|बैनर|बैनरों", "m झंडा|झंडे|झंडे|झंडों", "m पोस्टर|पोस्टर|पोस्टर|पोस्टरों"],
    "building_corner": ["f इमारत का कोना|इमारत के कोने|इमारतों के कोने|इमारतों के कोनों"],
    "building": ["f इमारत|इमारत|इमारतें|इमारतों", "f बिल्डिंग|बिल्डिंग|बिल्डिंगें|बिल्डिंगों"],
    "car": ["f कार|कार|कारें|कारों", "f गाड़ी|गाड़ी|गाड़ियाँ|गाड़ियों"],
    "kiosk": [
        "m खोखा|खोखे|खोखे|खोखों", "f गुमटी|गुमटी|गुमटियाँ|गुमटियों", "m कियोस्क|कियोस्क|कियोस्क|कियोस्कों", "m स्टॉल|स्टॉल|स्टॉल|स्टॉलों",
    ],
    "planter": ["m गमला|गमले|गमले|गमलों", "m फूलों का गमला|फूलों के गमले|फूलों के गमले|फूलों के गमलों"],
    "awning": [
        "m सायबान|सायबान|सायबान|सायबानों", "m शेड|शेड|शेड|शेडों", "m छज्जा|छज्जे|छज्जे|छज्जों", "f तिरपाल|तिरपाल|तिरपालें|तिरपालों",
    ],
    "shop_sign": ["m साइनबोर्ड|साइनबोर्ड|साइनबोर्ड|साइनबोर्डों", "m बोर्ड|बोर्ड|बोर्ड|बोर्डों", "m साइन|साइन|साइन|साइनों"],
    "zebra_crossing": ["f ज़ेबरा क्रॉसिंग|ज़ेबरा क्रॉसिंग|ज़ेबरा क्रॉसिंगें|ज़ेबरा क्रॉसिंगों"],
    "wall": ["f दीवार|दीवार|दीवारें|दीवारों"],
    "intersection": ["m चौराहा|चौराहे|चौराहे|चौराहों", "m तिराहा|तिराहे|तिराहे|तिराहों", "f क्रॉसिंग|क्रॉसिंग|क्रॉसिंगें|क्रॉसिंगों"],
    "corner": ["m नुक्कड़|नुक्कड़|नुक्कड़|नुक्कड़ों", "m मोड़|मोड़|मोड़|मोड़ों"],
    "street": ["f सड़क|सड़क|सड़कें|सड़कों", "f रोड|रोड|रोडें|रोडों", "m रास्ता|रास्ते|रास्ते|रास्तों"],
    "alley": [
        "f गली|गली|गलियाँ|गलियों", "f तंग गली|तंग गली|तंग गलियाँ|तंग गलियों",
        "f पतली गली|पतली गली|पतली गलियाँ|पतली गलियों",
    ],
    "t_junction": ["m टी-पॉइंट|टी-पॉइंट|टी-पॉइंट|टी-पॉइंटों", "m टी-जंक्शन|टी-जंक्शन|टी-जंक्शन|टी-जंक्शनों"],
    "square": ["f खुली जगह|खुली जगह|खुली जगहें|खुली जगहों", "m प्लाज़ा|प्लाज़ा|प्लाज़ा|प्लाज़ाओं"],
    "street_end": [
        "m सड़क का आख़िर|सड़क के आख़िर|सड़क के आख़िर|सड़क के आख़िर",
        "m सड़क का छोर|सड़क के छोर|सड़क के छोर|सड़क के छोरों", "m सड़क का अंत|सड़क के अंत|सड़क के अंत|सड़क के अंतों",
        "m सड़क का सिरा|सड़क के सिरे|सड़क के सिरे|सड़क के सिरों",
    ],
    "": ["m वाला|वाले|वाले|वाले"],
}  # fmt: skip
"""For each kind the gender and the forms: direct and oblique singular, direct and oblique plural."""


KAA = "{} का|{} के|{} की"
VAALA = "{} वाला|{} वाले|{} वाली"

COLOURS = {
    "green": ["हरा|हरे|हरी"],
    "red": ["लाल"],
    "blue": ["नीला|नीले|नीली"],
    "white": ["सफ़ेद"],
    "yellow": ["पीला|पीले|पीली"],
    "brown": ["भूरा|भूरे|भूरी", "कत्थई"],
    "purple": ["बैंगनी", "जामुनी"],
    "orange": ["नारंगी", KAA.replace("{}", "नारंगी रंग")],
    "silver": ["सिल्वर", "स्लेटी", KAA.replace("{}", "सिल्वर रंग")],
    "gold": ["सुनहरा|सुनहरे|सुनहरी", KAA.replace("{}", "सुनहरे रंग")],
    "concrete": [KAA.replace("{}", "कंक्रीट")],
    "black": ["काला|काले|काली", KAA.replace("{}", "काले रंग")],
}
"""Before a masculine noun's direct singular, before its other forms, before a feminine noun; or one for all."""

WHICHES = {
    "first": ["पहला|पहले|पहली"],
    "second": ["दूसरा|दूसरे|दूसरी"],
    "third": ["तीसरा|तीसरे|तीसरी"],
    "next": ["अगला|अगले|अगली"],
    "last": ["आख़िरी"],
    "nearest": ["सबसे नज़दीकी", "सबसे क़रीबी", VAALA.replace("{}", "सबसे पास")],
}

LOOKS = {
    ("mug", "dotted"): ["बिंदीदार", *(VAALA.replace("{}", each) for each in ("बिंदियों", "डॉट्स"))],
    ("mug", "striped"): [
        "धारीदार",
        *(VAALA.replace("{}", each) for each in ("धारियों", "पट्टियों", "लाइनों")),
    ],
    ("banner", "star"): [VAALA.replace("{}", each) for each in ("तारे", "सितारे", "तारे के निशान")],
    ("banner", "diamond"): [VAALA.replace("{}", each) for each in ("डायमंड", "डायमंड के निशान")],
    ("banner", "triangle"): [VAALA.replace("{}", each) for each in ("त्रिकोण", "त्रिकोण के निशान", "तिकोने निशान")],
    ("banner", "circle"): [VAALA.replace("{}", each) for each in ("गोले के निशान", "गोल निशान")],
    ("banner", "hexagon"): [VAALA.replace("{}", each) for each in ("षट्कोण के निशान", "हेक्सागन के निशान")],
    ("banner", "dot"): [VAALA.replace("{}", each) for each in ("बिंदी", "बिंदी के निशान")],
    ("shop_sign", "hotel"): [KAA.replace("{}", "होटल")],
    ("shop_sign", "cafe"): [KAA.replace("{}", "कैफ़े")],
    ("shop_sign", "bank"): [KAA.replace("{}", "बैंक")],
    ("shop_sign", "bakery"): [KAA.replace("{}", "बेकरी")],
    ("shop_sign", "pharmacy"): [KAA.replace("{}", each) for each in ("मेडिकल स्टोर", "दवा की दुकान")],
    ("shop_sign", "cinema"): [KAA.replace("{}", each) for each in ("सिनेमा", "सिनेमाघर")],
    ("building", "yellow"): ["पीला|पीले|पीली", KAA.replace("{}", "पीले रंग")],
    ("building", "green"): ["हरा|हरे|हरी", KAA.replace("{}", "हरे रंग")],
    ("building", "blue"): ["नीला|नीले|नीली", KAA.replace("{}", "नीले रंग")],
    ("building", "brick"): [VAALA.replace("{}", "ईंटों"), *(KAA.replace("{}", each) for each in ("ईंट", "ईंटों"))],
    ("building", "brown"): ["भूरा|भूरे|भूरी", KAA.replace("{}", "भूरे रंग")],
    ("building", "concrete"): [KAA.replace("{}", "कंक्रीट")],
    ("building", "glass"): [KAA.replace("{}", each) for each in ("काँच", "शीशे")],
    ("building", "white"): ["सफ़ेद", KAA.replace("{}", "सफ़ेद रंग")],
    ("building", "arched"): ["मेहराबदार", VAALA.replace("{}", "मेहराबदार खिड़कियों"), VAALA.replace("{}", "मेहराबों")],
    ("building", "red"): ["लाल", KAA.replace("{}", "लाल रंग")],
    ("building", "grey"): ["स्लेटी", "ग्रे", KAA.replace("{}", "स्लेटी रंग")],
    ("wall", "wood"): [KAA.replace("{}", "लकड़ी")],
    ("wall", "brick"): [KAA.replace("{}", each) for each in ("ईंट", "ईंटों")],
    ("wall", "spotted"): ["धब्बेदार", "बिंदीदार", VAALA.replace("{}", "धब्बों")],
    ("wall", "striped"): ["धारीदार", VAALA.replace("{}", "धारियों")],
}

POSTPOSITIONS = {
    "on_top_of": ["के ऊपर", "पर"],
    "left_of": [
        *("के बाईं ओर", "के बाईं तरफ़", "की बाईं ओर", "की बाईं तरफ़"),
        *("के लेफ़्ट में", "की लेफ़्ट साइड में"),
    ],
    "right_of": [
        *("के दाईं ओर", "के दाईं तरफ़", "की दाईं ओर", "की दाईं तरफ़"),
        *("के राइट में", "की राइट साइड में"),
    ],
    "in_front_of": ["के सामने"],
    "behind": ["के पीछे"],
    "near": ["के पास", "की बगल में", "के नज़दीक", "के क़रीब", "के पास ही"],
    "against": ["से सटाकर", "से लगाकर"],
    "diagonal_to": ["से तिरछी दिशा में"],
}

OWN_COLOURS = {("barrier", "white"): ["नारंगी-सफ़ेद"]}
"""Colour words of specific kinds."""

PARKED = "खड़ी "
"""Optional adjective of a car, before its colour."""


@cache
def voices() -> tuple[Voice, ...]:
    """Return voices that use all written wordings between them."""

    def nth(options: Iterable[Any], number: int) -> Any:
        written = [option for option in options if option.weight]
        return written[number % len(written)]

    grammar = load("hi").grammar
    return tuple(
        Voice(
            {"register": "neutral", "sides": ("native", "loan")[number % 2]},
            {kind: nth(options, number) for kind, options in grammar.nouns.items()},
            {},
            {value: nth(options, number) for value, options in grammar.colours.items()},
            {
                kind: {value: nth(options, number) for value, options in colours.items()}
                for kind, colours in grammar.colours_of.items()
            },
            {value: nth(options, number) for value, options in grammar.whiches.items()},
            {
                (kind, value): nth(options, number)
                for kind, looks in grammar.looks.items()
                for value, options in looks.items()
            },
            MANNERS[0],
            grammar.sentence_end,
            True,
            True,
            {},
        )
        for number in range(VOICES)
    )


VOICES = 8
"""More than the number of wordings of any adjective."""

FORMS = tuple(product(("singular", "plural"), ("direct", "oblique")))
"""Number and case, in the order of the listed forms of a noun."""


def nfc(text: str) -> str:
    return unicodedata.normalize("NFC", text)


def forms(listed: str) -> tuple[str, str, str]:
    """Return an adjective's three forms."""
    each = nfc(listed).split("|")
    return (each[0], each[0], each[0]) if len(each) == 1 else (each[0], each[1], each[2])


def agreeing(listed: list[str], gender: str, number: str, case: str) -> set[str]:
    """Return the adjectives' forms before a noun."""
    place = 2 if gender == "f" else 0 if (number, case) == ("singular", "direct") else 1
    return {forms(each)[place] for each in listed}


def before(word: str, noun: str) -> str:
    """Return a noun with an adjective: inside a noun of several words (टायरों का दूसरा ढेर), otherwise before it."""
    words = noun.split()
    place = max((i + 1 for i, each in enumerate(words) if each in ("का", "के", "की")), default=0)
    place = 0 if words[0].startswith("इमारत") else place  # Its corner is named by the building's adjective.
    return " ".join((*words[:place], word, *words[place:]))


def nouns(kind: str) -> Iterator[tuple[Lexeme, str, tuple[str, ...]]]:
    """Yield each noun of a kind from the language's data, its gender, and its expected forms in the order of FORMS."""
    expected = {}
    for entry in NOUNS[kind]:
        gender, listed = entry.split(" ", 1)
        expected[nfc(listed).split("|")[0]] = (gender, tuple(nfc(listed).split("|")))
    lexemes = {
        (lexeme.form({"number": "singular", "case": "direct"}) or "").replace(INSIDE, ""): lexeme
        for lexeme in load("hi").grammar.nouns[kind]
    }
    assert set(lexemes) == set(expected), kind
    for form, lexeme in lexemes.items():
        yield lexeme, *expected[form]
