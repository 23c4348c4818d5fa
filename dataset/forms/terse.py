"""Terse notes: the meaning of an instruction in as few words as possible, in English or Hindi."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from random import Random

from arramon_dataset.forms.tables import DEVANAGARI
from arramon_lang.meaning import Assembly, Face, Meaning, Navigation, Rotate, Step, Thing, Walk, Where

_NOUNS = {
    "tv": ("TV", "tv"), "phone_booth": ("phone booth",), "lamp_post": ("lamp post", "street light"),
    "traffic_light": ("traffic light", "lights"), "tyre_stack": ("tires", "tire stack"), "hydrant": ("hydrant",),
    "bin": ("trash can", "bin"), "bags": ("trash bags",), "stop_sign": ("stop sign",), "speed_sign": ("speed sign",),
    "building": ("building", "bldg"), "zebra_crossing": ("zebra crossing", "crosswalk"),
    "intersection": ("intersection",),
    "t_junction": ("T-junction",), "square": ("square",), "building_corner": ("corner of the building",),
    "street_end": ("end of the street",), "shop_sign": ("sign",), "you": ("you",), "": ("it",),
}  # fmt: skip

_WALKS: Mapping[str, tuple[str, ...]] = {
    "ahead": ("straight", "straight on"),
    "past": ("past {0}", "pass {0}"),
    "to": ("to {0}", "go to {0}"),
    "towards": ("towards {0}", "toward {0}"),
    "until": ("until {0}", "till {0}"),
    "along": ("along {0}",),
    "between": ("between {0} and {1}",),
    "beside": ("past {0}",),
}

_RELATIONS = {
    "on_top_of": "on", "left_of": "left of", "right_of": "right of", "in_front_of": "in front of", "behind": "behind",
    "near": "by", "against": "against", "diagonal_to": "diagonal to", "between": "between",
}  # fmt: skip

_HINDI_VERBS = (
    "(मुड़|घूम|चल|जा|बढ़|निकल|गुज़र|पहुँच|रुक|आ)(ें|िए|ो|एँ|इए|ओ|कर)|(मुड़|घूम|निकल|बढ़|गुज़र|चले|चलते|बढ़ते|पैदल) ?"
    "(जाएँ|जाइए|जाओ|लें|लीजिए|लो|रहें|रहिए|रहो|चलें|चलिए|चलो)|उठा(एँ|इए|ओ| लें| लीजिए| लो| लीजिएगा| लेना)|"
    "ले (लें|लीजिए|लो)|रख(ें|िए|ो| दें| दीजिए| दो| दीजिएगा| देना)|पार (करें|कीजिए|करो|करके)"
)


@dataclass(frozen=True, slots=True)
class TerseWriter:
    """Writer of terse English notes.

    Attributes:
        random: source of all choices.
        mark: what separates the notes of a text.
    """

    random: Random
    mark: str

    def write(self, meaning: Meaning) -> str:
        """Return a meaning as notes."""
        if isinstance(meaning, Navigation):
            parts = [*map(self._step, meaning.steps), self._target(meaning.target)]
        else:
            parts = [*meaning.turns, self._placement(meaning)]
        text = self.mark.join(filter(None, parts))
        return text[0].upper() + text[1:] if self.mark == ". " else text

    def thing(self, thing: Thing) -> str:
        """Return the name of a thing, without an article."""
        look, noun = thing.look, self.random.choice(_NOUNS.get(thing.kind, (thing.kind.replace("_", " "),)))
        if thing.kind == "banner" and look:
            return self._joined(thing.which, thing.colour, noun, f"with {look}")
        if thing.kind == "barrier" and thing.colour == "white":
            return self._joined(thing.which, "orange and white barrier")
        plural = "s" if thing.number and not noun.endswith("s") else ""
        number = {"two": "2", "several": ""}.get(thing.number, "")
        named = self._joined(thing.which, number, look, thing.colour, f"{noun}{plural}")
        return f"{named} {self._where(thing.where)}".strip()

    def _joined(self, *words: str) -> str:
        return " ".join(filter(None, words))

    def _where(self, wheres: tuple[Where, ...]) -> str:
        return ", ".join(self._relation(where) for where in wheres)

    def _relation(self, where: Where) -> str:
        return f"{_RELATIONS[where.relation]} {' and '.join(map(self.thing, where.things))}"

    def _step(self, step: Step) -> str:
        if isinstance(step, Rotate):
            turn = {"around": self.random.choice(("turn around", "u-turn"))}.get(step.direction, step.direction)
            if step.thing is None:
                return turn
            return f"{turn} {step.at} {self.thing(step.thing)}"
        if isinstance(step, Face):
            return f"face {self.thing(step.thing)}"
        return self._walk(step)

    def _walk(self, walk: Walk) -> str:
        if walk.count:
            return f"{walk.count} steps"
        said = self.random.choice(_WALKS[walk.way]).format(*map(self.thing, walk.things))
        if walk.side and walk.way in ("past", "beside") and self.random.random() < 0.5:
            return f"{self.thing(walk.things[0])} on {walk.side}"
        return f"{said} on {walk.side}" if walk.side else said

    def _target(self, target: Thing) -> str:
        return self._joined(self.random.choice(("", "", "grab", "pick up", "get")), self.thing(target))

    def _placement(self, meaning: Assembly) -> str:
        placed = self._where(meaning.where)
        named = self.thing(meaning.thing) if meaning.thing.kind and self.random.random() < 0.4 else ""
        return self._joined(self.random.choice(("", "", "put", "place")) if named else "", named, placed)


_TURNED = "\x00"
"""Stands for the verb of a turn that is kept."""

_HINDI_TURNS = (
    "(?:अपनी |अपने )?(बाईं|दाईं|बाएँ|दाएँ|लेफ़्ट|राइट) ?(?:ओर|तरफ़|हाथ|दिशा में|में|साइड|की तरफ़)? ?"
    "(?:(?:मुड़|घूम)(?:ें|िए|ो|कर)|(?:मुड़|घूम) (?:जाएँ|जाइए|जाओ|जाइएगा|जाना|लें|लीजिए|लो))"
)

_SIDES = {"बा": "बाएँ", "दा": "दाएँ", "ले": "लेफ़्ट", "रा": "राइट"}
"""The word of a note for each side, by the first letters of the text's."""


