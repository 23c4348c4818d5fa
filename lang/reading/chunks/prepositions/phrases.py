"""Phrases of a free text: things with their relation and sides, turns, verbs and other words."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from arramon_lang.meaning import Thing
from arramon_lang.reading.chunks.chunker import SIDE, SIDES, STOP, THEN, VERB, Chunk
from arramon_lang.reading.chunks.rules import ChunkRules

THINGS, TARGET, OTHER = "things", "target", "other"

_STRAIGHT = ("there", "straight", "ahead")


@dataclass(slots=True)
class ListedThing:
    """A thing in a list, with its side if stated; `joined` is the conjunction before it."""

    thing: Thing
    side: str = ""
    joined: str = ""


@dataclass(slots=True)
class Phrase:
    """A group of chunks with one function.

    Attributes:
        kind: THINGS, SIDE, TARGET, OTHER (a collectible that is not the target), VERB, STOP, THEN, or a key of `words`
            in `chunks.toml`.
        value: the relation of the things, "" without one; the verb; the side.
        joined: what precedes it: "", "comma", "and", or "then" for the end of a clause.
        named: the things.
        chunk: its first chunk.
        is_pronoun: whether a pronoun refers to the things.
    """

    kind: str
    value: str
    joined: str
    chunk: Chunk
    named: list[ListedThing] = field(default_factory=list)
    is_pronoun: bool = False

    @property
    def last(self) -> Thing:
        """The last of the things."""
        return self.named[-1].thing


@dataclass(frozen=True, slots=True)
class PhraseSequence:
    """Phrases of a text in order, with queries about their neighbours.

    Attributes:
        listed: all phrases.
        target: index of the phrase that names the target.
        rules: meanings of the language's relations and verbs.
    """

    listed: Sequence[Phrase]
    target: int
    rules: ChunkRules

    def before(self, number: int) -> Phrase | None:
        """Return the previous phrase, or None."""
        return self.listed[number - 1] if number else None

    def is_after_verb(self, number: int, *values: str) -> bool:
        """Return whether the previous phrase is one of these verbs."""
        before = self.before(number)
        return before is not None and before.kind == VERB and before.value in values

    def is_next(self, number: int, *kinds: str) -> bool:
        """Return whether the next phrase is of one of these kinds and follows without a conjunction."""
        after = self.listed[number + 1] if number + 1 < len(self.listed) else None
        return after is not None and after.kind in kinds and not after.joined

    def follows_thing(self, number: int) -> bool:
        """Return whether a phrase follows a thing directly."""
        before = self.before(number)
        return before is not None and before.kind == THINGS and bool(before.named) and not self.listed[number].joined

    def ends_clause(self, number: int) -> bool:
        """Return whether a phrase is the last of its clause."""
        after = self.listed[number + 1]
        return bool(after.joined) or after.kind in (STOP, THEN)

    def verb_of_side(self, number: int) -> str:
        """Return the verb that a side belongs to, or ""."""
        for phrase in reversed(self.listed[:number]):
            if phrase.kind == VERB:
                return phrase.value
            if phrase.kind not in (*_STRAIGHT, "back"):
                return ""
        return ""

    def is_turn(self, number: int) -> bool:
        """Return whether a side is a turn."""
        phrase = self.listed[number]
        if phrase.kind != SIDE or phrase.value not in SIDES or phrase.chunk.nominal:
            return False
        return not (self.is_side_of_target(number) or self._is_intensifier(number))

    def turn_after(self, number: int, *, is_close: bool = False) -> int | None:
        """Return the index of a following turn that is made at a phrase's things, or None.

        Args:
            number: index of the phrase.
            is_close: whether the turn must follow without a comma.
        """
        for at in range(number + 1, self.target):
            phrase = self.listed[at]
            if phrase.joined == "and" or (phrase.joined and (is_close or self.follows_thing(number))):
                return None
            if phrase.kind == SIDE:
                return at if self.is_turn(at) else None
            is_verb = phrase.kind == VERB and self.rules.is_in(phrase.value, "moving", "standing")
            if phrase.kind not in _STRAIGHT and not is_verb:
                return None
        return None

    def place_of_turn(self, number: int) -> int | None:
        """Return the index of a phrase after a turn that says where it is made, or None."""
        after = number + 1
        if self.enters_alley(after):
            after += 1  # "Left into the lane by the bank."
        for at in range(after, min(after + 2, self.target)):
            phrase = self.listed[at]
            if phrase.kind == THINGS:
                is_ground = phrase.named[0].thing.kind in ("street", "alley") and phrase.value == "on"
                is_place = self.rules.is_in(phrase.value, "at_turn") and not phrase.named[0].side and not is_ground
                return at if is_place and self._is_of_turn(at) else None
            if phrase.kind not in _STRAIGHT:
                return None
        return None

    def enters_alley(self, number: int) -> bool:
        """Return whether a phrase names the alley that a turn leads into, and the next phrase says where it is."""
        if number + 1 >= self.target:
            return False
        phrase = self.listed[number]
        is_into = phrase.kind == THINGS and phrase.value in ("into", "on") and not phrase.joined
        return is_into and phrase.last.kind == "alley" and self.is_next(number, THINGS)

    def turn_right_after(self, number: int) -> int | None:
        """Return the index of a turn right after a phrase ("round the house to the left"), or None."""
        is_side = number + 1 < self.target and self.is_next(number, SIDE)
        return number + 1 if is_side and self.listed[number + 1].value in SIDES else None

    def is_side_of_target(self, number: int) -> bool:
        """Return whether a side says where the target is."""
        chunk, verb = self.listed[number].chunk, self.verb_of_side(number)
        if verb == "look" or self.rules.is_in(verb, "moving"):
            return verb == "look"
        is_free = all(
            each.kind in _STRAIGHT
            or (each.kind == VERB and self.rules.is_in(each.value, "standing"))
            or (each.kind == THINGS and self.rules.is_in(each.value, "at_turn"))
            for each in self.listed[number + 1 : self.target]
        )
        return is_free and (chunk.slight or chunk.end - chunk.start > 1)

    def has_only_places_before_target(self, number: int) -> bool:
        """Return whether there are only places between a phrase and the target."""
        for at in range(number + 1, self.target):
            phrase = self.listed[at]
            is_place = phrase.kind == THINGS and not self.rules.is_in(phrase.value, "leading")
            is_said = phrase.kind == VERB and phrase.value in ("be", "see", "look", "end")
            is_side = phrase.kind == SIDE and self.is_side_of_target(at)
            if not (is_place or is_said or is_side or phrase.kind in (*_STRAIGHT, "not", "but", OTHER)):
                return False
        return True

    def _is_of_turn(self, number: int) -> bool:
        """Return whether a place belongs to the turn before it, possibly after a comma."""
        phrase = self.listed[number]
        is_last = self.listed[number + 1].kind in (STOP, THEN) and len(phrase.named) == 1
        is_close = phrase.value in ("before", "around", "in_front_of") or (is_last and phrase.value in ("by", "at"))
        if phrase.joined and not (phrase.joined == "comma" and is_close):
            return False
        return self.turn_after(number, is_close=True) is None

    def _is_intensifier(self, number: int) -> bool:
        """Return whether a side only stresses the next relation: "Right after the crossing there is a mug"."""
        phrase, after = self.listed[number], self.listed[number + 1 : self.target]
        if phrase.chunk.slight or not self.rules.is_in(phrase.value, "stressing") or not after:
            return False
        if phrase.joined == "and" and self._is_before_turn(number, ("turn", "swing", "bear")):
            return True  # "And right after the bin make a left."
        if self.rules.is_in(self.verb_of_side(number), "moving"):
            return False
        if self.is_next(number, "ahead"):
            return True
        if not self.is_next(number, THINGS):
            return False
        before = self.before(number)
        is_apart = before is None or before.kind == STOP or phrase.joined == "comma"
        is_located = any(each.kind == VERB and self.rules.is_in(each.value, "standing") for each in after)
        group = "stressed" if is_apart else "placing"
        if is_located and (is_apart or phrase.joined == "and") and self.rules.is_in(after[0].value, group):
            return self.has_only_places_before_target(number)
        return is_apart and self._is_before_turn(number)  # "Right after the bin, turn left."

    def _is_before_turn(self, number: int, verbs: Sequence[str] = ()) -> bool:
        """Return whether a side stresses the place of a turn that a verb tells, one of these if any are given."""
        if not self.is_next(number, THINGS) or not self.rules.is_in(self.listed[number + 1].value, "stressed"):
            return False
        turn = self.turn_after(number + 1)
        told = () if turn is None else self.listed[number:turn]
        return any(each.kind == VERB and (not verbs or each.value in verbs) for each in told)
