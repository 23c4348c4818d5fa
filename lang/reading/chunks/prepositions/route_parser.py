"""Parser of free navigation texts with prepositions: phrases to steps and the target."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from arramon_lang.grammar import Grammar
from arramon_lang.meaning import Face, Navigation, Thing, Walk, Where
from arramon_lang.reading.chunks.chunker import SIDE, SIDES, STOP, THEN, VERB
from arramon_lang.reading.chunks.prepositions.phrase_splitter import BUILDING_FEATURES, PhraseSplitter
from arramon_lang.reading.chunks.prepositions.phrases import (
    OTHER,
    TARGET,
    THINGS,
    PhraseSequence,
)
from arramon_lang.reading.chunks.prepositions.step_builder import StepBuilder
from arramon_lang.reading.chunks.prepositions.target import relations, relations_after
from arramon_lang.reading.chunks.sequence import ChunkSequence
from arramon_lang.reading.discourse import POINT_KINDS, Discourse


@dataclass(slots=True, kw_only=True)
class PrepositionRouteParser:
    """Parser of one navigation text with prepositions: decides what each phrase means, and has its steps added.

    Attributes:
        text: chunks of the text.
        grammar: grammar of the language.
    """

    text: ChunkSequence
    grammar: Grammar
    _route: StepBuilder = field(init=False)
    _where: list[Where] = field(default_factory=list)
    _is_there: bool = False
    """Whether "there" refers to the last thing passed or reached."""

    def __post_init__(self) -> None:
        self._route = StepBuilder(self.text.rules)

    def read(self) -> Navigation | None:
        """Return the meaning, or None if the text names no target."""
        chosen = self.text.target()
        if chosen is None:
            return None
        listed = PhraseSplitter(text=self.text, discourse=Discourse(self.grammar), target=chosen).read()
        target_at = next(n for n, phrase in enumerate(listed) if phrase.kind == TARGET)
        phrases = PhraseSequence(listed, target_at, self.text.rules)
        number = 0
        while number < phrases.target:
            number = self._handle_phrase(phrases, number)
        target = self.text.described(listed[phrases.target].last, chosen)
        where = dict.fromkeys((*self._where, *relations_after(phrases)))
        return Navigation(tuple(self._route.steps), replace(target, where=tuple(where)))

    def _handle_phrase(self, phrases: PhraseSequence, number: int) -> int:
        """Handle a phrase before the target; return the index of the next phrase."""
        phrase = phrases.listed[number]
        if phrase.kind == THINGS:
            self._is_there = False
            return self._handle_things(phrases, number)
        if phrase.kind == SIDE:
            return self._handle_side(phrases, number)
        if phrase.kind in ("back", "round"):
            return self._turn_around(phrases, number)
        if phrase.kind in ("not", OTHER):
            return _after_clause(phrases, number)
        if phrase.kind in ("straight", "ahead"):
            self._route.ahead()
        elif phrase.kind == VERB and phrase.value == "cross" and phrases.ends_clause(number):
            self._route.steps.append(Walk("past", (Thing("street"),)))
        self._is_there = phrase.kind == "there" or (self._is_there and phrase.kind != STOP)
        return number + 1

    # Things.

    def _handle_things(self, phrases: PhraseSequence, number: int) -> int:
        phrase = phrases.listed[number]
        turn = self._turn_at(phrases, number)
        if turn is not None:
            self._route.pass_all(phrase.named[:-1])
            self._route.rotate(
                _direction(phrases, turn), phrases.rules.turn_positions.get(phrase.value, "at"), phrase.last
            )
            return turn + 1
        if phrase.value == "away" or self._describes(phrases, number):
            return number + 1
        if phrases.rules.is_in(phrase.value, "placing") and phrases.has_only_places_before_target(number):
            self._where += relations(phrase, phrases.rules)
        elif _is_street_beside(phrases, number):
            self._route.rotate(phrase.named[-1].side, "at", phrase.last)
        elif _is_faced(phrases, number):
            self._route.steps.append(Face(phrase.named[0].thing))
        else:
            if phrase.value in ("left_of", "right_of") and phrases.is_after_verb(number, "turn"):
                self._route.rotate(phrase.value.removesuffix("_of"))
            self._route.walk(phrase)
        return number + 1

    def _turn_at(self, phrases: PhraseSequence, number: int) -> int | None:
        """Return the index of the turn that is made at a phrase's things, or None."""
        phrase = phrases.listed[number]
        is_rounded = phrase.value == "around" or (not phrase.value and phrases.is_after_verb(number, "turn"))
        behind = phrases.turn_right_after(number) if is_rounded else None
        if behind is not None:
            return behind
        turn = phrases.turn_after(number)
        if turn is None or phrase.value not in phrases.rules.turn_positions or phrase.named[-1].side:
            return None
        has_own_place = phrases.listed[turn].joined and phrases.place_of_turn(turn) is not None
        return None if has_own_place else turn  # "At the end, right around the kiosk."

    def _describes(self, phrases: PhraseSequence, number: int) -> bool:
        """Return whether things only identify the thing before them: "the white house with the banner"."""
        phrase, before = phrases.listed[number], phrases.before(number)
        if before is None or not phrases.follows_thing(number) or not phrases.rules.is_in(phrase.value, "describing"):
            return False
        if phrase.value == "with":
            is_feature = before.last.kind == "building" and phrase.named[0].thing.kind in BUILDING_FEATURES
            if is_feature and phrase.named[0].side:
                self._route.set_side(phrase.named[0].side)
            if is_feature:
                self._route.pass_all(phrase.named[1:])
            return is_feature
        if phrase.last.kind == "street_end":
            return False
        return before.value in ("to", "towards", "until") or phrase.value == "of" or before.last.kind not in POINT_KINDS

    # Turns.

    def _handle_side(self, phrases: PhraseSequence, number: int) -> int:
        if phrases.listed[number].value not in SIDES:
            self._route.rotate_around()
            return number + 1
        if not phrases.is_turn(number):
            return number + 1
        if number + 1 < phrases.target and phrases.is_next(number, "round", "back"):
            self._route.rotate_around()  # "Right about."
            return number + 2
        direction, place = _direction(phrases, number), phrases.place_of_turn(number)
        is_there_next = phrases.is_next(number, "there")
        if place is not None:
            phrase = phrases.listed[place]
            self._route.rotate(direction, phrases.rules.turn_positions[phrase.value], phrase.named[0].thing)
            if phrases.enters_alley(number + 1):
                self._route.walk(phrases.listed[number + 1])
            self._route.pass_all(phrase.named[1:])
            number = place
        elif self._is_there or is_there_next:
            self._route.rotate_there(direction)
            number += is_there_next
        else:
            self._route.rotate(direction)
        self._is_there = False
        return number + 1

    def _turn_around(self, phrases: PhraseSequence, number: int) -> int:
        """Read "back" or "round" as a turn around, unless another direction is stated; return the next index."""
        verb, before = phrases.verb_of_side(number), phrases.before(number)
        if phrases.listed[number].kind == "back":
            is_free = not self._route.steps and (before is None or before.kind not in (SIDE, "round"))
            is_turn = verb == "turn" or is_free
        else:
            is_turn = verb in ("turn", "look", "walk")
        if not is_turn:
            return number + 1
        self._route.rotate_around()
        while phrases.is_next(number, "round", "back"):
            number += 1
        return number + 2 if phrases.is_next(number, SIDE) else number + 1