def _room_turn(match: re.Match[str]) -> str:
    return f"{_SIDES[match[1][:2]]} {_TURNED} "


def terse_hindi(text: str, phase: str) -> str:
    """Return a Hindi text without its verbs of moving, picking up and placing, its clauses divided by commas.

    Turns are told by the side alone, but in the room, where a side alone would be a place.
    """
    if phase == "navigation":
        turned = rf"(?<![{DEVANAGARI}]){_HINDI_TURNS}(?![{DEVANAGARI}])"
        text = re.sub(turned, lambda match: f"{_SIDES[match[1][:2]]},", text)
    else:
        text = re.sub(rf"(?<![{DEVANAGARI}]){_HINDI_TURNS}(?![{DEVANAGARI}])[।,]? ?", _room_turn, text)
    bounded = rf"(?<![{DEVANAGARI}])(?:{_HINDI_VERBS})(?![{DEVANAGARI}])"
    text = re.sub(rf"(?<![{DEVANAGARI}])(अब|फिर|उसके बाद|इसके बाद|अंत में|और फिर)(?![{DEVANAGARI}]),?", ",", text)
    text = re.sub(rf"(?<![{DEVANAGARI}])(उसे|उसको|इसे|इसको) (?={_HINDI_VERBS})", "", text)
    text = re.sub(bounded, ",", text).replace(_TURNED, "मुड़कर")
    text = re.sub(rf"[,।]\s*और(?![{DEVANAGARI}])", ",", text.replace("।", ","))
    text = re.sub(r"(\s*,\s*)+", ", ", text).strip(" ,")
    return re.sub(r"\s+", " ", text)
