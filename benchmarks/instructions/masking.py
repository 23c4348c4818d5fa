"""Texts without the words that name things: what is left shows how a text is built, not which world it is about.

Each collectible, pattern, colour, piece of furniture, building and place becomes a placeholder, with the spellings of
the release. The lists are written out here, apart from `lang`, so that a change of the generator's words changes
nothing here. Punctuation marks are words, and so are the beginning and the end of a text.
"""

import re
import unicodedata
from collections.abc import Mapping

_ENGLISH: Mapping[str, str] = {
    "PATTERN": r"[sd]tri?pp?e[dy]|stripes?|spott(?:ed|y)|dott(?:ed|er|y)|dots?|spots?|polka|speckled",
    "COLOUR": r"red|green|blue|white|yellow|brown|purple|violet|orange|black|gr[ae]y|silver|gold(?:en)?"
    r"|pink|tan|beige"
    r"|dark|wood(?:en)?|metal(?:lic)?|bricks?|stone|glass|concrete|timber|colou?red",
    "OBJECT": r"hour ?glass(?:es)?|egg timer|sand timer|sandglass|balls?|spheres?|mugs?|(?:coffee )?cups?"
    r"|tvs?|tv sets?|televisions?|telly|books?|bowls?|buckets?|pails?|objects?",
    "THING": r"(?:tele)?phone ?(?:booth|box|kiosk)e?s?|booths?|payphones?|call box|lamps?"
    r"|(?:lamp|light) ?(?:post|pole)s?|street ?(?:light|lamp)s?|lanterns?|(?:traffic|stop"
    r"|signal) ?lights?|traffic signals?|signals?|pylons?"
    r"|(?:traffic|safety|road|street|warning) cones?|cones?|(?:park|street|city) bench(?:es)?|bench(?:es)?|seats?"
    r"|dumpsters?|(?:trash|garbage|rubbish|waste|litter|recycl(?:e|ing)) ?(?:cans?|bins?|bags?|containers?|piles?)"
    r"|trash|garbage|bags?|bins?|dustbins?|(?:oil|metal) (?:barrels?|drums?)|barrels?|drums?|barricades?|fences?"
    r"|(?:road|traffic|safety|crash) barriers?|barriers?|road ?blocks?|(?:hanging|wall) (?:banners?|flags?)|banners?"
    r"|flags?|posters?|(?:stop|speed(?: limit)?|shop|store|street) signs?|signs?|sign ?boards?|boards?"
    r"|(?:fire )?hydrants?|(?:mail|post|letter|flower|plant) ?box(?:es)?"
    r"|(?:stack|pile|heap)s? of (?:old |car )?ty?i?res?|(?:stack|pile|heap|cluster"
    r"|mound)s? of (?:trash|garbage|black) ?bags|ty?i?res?|tyres?|trees?"
    r"|(?:flower )?planters?|pots?|(?:parked )?(?:cars?|vehicles?)|(?:street )?kiosks?|stalls?|newsstands?"
    r"|(?:shop |store )?awnings?|canop(?:y|ies)|(?:zebra|pedestrian) crossings?|crosswalks?|posts?|poles?"
    r"|stars?|diamonds?|triangles?|hexagons?|circles?",
    "BUILDING": r"buil?dings?|houses?|structures?|stores?|shops?|hotels?|bank|bakery|pharmacy|caf[eé]|cinema",
    "PLACE": r"(?:street |road )?(?:intersections?|junctions?|crossings?)|t-(?:intersections?|junctions?)|crossroads?"
    r"|(?:street )?corners?|(?:side )?streets?|roads?|(?:narrow |back )?alley(?:way)?s?|lanes?"
    r"|paths?|pathways?|passage"
    r"|(?:open |town )?squares?|plaza",
}
"""Placeholders of English words: a regular expression of each, tried in this order."""

_HINDI: Mapping[str, str] = {
    "PATTERN": "धारी|पट्टी|लाइनदार|बिंदी|बिंदु|चित्ती|धब्ब|डॉट|स्ट्राइप",
    "COLOUR": "लाल|हर[ाेी]|नील[ाेी]|सफ़ेद|सफेद|पील[ाेी]|भूर[ाेी]|बैंगनी|जामुनी|नारंगी|ऑरेंज|काल[ाेी]|सिल्वर|स्लेटी|सुनहर|रुपहल"
    "|लकड़ी|ईंट|काँच|कांच|कंक्रीट|रेड|ग्रीन|ब्लू|येलो|व्हाइट|ब्राउन|पर्पल|गोल्डन|रंग",
    "OBJECT": "गेंद|बॉल|रेतघड़ी|रेत|घड़ी|मग|कप|प्याल|टीवी|टेलीविज़न|किताब|पुस्तक|बुक|कटोर|बाउल|बाल्टी",
    "THING": "कोन|बूथ|फ़ोन|फोन|टेलीफ़ोन|बेंच|लैंप|लैम्प|पोस्ट|खंभ|खम्भ|लाइट|बत्ती|सिग्नल|ट्रैफ़िक|ट्रैफिक|डंपस्टर|कूड़|कचर|डिब्ब|पेटी|बैरियर"
    "|बैरिकेड|अवरोध|रोड ?ब्लॉक|ड्रम|बैरल|पीप|टायर|ढेर|हाइड्रेंट|फ़ायर|फायर|लेटर|बॉक्स|मेलबॉक्स|डाक|थैल|बैग|पेड़|साइन|बोर्ड|स्टॉप|स्पीड|लिमिट"
    "|बैनर|झंड|पोस्टर|कार|गाड़ी|कियोस्क|स्टॉल|गुमटी|खोख|गमल|फूल|सायबान|शेड|छज्ज|तिरपाल|ज़ेबरा|ज़ेब्रा|क्रॉसिंग",
    "BUILDING": "इमारत|बिल्डिंग|भवन|मकान|घर|दुकान|होटल|बैंक|बेकरी|कैफ़े|सिनेमा|मेडिकल|दीवार|दवा",
    "PLACE": "चौराह|तिराह|चौक|मोड़|नुक्कड़|कोन[ाेों]|सड़क|गली|रास्त|मैदान|टी-",
}
"""The same in Hindi: beginnings of words."""

_WORD = re.compile(r"\w+(?:['’-]\w+)*|[.,;:!?]")
_MARKS = ".,;:!?।"


def masked_words(text: str, language: str, *, is_coarse: bool = False) -> str:
    """Return a text's words in small letters with placeholders, with spaces between them.

    Args:
        text: an instruction.
        language: "en" or "hi".
        is_coarse: whether all placeholders are the same, and punctuation marks are left out.
    """
    text = unicodedata.normalize("NFC", " ".join(text.casefold().split()))
    if language == "en":
        for name, pattern in _ENGLISH.items():
            text = re.sub(rf"\b(?:{pattern})\b", name, text)
        words = _WORD.findall(text)
    else:
        words = re.sub(rf"([{_MARKS}])", r" \1 ", text).split()
        words = [_hindi_placeholder(word) or word for word in words]
    if is_coarse:
        words = ["THING" if word.isupper() else word for word in words if word not in _MARKS]
    runs = [word for place, word in enumerate(words) if not (place and word.isupper() and words[place - 1] == word)]
    return " ".join(("<", *runs, ">"))


def _hindi_placeholder(word: str) -> str | None:
    for name, pattern in _HINDI.items():
        if re.match(unicodedata.normalize("NFC", pattern), word):
            return name
    return None
