"""Parser of free navigation texts with postpositions: chunks to steps and the target."""

from dataclasses import dataclass, replace

from arramon_lang.grammar import Grammar
from arramon_lang.meaning import Face, Navigation, Rotate, Thing, Walk, Where
from arramon_lang.reading.chunks.chunker import RELATION, SIDE, SIDES, STOP, THEN, THING, VERB
from arramon_lang.reading.chunks.postpositions.route_draft import PendingPlace, PendingThing
from arramon_lang.reading.chunks.postpositions.side_parser import BOUNDARIES, SideParser
from arramon_lang.reading.discourse import GROUND_KINDS, POINT_KINDS, Discourse
from arramon_lang.reading.parsed_phrases import NounPhrase

_FLAGS = ("there", "back_again", "which", "one_side", "other_side", "repeat", "until")
"""Kinds of words that change the meaning of the next chunks."""


@dataclass(slots=True, kw_only=True)
class PostpositionRouteParser(SideParser):
    """Parser of one navigation text with postpositions: keeps things open until their postposition and verb are read.

    Attributes:
        grammar: grammar of the language.
    """

    grammar: Grammar
    _describes: bool = False
    _ahead: int = -1  # number of steps when "ahead" was read, which faces the thing named next

    def read(self) -> Navigation | None:
        """Return the meaning, or None if the text names no target."""
        discourse = Discourse(self.grammar)
        chosen = self.text.target()
        if chosen is None:
            return None
        skipped = -1
        for number, chunk in enumerate(self.text.chunks):
            if number <= skipped:
                continue
            if chunk.kind == THING:
                things = [self._resolved(discourse, named) for named in chunk.things]
                skipped = self._handle_things(number, things, chosen)
            elif chunk.kind == SIDE:
                skipped = self._handle_side(number, chosen)
            else:
                self._handle_word(number)
        self._close_sentence()
        target = self._target or Thing("")
        return Navigation(tuple(self.steps), replace(target, where=tuple(dict.fromkeys(self._where))))

    # Things.

    def _resolved(self, discourse: Discourse, named: NounPhrase) -> Thing:
        thing = discourse.mention(named)
        if not thing.kind and not self.text.noun_phrases.is_collectible(named) and self._mentioned:
            thing = replace(thing, kind=self._mentioned[-1].kind)
        return thing

    def _handle_things(self, number: int, things: list[Thing], chosen: int) -> int:
        """Handle the things of a chunk; return the index of the last chunk consumed."""
        if number == chosen:
            self._set_target(things[0], number)
        elif self.text.is_collectible(number) and self._is_distracter(number):
            return self._skip_distracter(number, things[0])
        else:
            for thing in things:
                self._add_thing(thing)
                self._joined = "and"
            self._joined = ""
        return number

    def _is_distracter(self, number: int) -> bool:
        if self.text.is_landmark_after(number) and self._target is not None:
            return False
        if self._target is None or self.text.is_negated(number) or self.text.next_kind(number) != RELATION:
            return self._target is not None or self.text.is_negated(number)
        return self.text.is_relation(number + 1, "of", "having", "object")

    def _add_thing(self, thing: Thing) -> None:
        at: tuple[PendingPlace, ...] = ()
        if self._describes and self._pending:
            size = self._joined_size() if thing.kind in (*POINT_KINDS, "street", "alley") else 1
            at = (PendingPlace("near", tuple(self._pending[-size:])),)
            del self._pending[-size:]
        elif self._describes and self._places:
            at = (self._places.pop(),)
        shown = at[0].named[0].thing if at else thing
        is_shop = thing.kind in ("building", "shop_sign") and shown.kind == "shop_sign" and bool(shown.look)
        if at and (is_shop or (thing.kind == "corner" and shown.kind in ("building", "shop_sign"))):
            thing, at = shown, ()  # The building with the cinema's sign, or the cinema's corner: the cinema.
        self._pending.append(PendingThing(thing, self._joined, self._side, at))
        self._mentioned.append(thing)
        if "other_side" in self._flags and len(self._pending) > 1:
            self._flags.discard("one_side")
            pair = (self._pending[-2], self._pending[-1])
            self._pending[-2:] = []
            self._places.append(PendingPlace("between", pair))
        self._describes = False
        self._flags.discard("other_side")
        self._joined = ""

    def _set_target(self, thing: Thing, number: int) -> None:
        if self._places and self.text.is_relation(number - 1, "far_side"):
            self._places[-1] = replace(self._places[-1], value="behind")  # "On the far side of the tree the mug."
        self._pass(self._pending)
        self._pending = []
        self._locate_target()
        if (
            "there" in self._flags
            and not self._where
            and self._mentioned
            and self._mentioned[-1].kind not in GROUND_KINDS
        ):
            self._where.append(Where("near", (self._mentioned[-1],)))
        self._target = self.text.described(thing, number)
        self._side = ""

    def _skip_distracter(self, number: int, thing: Thing) -> int:
        """Skip the description of an object that is not the target."""
        if self._target is None:
            self._pass(self._pending)
        self._pending, self._places, self._side = [], [], ""
        end = number
        for n, chunk in enumerate(self.text.chunks[number + 1 :], number + 1):
            if chunk.kind == STOP:
                break
            if chunk.kind == "not" or self._target is not None:
                end = n
        self._mentioned.append(thing)
        return end

    # Postpositions, verbs and joining words.

    def _handle_word(self, number: int) -> None:
        chunk = self.text.chunks[number]
        if chunk.kind == RELATION:
            self._handle_postposition(chunk.value, number)
        elif chunk.kind == VERB:
            self._handle_verb(chunk.value, number)
        elif chunk.kind == STOP:
            self._close_sentence()
        elif chunk.kind in BOUNDARIES:
            self._handle_conjunction(chunk.kind)
        elif chunk.kind in ("it", "them"):
            self._handle_pronoun(number)
        elif chunk.kind == "all" and self._pending:
            self._pending = [replace(each, joined="comma") for each in self._pending]
            self._joined = ""
        elif chunk.kind in _FLAGS:
            self._handle_flag(number)
        elif chunk.kind in ("straight", "ahead") and not self._pending:
            if self._is_passing("through_between"):
                self._walk_to_places()
            if not (self._places and self._places[-1].value in ("to", "towards")):  # "Straight to the cone."
                self._walk_ahead(is_clause=self._is_clause(number))
                self._ahead = len(self.steps) if chunk.kind == "ahead" else -1

    def _handle_flag(self, number: int) -> None:
        kind = self.text.chunks[number].kind
        self._flags.add(kind)
        if kind == "back_again" and self._is_first() and self.text.next_kind(number) in BOUNDARIES:
            self._add_turn("around")
        elif kind == "there" and self._joined and self._is_passing() and self.text.next_kind(number) != SIDE:
            self._walk_to_places()  # "Past the bank, there is a book."

    def _handle_conjunction(self, kind: str) -> None:
        is_new = kind == THEN and self._joined in ("comma", "and")
        if not self._joined or kind == THEN or (kind == "comma" and self._joined == "and"):
            # "A then B on the left" is one list, "A, then B on the left" two.
            self._joined = "comma" if kind == THEN and not self._joined else kind
        last = self._places[-1] if self._places and self._target is None else None
        is_walked = last is not None and (last.value in ("to", "towards") or self._is_turned_into(last))
        is_walked = is_walked or (last is not None and last.value == "by" and kind == "comma")
        if kind in ("comma", THEN) and self._is_faced():
            self._face(self._pending.pop())
        if (is_new and self._is_passing()) or (kind in ("comma", THEN) and is_walked):
            if last is not None and last.value == "towards" and not self.steps and len(self._places) == 1:
                self.steps.append(Face(last.named[0].thing))  # "Towards the tree," whether one walks or turns there.
            self._walk_to_places()
        if kind != "and":
            self._side = ""

    def _is_faced(self) -> bool:
        """Return whether the pending thing is said to be ahead, with nothing between: "ahead of you is a tree"."""
        is_ahead = self._ahead == len(self.steps) and self.steps[-1:] == [Walk("ahead")] and not self._places
        return (
            is_ahead
            and self._target is None
            and len(self._pending) == 1
            and not self._pending[0].side
            and not self._pending[0].again
        )

    def _face(self, named: PendingThing) -> None:
        self.steps[-1] = Face(named.thing)
        self._ahead = -1

    def _handle_pronoun(self, number: int) -> None:
        """Resolve a pronoun to the last one or two things, or to the last street or square for "in it"."""
        if self.text.next_kind(number) != RELATION:
            return
        is_group = bool(self._mentioned) and bool(self._mentioned[-1].number)  # "The two cones: go towards them."
        size = 2 if self.text.chunks[number].kind == "them" and not is_group else 1
        within = [thing for thing in self._mentioned if thing.kind in GROUND_KINDS]
        is_in = self.text.chunks[number + 1].value == "in" and bool(within)
        self._pending += [
            PendingThing(thing, "and", again=True) for thing in (within if is_in else self._mentioned)[-size:]
        ]

    def _handle_postposition(self, value: str, number: int) -> None:
        if value == "steps_behind":  # "Turn back from the bank", "behind the bank".
            is_turn = self.text.rules.is_in(self.text.verb_after(number), "moving")
            if self._pending:
                self._add_place("at" if is_turn else "behind")
            if is_turn:
                self._add_turn("around")
            return
        value = "at" if value in ("on", "in", "from") else value
        following = self.text.next_kind(number)
        if self.text.rules.is_in(value, "describing"):
            side = self.text.chunks[number + 1] if following == SIDE else None
            if side is not None and side.value in SIDES and self._pending:
                self._add_place(f"{side.value}_of")
                self._relation = number + 1
            else:
                self._describes = following == THING
            return
        is_there = number > 0 and self.text.chunks[number - 1].kind == "there"
        if value in ("to", "before") and not self._pending and is_there:  # "Up to there."
            self._pending += [PendingThing(thing, self._joined, again=True) for thing in self._mentioned[-1:]]
            self._flags.discard("there")
        if value == "object" or not self._pending:
            return
        self._add_place(value)
        if self.text.rules.is_in(value, "passing"):
            self._side = ""

    def _handle_verb(self, value: str, number: int) -> None:
        if self.text.rules.is_in(value, "standing"):
            self._handle_location_verb(value, number)
        elif value == "pass" and self._target is None:
            self._walk_to_places()
            self._pass(self._pending)
            self._pending = []
        elif value in ("walk", "return"):
            if not (self.text.is_relation(number + 1, "having") or self._is_at_target(number)):
                self._handle_walk_verb(is_return=value == "return")
        elif value == "turn" and self._places and self._is_turned_into(self._places[-1]):
            self._walk_to_places()
            self._side = ""
        elif value == "become" and self._pending and self._pending[-1].side and self._target is None:
            self._add_place("at")  # "Take the first street on the left."
            self._side = ""
        elif value == "back" and self._places and self._places[-1].value == "at":
            self._places.pop()
        elif value in ("turn", "look", "back") and self._places and self._places[-1].value == "towards":
            last = self._places.pop().named[-1]
            self._walk_to_places()
            if value != "back":
                self.steps.append(Face(last.thing))
            elif self.text.next_kind(number) != SIDE:
                self._add_turn("around")
        elif value == "turn_round" or (
            value == "turn" and "back_again" in self._flags and self.text.next_kind(number) != SIDE
        ):
            self._add_turn("around")

    def _handle_location_verb(self, value: str, number: int) -> None:
        """Handle things with a verb of location: they are somewhere, appear, are visible, or stay on a side."""
        if value == "come" and not (self._pending and self._pending[-1].side):
            self._flags.add("there")
        if value == "be" and not self._pending and self._places and number + 1 == self.text.target():
            last = self._places[-1]  # "The mug that is ahead of it."
            self._places[-1] = replace(last, value="in_front_of" if last.value == "beyond" else last.value)
        if "one_side" in self._flags or not self._pending:
            return
        if value in ("see", "be") and self._is_faced():
            self._face(self._pending.pop())
            return
        named, self._pending = self._pending, []
        if self._target is not None:
            self._where += [Where("near", (each.thing,)) for each in named]
        elif "which" in self._flags:
            del self._mentioned[-len(named) :]
        else:
            if value == "be" and self._places and self._places[-1].value == "at" and not named[-1].side:
                named = list(self._places.pop().named)  # "On the building is a flag": it is the building.
            self._walk_to_places()
            self._pass(named[:-1])
            self._pass_beside(named[-1])
            if value == "come" and named[-1].side:
                self._walk_beside(named[-1])
            else:
                self._walk("past" if named[-1].side else "to" if value == "come" else "until", named[-1])
        self._flags.discard("which")

    def _is_at_target(self, number: int) -> bool:
        """Return whether one walks to the target's place: "go to the left of the sign and take the mug"."""
        following = number + 1
        while self.text.chunks[following : following + 1] and self.text.chunks[following].kind in (
            "comma",
            "and",
            "there",
        ):
            following += 1
        is_side = bool(self._places) and self._places[-1].value in ("left_of", "right_of")
        return is_side and self._target is None and following == self.text.target()

    def _handle_walk_verb(self, *, is_return: bool) -> None:
        if self._target is not None:
            return
        if (is_return or "back_again" in self._flags) and not self.steps and not self._places:
            self._add_turn("around")
        last = self._places[-1] if self._places else None
        self._walk_to_places(reaching=last is not None and self._is_reached(last))

    def _is_clause(self, number: int) -> bool:
        """Return whether a chunk is a clause of its own."""
        before = self.text.chunks[number - 1].kind if number else STOP
        return before in BOUNDARIES and self.text.next_kind(number) in BOUNDARIES

    def _walk_ahead(self, *, is_clause: bool) -> None:
        is_turned = not self.steps or isinstance(self.steps[-1], (Rotate, Face))
        if self._target is None and (is_turned or (is_clause and self.steps[-1] != Walk("ahead"))):
            if is_clause:
                self._walk_to_places()
            self.steps.append(Walk("ahead"))

    def _close_sentence(self) -> None:
        if self._target is None:
            self._walk_to_places()
            self._pass(self._pending)
        else:
            self._locate_target()
            self._where += [Where("near", (each.thing,)) for each in self._pending]
        self._pending, self._joined, self._side = [], THEN, ""
        self._describes = False
        self._flags.clear()