def _direction(phrases: PhraseSequence, number: int) -> str:
    phrase = phrases.listed[number]
    is_slight = phrase.chunk.slight or phrases.verb_of_side(number) == "bear"
    return f"slightly {phrase.value}" if is_slight else phrase.value


def _is_street_beside(phrases: PhraseSequence, number: int) -> bool:
    """Return whether a phrase is a street to turn into, on a stated side."""
    phrase = phrases.listed[number]
    is_taken = phrases.is_after_verb(number, "turn") or (
        phrase.value == "into" and phrases.is_after_verb(number, "walk")
    )
    return is_taken and phrase.last.kind in ("street", "alley") and bool(phrase.named[-1].side)


def _is_faced(phrases: PhraseSequence, number: int) -> bool:
    """Return whether a phrase is a thing to face: "face the bank", "turn towards the bank"."""
    value = phrases.listed[number].value
    is_turned = value == "towards" and phrases.is_after_verb(number, "turn", "look")
    return is_turned or (not value and phrases.is_after_verb(number, "look"))


def _after_clause(phrases: PhraseSequence, number: int) -> int:
    """Return the index after a clause about an object that is not the target."""
    following: Iterator[int] = iter(range(number + 1, phrases.target))
    ends = (n for n in following if phrases.listed[n].kind in (STOP, THEN) or phrases.listed[n].joined == "comma")
    return next(ends, phrases.target)
