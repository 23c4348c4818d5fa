"""Base class of the postposition route parser: what a side belongs to, a turn, a thing passed, or the target."""

from dataclasses import dataclass, replace

from arramon_lang.meaning import Rotate, Walk
from arramon_lang.reading.chunks.chunker import RELATION, SIDE, STOP, THEN, THING, VERB
from arramon_lang.reading.chunks.postpositions.route_draft import RouteDraft
from arramon_lang.reading.discourse import CROSSED_KINDS, POINT_KINDS

BOUNDARIES = ("comma", THEN, STOP, "and")

_ROUND = ("around", "back")

_JUNCTION_KINDS = ("intersection", "t_junction", "street_end")


@dataclass(slots=True, kw_only=True)
class SideParser(RouteDraft):
    """Route draft that interprets each side by its neighbours in the text."""

    _side: str = ""
    _relation: int = -1

    def _handle_side(self, number: int, chosen: int) -> int:
        """Read a side as a turn, a thing's side, or the target's side; return the index of the last chunk consumed."""
        chunk, verb = self.text.chunks[number], self.text.verb_after(number)
        end = number + (verb in ("turn", "turn_round"))
        if self._target is not None or (self._relation == number and end == number):
            return number
        if chunk.value in _ROUND or verb == "turn_round":
            if verb == "turn_round" or self._is_round(number):
                self._add_turn("around")
            return end
        if self._pending and not self._joined and verb != "turn":
            return self._side_of_named(number)
        direction = f"slightly {chunk.value}" if chunk.slight else chunk.value
        if self.text.rules.is_in(verb, "moving"):
            if not self._is_repeated(direction):
                self._add_turn(direction)
            return end
        if self.text.is_relation(number + 1, "from") and self.steps[-1:] == [Rotate("around")] and not self._pending:
            return number  # "Turn around, from the right."
        if verb == "keep" and not self._pending:
            self._set_side_passed(chunk.value)
        if (
            self.text.rules.is_in(verb, "standing")
            or (verb == "pass" and not self._places)
            or self._is_repeated(direction)
        ):
            return number
        if self._is_of_target(number, chosen) and not self._is_alone(number + 1, chosen):
            return self._side_of_place(number, chosen)
        return self._side_or_turn(number, direction)

    def _side_of_place(self, number: int, chosen: int) -> int:
        """Read a side that says where the target is; return the index of the last chunk consumed."""
        side = self.text.chunks[number].value
        if self._places and self.text.is_relation(number - 1, "from"):
            self._places[-1] = replace(self._places[-1], value=f"{side}_of")
        if self.text.is_relation(number + 1, "having") and number + 2 < chosen:
            self._side = side  # "By the bench on the right."
            return number + 1
        return number

    def _set_side_passed(self, side: str) -> None:
        """Give a side to the thing passed last: "past the tree, it stays on your left"."""
        if self._is_passing():
            self._walk_to_places()
        last = self.steps[-1] if self.steps and not self._places else None
        if isinstance(last, Walk) and last.way == "past" and not last.side:
            self.steps[-1] = replace(last, side=side)

    def _is_round(self, number: int) -> bool:
        """Return whether a side means a turn around: with a verb of moving, or as a clause of its own."""
        is_whole = self.text.next_kind(number) in (*BOUNDARIES, "")
        is_around = self.text.chunks[number].value == "around"
        return self.text.rules.is_in(self.text.verb_after(number), "moving") or (
            (is_whole or self._is_first()) if is_around else (is_whole and self._is_first())
        )

    def _is_repeated(self, direction: str) -> bool:
        """Return whether a turn only repeats the last one ("yes, left")."""
        last = self.steps[-1] if self.steps else None
        return "repeat" in self._flags and isinstance(last, Rotate) and last.direction == direction

    def _side_of_named(self, number: int) -> int:
        """Pass the pending things on a side stated after them."""
        side, is_coming = self.text.chunks[number].value, self.text.verb_after(number) == "come"
        self._walk_to_places()
        if is_coming:
            self._pass(self._pending[:-1], side)
            self._walk_beside(replace(self._pending[-1], side=side))
        else:
            self._pass(self._pending, side)
        self._pending = []
        return number + is_coming

    def _side_or_turn(self, number: int, direction: str) -> int:
        """Read a side as that of the next thing, or else as a turn; return the index of the last chunk consumed."""
        side, following = self.text.chunks[number].value, self.text.next_kind(number)
        if following == THING and self._pending and self._pending[-1].side and self._joined == "and":
            self._side = side
        elif following == THING and (
            not self._is_way(number + 1) or (self.text.chunks[number].nominal and self._is_beside_way(number + 1))
        ):
            self._walk_to_places()
            self._pass(self._pending)
            self._pending, self._side = [], side
        elif self.text.is_relation(number + 1, "of", "having"):
            is_way = self._is_way(number + 2) and not self._is_beside_way(number + 2)
            if is_way and not self._is_turned_into_there(number + 2):
                self._add_turn(direction)
            else:
                self._side = side
            return number + 1
        else:
            self._add_turn(direction)
        return number

    def _is_of_target(self, number: int, chosen: int) -> bool:
        """Return whether a side says where the target is."""
        chunk = self.text.chunks[number]
        between = [
            each.kind
            for n, each in enumerate(self.text.chunks[number + 1 : chosen], number + 1)
            if each.kind != SIDE or not self.text.is_relation(n - 1, "of", "from")
        ]
        if chosen < number or STOP in between:
            return False
        verbs = [each.value for each in self.text.chunks[number + 1 : chosen] if each.kind == VERB]
        if any(value in ("walk", "turn", "pass") for value in verbs) or SIDE in between or THEN in between:
            return False
        if any(self._ends_walk(n) for n in range(number + 1, chosen)):
            return False
        if self._is_whole_clause(number):
            return False
        if chunk.nominal or chunk.slight:
            return not any(self._is_alone(n, chosen) for n in range(number + 1, chosen))
        if self._places and self.text.next_kind(number) == "comma" and number + 2 == chosen:
            return not self._ends_way()
        if self.text.next_kind(number) == THING and self.text.chunks[number + 1].things[0].kind == "street":
            return True  # "On the left pavement."
        return self.text.next_kind(number) not in BOUNDARIES and not self._is_way(number + 1)

    def _is_whole_clause(self, number: int) -> bool:
        """Return whether a side is a clause that can only be a turn.

        "A bit left," opens the text or is followed by "there"; "onto the street on the left,".
        """
        if self.text.chunks[number].slight and not self._pending and self.text.next_kind(number) == "comma":
            return self._is_first() or self.text.next_kind(number + 1) == "there"
        return self.text.is_relation(number + 1, "having") and self._is_turned_into_there(number + 2)

    def _ends_walk(self, number: int) -> bool:
        """Return whether a clause without a verb ends there that says where to walk: "straight,", "past the tree,"."""
        chunk = self.text.chunks[number]
        is_walk = chunk.kind == RELATION and self.text.rules.is_in(chunk.value, "leading", "passing")
        return (is_walk or chunk.kind in ("straight", "ahead")) and self.text.next_kind(number) in BOUNDARIES

    def _ends_way(self) -> bool:
        """Return whether the last place is passed or a junction, so that a side after it is a turn."""
        return self._is_passing() or self._places[-1].named[-1].thing.kind in _JUNCTION_KINDS

    def _is_first(self) -> bool:
        return not self.steps and not self._pending and not self._places

    def _is_alone(self, number: int, end: int) -> bool:
        """Return whether things are named there with no relation, only a side."""
        if self.text.chunks[number].kind != THING:
            return False
        after = next((chunk for chunk in self.text.chunks[number:end] if chunk.kind not in (THING, "and")), None)
        return after is not None and after.kind != RELATION

    def _is_way(self, number: int) -> bool:
        """Return whether the thing there is walked to or along, rather than beside the way."""
        for n in range(number, len(self.text.chunks)):
            chunk = self.text.chunks[n]
            if chunk.kind == THING:
                if chunk.things[0].kind in ("street", "alley"):
                    return True
            elif chunk.kind == RELATION and chunk.value not in ("of", "having"):
                is_standing = self.text.rules.is_in(self._closing_verb(n), "standing")
                return self.text.rules.is_in(chunk.value, "leading") and not is_standing
            elif (chunk.kind == "and" and self.text.next_kind(n) == SIDE) or chunk.kind not in ("and", RELATION):
                return False
        return False

    def _is_turned_into_there(self, number: int) -> bool:
        """Return whether a street is named there, and what follows says that one turns into it."""
        things = self.text.chunks[number].things if number < len(self.text.chunks) else ()
        if not things or things[0].kind not in ("street", "alley"):
            return False
        is_place = self.text.is_relation(number + 1, "on", "in")
        is_whole = is_place and (
            self.text.next_kind(number + 1) in BOUNDARIES or self.text.verb_after(number + 1) == "turn"
        )
        return is_whole or self.text.verb_after(number) == "become"

    def _is_beside_way(self, number: int) -> bool:
        """Return whether the thing there stands beside the way and is passed: "past the red car on the right"."""
        if self.text.next_kind(number - 1) != THING or self.text.next_kind(number) != RELATION:
            return False
        is_beside = self.text.chunks[number].things[0].kind not in (*CROSSED_KINDS, "alley", *POINT_KINDS)
        return is_beside and self.text.rules.is_in(self.text.chunks[number + 1].value, "passing")

    def _closing_verb(self, number: int) -> str:
        return next((chunk.value for chunk in self.text.chunks[number:] if chunk.kind in (VERB, "comma", STOP)), "")
