"""Parser of free assembly texts with postpositions: the object to place, and its relations."""

from dataclasses import dataclass, field, replace

from arramon_lang.grammar import Grammar
from arramon_lang.meaning import Assembly, Thing, Where
from arramon_lang.reading.chunks.chunker import RELATION, SIDE, SIDES, STOP, THING, VERB, YOURS, Chunk
from arramon_lang.reading.chunks.sequence import ChunkSequence
from arramon_lang.reading.discourse import Discourse

_YOU = Thing("you")

_FIXED = ("wall", "corner")
"""Kinds that a side identifies: "the right wall" is not something to the right of the reader."""


@dataclass(slots=True, kw_only=True)
class PlacementParser:
    """Parser of one text.

    Attributes:
        text: chunks of the text.
        grammar: grammar of the language.
        turns: turns so far.
    """

    text: ChunkSequence
    grammar: Grammar
    turns: list[str] = field(default_factory=list)
    _open: list[Where] = field(default_factory=list)
    """Relations whose subject is still unknown: the object to place, or a landmark."""
    _where: list[Where] = field(default_factory=list)
    _pending: list[Thing] = field(default_factory=list)
    """Things whose role is still unknown."""
    _mentioned: list[Thing] = field(default_factory=list)
    _located: list[Thing] = field(default_factory=list)
    """Things that the text locates, with their relations."""
    _object: Thing | None = None
    _is_stated: bool = False
    _is_open: bool = False
    """Whether the next relations belong to the last located thing."""
    _side: str = ""
    _describes: bool = False

    def read(self) -> Assembly | None:
        """Return the meaning, or None if the text states no relation."""
        discourse = Discourse(self.grammar)
        aside = False
        for number, chunk in enumerate(self.text.chunks):
            aside = chunk.kind == "which" or (aside and chunk.kind not in (VERB, "comma", STOP))
            if aside:
                continue
            if chunk.kind == THING:
                things = [
                    discourse.mention(named) for named in chunk.things if named.kind or named.colour or named.look
                ]
                for thing in things:
                    self._add_thing(thing)
                if things:
                    self._assign_role(number)
            else:
                self._handle_word(number)
        self._close_sentence()
        self._where = [replace(each, things=tuple(map(self._with_location, each.things))) for each in self._where]
        if not self._where:
            return None
        thing = self._object or Thing("")
        return Assembly(tuple(self.turns), replace(thing, where=(), number=""), tuple(dict.fromkeys(self._where)))

    def _handle_word(self, number: int) -> None:
        chunk = self.text.chunks[number]
        if chunk.kind == "tile":
            self._add_thing(_YOU)
        elif chunk.kind == SIDE:
            self._handle_side(number)
        elif chunk.kind == RELATION:
            self._handle_postposition(number)
        elif chunk.kind == YOURS:
            self._handle_own_place(number)
        elif chunk.kind in ("straight", "ahead"):
            self._handle_ahead(number)
        elif chunk.kind in ("it", "them") and self.text.next_kind(number) == RELATION:
            self._handle_pronoun(2 if chunk.kind == "them" else 1)
        elif chunk.kind == VERB and chunk.value == "place":
            self._where += self._open
            self._open = []
        elif chunk.kind == STOP:
            self._close_sentence()

    def _handle_ahead(self, number: int) -> None:
        if self.text.is_relation(number - 1, "from") and self._pending[-1:] == [_YOU]:
            self._relate("in_front_of")
        elif self.text.chunks[number].kind == "ahead" and not self._is_of_thing(number):
            self._open.append(Where("in_front_of", (_YOU,)))

    def _add_thing(self, thing: Thing) -> None:
        thing = replace(thing, number="", which="")
        if self._side and thing.kind in _FIXED:
            thing = replace(thing, where=(Where(f"{self._side}_of", (_YOU,)),))
        elif self._side:
            self._open.append(Where(f"{self._side}_of", (_YOU,)))
        self._side = ""
        if self._describes and self._open:
            thing = replace(thing, where=(*thing.where, self._open.pop()))
        self._describes = False
        self._pending.append(self._with_earlier_attributes(thing))

    def _with_earlier_attributes(self, thing: Thing) -> Thing:
        """Return a thing with the colour and pattern of an earlier mention ("the bucket")."""
        if thing.colour or thing.look or thing.kind in ("", "you", *_FIXED):
            return thing
        return next((each for each in reversed(self._mentioned) if each.kind == thing.kind), thing)

    def _assign_role(self, number: int) -> None:
        """Decide whether the last named thing is the object to place or a landmark, unless a relation to it follows."""
        following = self.text.chunks[number + 1] if number + 1 < len(self.text.chunks) else None
        thing = self._pending[-1]
        if following is not None and following.kind == RELATION and following.value == "object":
            self._set_object(thing)
            self._is_stated = True
        elif following is not None and following.kind in (RELATION, "and", "which"):
            return
        elif self._is_located(number):
            self._add_located(thing)
        elif thing.kind not in _FIXED:
            self._set_object(thing)

    def _is_located(self, number: int) -> bool:
        """Return whether the text locates a thing rather than places it: by a verb of being, or a later "on it"."""
        for chunk in self.text.chunks[number + 1 :]:
            if chunk.kind == VERB:
                return chunk.value in ("be", "see")
            if chunk.kind in (STOP, "comma"):
                return self._object is None and any(map(_refers_back, self.text.chunks[number + 1 :]))
            if chunk.kind in (THING, "it", "there", YOURS, "tile"):
                return False
        return False

    def _add_located(self, thing: Thing) -> None:
        thing = replace(thing, where=(*thing.where, *self._open))
        self._open = []
        self._located.append(thing)
        self._mentioned.append(thing)
        self._pending, self._is_open = [], True

    def _set_object(self, thing: Thing) -> None:
        if self._object is None or not (self._is_stated or self._object.colour or self._object.look):
            self._object = thing
        self._pending, self._is_open = [], False

    def _handle_pronoun(self, count: int) -> None:
        self._is_open = False
        earlier = [thing for thing in self._mentioned if thing.kind not in _FIXED] or self._mentioned
        self._pending = earlier[-count:]

    def _handle_side(self, number: int) -> None:
        chunk, following = self.text.chunks[number], self.text.next_kind(number)
        verb = next(
            (each.value for each in self.text.chunks[number + 1 :] if each.kind not in ("straight", "there")), ""
        )
        if verb in ("turn", "turn_round", "look", "become"):
            direction = "around" if chunk.value == "back" else chunk.value
            self.turns.append(f"slightly {direction}" if chunk.slight and direction != "around" else direction)
        elif chunk.value in SIDES:
            before = self.text.chunks[number - 1] if number else None
            if before is not None and before.kind == RELATION and before.value in ("of", "from") and self._pending:
                self._relate(f"{chunk.value}_of", exactly=chunk.exactly)
            elif following in (THING, SIDE) or self._is_description(number + 1):
                self._side = chunk.value
            else:
                beside = _YOU
                if self._open and self._continues_relation(number):  # "One ahead of the TV and one to the right."
                    beside = self._open[-1].things[0]
                if self._open and self._open[-1].relation == "near" and self._is_after_place(number):
                    beside = self._open.pop().things[0]  # "Beside it, on the left."
                self._open.append(Where(f"{chunk.value}_of", (beside,), chunk.exactly))

    def _continues_relation(self, number: int) -> bool:
        """Return whether a side continues a relation after "and"."""
        before = self.text.chunks[number - 2 : number] if number > 1 else []
        return [chunk.kind for chunk in before] == [RELATION, "and"] and self._is_stepping(before[0])

    def _is_stepping(self, chunk: Chunk) -> bool:
        return self.text.rules.is_in(chunk.value, "stepping")

    def _is_after_place(self, number: int) -> bool:
        return number > 0 and self.text.chunks[number - 1].kind in (RELATION, YOURS)

    def _handle_postposition(self, number: int) -> None:
        value, following = self.text.chunks[number].value, self.text.next_kind(number)
        if self.text.rules.is_in(value, "describing"):
            if following == SIDE:
                return
            if self._pending and following == THING:
                self._open.append(Where("near", (self._pop_pending(),)))
            before = self.text.chunks[number - 1] if number else None
            is_place = before is not None and (before.kind in (THING, RELATION, YOURS) or before.value in SIDES)
            self._describes = following == THING and is_place and bool(self._open)
        elif value == "towards" and self._pending[-1:] == [_YOU]:
            if self._open:  # "One this way from the ball, towards the tile."
                self._pending = []
            else:
                self._relate("in_front_of")
        elif value == "from":
            if following not in (SIDE, "straight", "ahead"):
                self._pending = []
        elif value in ("in", "on") and self._pending and self._pending[-1].kind in _FIXED:
            self._relate("near")
        elif value in self.text.rules.room_relations and self._pending:
            self._relate(self.text.rules.room_relations[value], exactly=self.text.chunks[number].exactly)

    def _handle_own_place(self, number: int) -> None:
        value = self.text.chunks[number].value
        if value in ("between", "through_between"):
            self._pending.append(_YOU)
            self._relate("between")
        elif value and value != "towards":
            relation = self.text.rules.room_relations.get(value, "near")
            self._open.append(Where(relation, (_YOU,), self.text.chunks[number].exactly))
        elif self.text.next_kind(number) == "and":
            self._pending.append(_YOU)

    def _relate(self, relation: str, *, exactly: bool = False) -> None:
        if relation == "between" and len(self._pending) > 1:
            self._open.append(Where(relation, tuple(self._pending[-2:]), exactly))
            landmarks = self._pending[-2:]
        else:
            relation = "near" if relation == "between" else relation
            landmarks = self._pending[-1:]
            self._open.append(Where(relation, (landmarks[0],), exactly))
        self._mentioned += [thing for thing in landmarks if thing.kind not in ("you", "wall", "corner")]
        rest = self._pending[: -len(landmarks)]
        self._pending = []
        if rest and rest[0].kind != "you":
            self._set_object(rest[0])

    def _pop_pending(self) -> Thing:
        thing = self._pending[-1]
        self._pending = []
        return thing

    def _close_sentence(self) -> None:
        """Assign open relations to the object to place at the end of a sentence."""
        if self._side:
            self._open.append(Where(f"{self._side}_of", (_YOU,)))
        if self._is_open and self._open:  # "There is a ball, to the right of the bowl."
            self._add_located(self._located.pop())
        self._is_open = False
        self._where += self._open
        self._open, self._side, self._describes = [], "", False

    def _with_location(self, thing: Thing) -> Thing:
        """Return a landmark with the relations that locate it."""
        shown = next((each for each in self._located if each.is_same(thing)), None)
        return thing if shown is None or thing.where else shown

    def _is_of_thing(self, number: int) -> bool:
        """Return whether "ahead" describes the next thing: "the wall ahead"."""
        at = number + 1 + self._is_description(number + 1)
        following = self.text.chunks[at] if at < len(self.text.chunks) else None
        if following is None or following.kind != THING:
            return False
        return at > number + 1 or following.things[0].kind == "wall"

    def _is_description(self, number: int) -> bool:
        chunk = self.text.chunks[number] if number < len(self.text.chunks) else None
        return chunk is not None and chunk.kind == RELATION and self.text.rules.is_in(chunk.value, "describing")


def _refers_back(chunk: Chunk) -> bool:
    return chunk.kind in ("it", VERB) or (chunk.kind == THING and bool(chunk.things[0].reference))
