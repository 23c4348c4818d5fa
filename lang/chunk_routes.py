"""Navigation instructions read by chunks: what is passed and reached, turns, and where the object to pick up is."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from lang.chunk_steps import GROUND, PASSED, POINTS, Named, Place, Route
from lang.chunks import LOOK, SIDE, THING, Chunk
from lang.discourse import Discourse
from lang.grammar import Grammar
from lang.meaning import Face, Navigation, Rotate, Thing, Walk, Where
from lang.noun_phrases import NounPhrase, NounPhraseReader

_BOUNDARIES = ("comma", "then", "stop", "and")


_ROUND = ("around", "back")


_SIGNS = ("there", "back_again", "which", "one_side", "other_side", "repeat", "until")
"""Words that change what the next chunks mean."""

_STANDING = ("see", "be", "keep", "place", "come")
"""Verbs that say of things where they are, not that one moves."""

_MOVING = ("turn", "turn_round", "walk", "return", "become", "look")
"""Verbs that make a side a turn."""


@dataclass(slots=True, kw_only=True)
class RouteReader(Route):
    """Reads one text's chunks.

    Attributes:
        chunks: of the text.
        grammar: of the language.
        noun_phrases: its reader, which knows what can be picked up.
    """

    chunks: Sequence[Chunk]
    grammar: Grammar
    noun_phrases: NounPhraseReader
    _side: str = ""
    _describes: bool = False
    _relation: int = -1

    def read(self) -> Navigation | None:
        """Return the meaning, or None if nothing to pick up is named."""
        discourse = Discourse(self.grammar)
        chosen = self._chosen()
        if chosen is None:
            return None
        skipped = -1
        for number, chunk in enumerate(self.chunks):
            if number <= skipped:
                continue
            if chunk.kind == THING:
                things = [self._thing(discourse, named) for named in chunk.things]
                skipped = self._name(number, things, chosen)
            elif chunk.kind == SIDE:
                skipped = self._turn_or_side(number, chosen)
            else:
                self._word(number)
        self._stop()
        target = self._target or Thing("")
        return Navigation(tuple(self.steps), replace(target, where=tuple(dict.fromkeys(self._where))))

    # Which of the collectibles is to be picked up.

    def _chosen(self) -> int | None:
        found = [(self._score(n), n) for n, chunk in enumerate(self.chunks) if self._is_collectible(chunk)]
        return max(found)[1] if found else None

    def _score(self, number: int) -> tuple[bool, int]:
        chunk = self.chunks[number]
        named = chunk.things[0]
        return not (chunk.also or self._is_denied(number)), sum(map(bool, (named.kind, named.colour, named.look)))

    def _is_denied(self, number: int) -> bool:
        for chunk in self.chunks[number + 1 :]:
            if chunk.kind in ("stop", "not") or self._is_collectible(chunk):
                return chunk.kind == "not"
        return False

    def _is_collectible(self, chunk: Chunk) -> bool:
        return chunk.kind == THING and len(chunk.things) == 1 and self.noun_phrases.is_collectible(chunk.things[0])

    # Things.

    def _thing(self, discourse: Discourse, named: NounPhrase) -> Thing:
        thing = discourse.mention(named)
        if not thing.kind and not self.noun_phrases.is_collectible(named) and self._said:
            thing = replace(thing, kind=self._said[-1].kind)
        return thing

    def _name(self, number: int, things: list[Thing], chosen: int) -> int:
        """Take note of what a chunk names; return the number of the last chunk that this explains."""
        if number == chosen:
            self._found(things[0], number)
        elif self._is_collectible(self.chunks[number]) and self._is_distracter(number):
            return self._pass_over(number, things[0])
        else:
            for thing in things:
                self._add(thing)
                self._joined = "and"
            self._joined = ""
        return number

    def _is_distracter(self, number: int) -> bool:
        if self._target is None or self._is_denied(number) or self._next(number) != "behind":
            return self._target is not None or self._is_denied(number)
        return self._is_behind(number + 1, "of", "having", "object")

    def _add(self, thing: Thing) -> None:
        at: tuple[Place, ...] = ()
        if self._describes and self._named:
            size = self._joined_size() if thing.kind in (*POINTS, "street", "alley") else 1
            at = (Place("near", tuple(self._named[-size:])),)
            del self._named[-size:]
        elif self._describes and self._places:
            at = (self._places.pop(),)
        shown = at[0].named[0].thing if at else thing
        is_shop = thing.kind in ("building", "shop_sign") and shown.kind == "shop_sign" and bool(shown.look)
        if at and (is_shop or (thing.kind == "corner" and shown.kind in ("building", "shop_sign"))):
            thing, at = shown, ()  # The building with the cinema's sign, or the cinema's corner: the cinema.
        self._named.append(Named(thing, self._joined, self._side, at))
        self._said.append(thing)
        if "other_side" in self._signs and len(self._named) > 1:
            self._signs.discard("one_side")
            pair = (self._named[-2], self._named[-1])
            self._named[-2:] = []
            self._places.append(Place("between", pair))
        self._describes = False
        self._signs.discard("other_side")
        self._joined = ""

    def _found(self, thing: Thing, number: int) -> None:
        self._pass(self._named)
        self._named = []
        self._place_target()
        if not thing.look or not thing.colour:
            later = self._described_later(number)
            thing = replace(thing, look=thing.look or later.look, colour=thing.colour or later.colour)
        if "there" in self._signs and not self._where and self._said and self._said[-1].kind not in GROUND:
            self._where.append(Where("near", (self._said[-1],)))
        self._target = thing
        self._side = ""

    def _described_later(self, number: int) -> NounPhrase:
        """Return what is said of the target after it: "the ball over there, the striped one"."""
        for chunk in self.chunks[number + 1 :]:
            if chunk.kind in ("stop", "not"):
                break
            if chunk.kind == LOOK:
                return NounPhrase("", look=chunk.value)
            if self._is_collectible(chunk):
                return chunk.things[0] if chunk.things[0].kind == "" else NounPhrase("")
        return NounPhrase("")

    def _pass_over(self, number: int, thing: Thing) -> int:
        """Skip what is said of an object that is not to be picked up."""
        if self._target is None:
            self._pass(self._named)
        self._named, self._places, self._side = [], [], ""
        end = number
        for n, chunk in enumerate(self.chunks[number + 1 :], number + 1):
            if chunk.kind == "stop":
                break
            if chunk.kind == "not" or self._target is not None:
                end = n
        self._said.append(thing)
        return end

    # What stands behind things, verbs and joining words.

    def _word(self, number: int) -> None:
        chunk = self.chunks[number]
        if chunk.kind == "behind":
            self._behind(chunk.value, number)
        elif chunk.kind == "verb":
            self._verb(chunk.value, number)
        elif chunk.kind == "stop":
            self._stop()
        elif chunk.kind in _BOUNDARIES:
            self._join(chunk.kind)
        elif chunk.kind in ("it", "them"):
            self._refer(number)
        elif chunk.kind == "all" and self._named:
            self._named = [replace(each, joined="comma") for each in self._named]
            self._joined = ""
        elif chunk.kind in _SIGNS:
            self._signs.add(chunk.kind)
        elif chunk.kind in ("straight", "ahead") and not self._named:
            if self._is_passing("through_between"):
                self._resolve()
            self._ahead()

    def _join(self, kind: str) -> None:
        is_new = kind == "then" and self._joined in ("comma", "and")
        if not self._joined or kind == "then" or (kind == "comma" and self._joined == "and"):
            # "A then B on the left" is one list, "A, then B on the left" two.
            self._joined = "comma" if kind == "then" and not self._joined else kind
        is_walked = bool(self._places) and self._places[-1].value in ("to", "towards") and self._target is None
        if (is_new and self._is_passing()) or (kind in ("comma", "then") and is_walked):
            self._resolve()
        if kind != "and":
            self._side = ""

    def _is_passing(self, *more: str) -> bool:
        """Return whether what was said last, before the target, is that something is passed."""
        return self._target is None and bool(self._places) and self._places[-1].value in (*PASSED, *more)

    def _refer(self, number: int) -> None:
        """Take what a pronoun means: the last thing, or two, or the last place that one can be in."""
        if self._next(number) != "behind":
            return
        size = 2 if self.chunks[number].kind == "them" else 1
        within = [thing for thing in self._said if thing.kind in GROUND]
        is_in = self.chunks[number + 1].value == "in" and bool(within)
        self._named += [Named(thing, "and", again=True) for thing in (within if is_in else self._said)[-size:]]

    def _behind(self, value: str, number: int) -> None:
        if value == "steps_behind":  # "Turn back from the bank", "behind the bank".
            is_turn = self._verb_after(number) in _MOVING
            self._place("at" if is_turn else "behind")
            if is_turn:
                self._rotate("around")
            return
        value = "at" if value in ("on", "in", "from") else value
        following = self._next(number)
        if value in ("of", "having"):
            side = self.chunks[number + 1] if following == SIDE else None
            if side is not None and side.value in ("left", "right") and self._named:
                self._place(f"{side.value}_of")
                self._relation = number + 1
            else:
                self._describes = following == THING
            return
        if value == "object" or not self._named:
            return
        self._place(value)

    def _verb(self, value: str, number: int) -> None:
        if value in _STANDING:
            self._stands(value)
        elif value == "pass" and self._target is None:
            self._resolve()
            self._pass(self._named)
            self._named = []
        elif value in ("walk", "return"):
            if not self._is_behind(number + 1, "having"):
                self._walk_verb(is_return=value == "return")
        elif value == "back" and self._places and self._places[-1].value == "at":
            self._places.pop()
        elif value in ("turn", "look", "back") and self._places and self._places[-1].value == "towards":
            last = self._places.pop().named[-1]
            self._resolve()
            if value != "back":
                self.steps.append(Face(last.thing))
            elif self._next(number) != SIDE:
                self._rotate("around")
        elif value == "turn_round" or (value == "turn" and "back_again" in self._signs and self._next(number) != SIDE):
            self._rotate("around")

    def _stands(self, value: str) -> None:
        """Take things of which a verb says that they are somewhere, come, are seen or kept on a side."""
        if value == "come" and not (self._named and self._named[-1].side):
            self._signs.add("there")
        if "one_side" in self._signs or not self._named:
            return
        named, self._named = self._named, []
        if self._target is not None:
            self._where += [Where("near", (each.thing,)) for each in named]
        elif "which" in self._signs:
            del self._said[-len(named) :]
        else:
            if value == "be" and self._places and self._places[-1].value == "at" and not named[-1].side:
                named = list(self._places.pop().named)  # "On the building is a flag": it is the building.
            self._resolve()
            self._pass(named[:-1])
            self._pass_beside(named[-1])
            if value == "come" and named[-1].side:
                self._come_beside(named[-1])
            else:
                self._walk("past" if named[-1].side else "until", named[-1])
        self._signs.discard("which")

    def _walk_verb(self, *, is_return: bool) -> None:
        if self._target is not None:
            return
        if (is_return or "back_again" in self._signs) and not self.steps and not self._places:
            self._rotate("around")
        last = self._places[-1] if self._places else None
        self._resolve(reaching=last is not None and last.value in ("at", "near", "in_front_of"))

    def _ahead(self) -> None:
        if self._target is None and (not self.steps or isinstance(self.steps[-1], Rotate)):
            self.steps.append(Walk("ahead"))

    def _stop(self) -> None:
        if self._target is None:
            self._resolve()
            self._pass(self._named)
        else:
            self._place_target()
            self._where += [Where("near", (each.thing,)) for each in self._named]
        self._named, self._joined, self._side = [], "then", ""
        self._describes = False
        self._signs.clear()

    # Steps.

    # Sides.

    def _turn_or_side(self, number: int, chosen: int) -> int:
        """Take a side for a turn, for that of a thing, or for that of the target; return the last chunk explained."""
        chunk, verb = self.chunks[number], self._verb_after(number)
        end = number + (verb in ("turn", "turn_round"))
        if self._target is not None or (self._relation == number and end == number):
            return number
        if chunk.value in _ROUND or verb == "turn_round":
            if verb == "turn_round" or self._is_round(number):
                self._rotate("around")
            return end
        if self._named and not self._joined and verb != "turn":
            return self._side_of_named(number)
        direction = f"slightly {chunk.value}" if chunk.slight else chunk.value
        if verb in _MOVING:
            if not self._is_repeated(direction):
                self._rotate(direction)
            return end
        if self._is_behind(number + 1, "from") and self.steps[-1:] == [Rotate("around")] and not self._named:
            return number  # "Turn around, from the right."
        if verb in _STANDING or (verb == "pass" and not self._places) or self._is_repeated(direction):
            return number
        if self._is_of_target(number, chosen) and not self._is_alone(number + 1, chosen):
            if self._places and self._is_behind(number - 1, "from"):
                self._places[-1] = replace(self._places[-1], value=f"{chunk.value}_of")
            return number
        return self._side_or_turn(number, direction)

    def _is_round(self, number: int) -> bool:
        """Return whether one is to turn around: by a verb of moving, or because nothing else is said."""
        is_whole = self._next(number) in (*_BOUNDARIES, "")
        is_around = self.chunks[number].value == "around"
        return self._verb_after(number) in _MOVING or (
            (is_whole or self._is_first()) if is_around else (is_whole and self._is_first())
        )

    def _is_repeated(self, direction: str) -> bool:
        """Return whether the last turn is only said again ("yes, left")."""
        last = self.steps[-1] if self.steps else None
        return "repeat" in self._signs and isinstance(last, Rotate) and last.direction == direction

    def _side_of_named(self, number: int) -> int:
        """Pass the named things on a side that is said behind them."""
        side, is_coming = self.chunks[number].value, self._verb_after(number) == "come"
        self._resolve()
        if is_coming:
            self._pass(self._named[:-1], side)
            self._come_beside(replace(self._named[-1], side=side))
        else:
            self._pass(self._named, side)
        self._named = []
        return number + is_coming

    def _side_or_turn(self, number: int, direction: str) -> int:
        """Take a side for that of the thing that follows, or else for a turn; return the last chunk explained."""
        side, following = self.chunks[number].value, self._next(number)
        if following == THING and self._named and self._named[-1].side and self._joined == "and":
            self._side = side
        elif following == THING and not self._is_way(number + 1):
            self._resolve()
            self._pass(self._named)
            self._named, self._side = [], side
        elif self._is_behind(number + 1, "of", "having"):
            if self._is_way(number + 2):
                self._rotate(direction)
            else:
                self._side = side
            return number + 1
        else:
            self._rotate(direction)
        return number

    def _is_of_target(self, number: int, chosen: int) -> bool:
        """Return whether a side says where the target is."""
        chunk = self.chunks[number]
        between = [
            each.kind
            for n, each in enumerate(self.chunks[number + 1 : chosen], number + 1)
            if each.kind != SIDE or not self._is_behind(n - 1, "of", "from")
        ]
        if chosen < number or "stop" in between:
            return False
        verbs = [each.value for each in self.chunks[number + 1 : chosen] if each.kind == "verb"]
        if any(value in ("walk", "turn", "pass") for value in verbs) or SIDE in between or "then" in between:
            return False
        if chunk.nominal or chunk.slight:
            return not any(self._is_alone(n, chosen) for n in range(number + 1, chosen))
        if self._places and self._next(number) == "comma" and number + 2 == chosen:
            return True
        if self._next(number) == THING and self.chunks[number + 1].things[0].kind == "street":
            return True  # "On the left pavement."
        return self._next(number) not in _BOUNDARIES and not self._is_way(number + 1)

    def _is_alone(self, number: int, chosen: int) -> bool:
        """Return whether things are named there about which no more is said than on which side they are."""
        if self.chunks[number].kind != THING:
            return False
        after = next((chunk for chunk in self.chunks[number:chosen] if chunk.kind not in (THING, "and")), None)
        return after is not None and after.kind != "behind"

    def _is_way(self, number: int) -> bool:
        """Return whether the thing there is one that is walked to or along, not one that is beside the way."""
        for n in range(number, len(self.chunks)):
            chunk = self.chunks[n]
            if chunk.kind == THING:
                if chunk.things[0].kind in ("street", "alley"):
                    return True
            elif chunk.kind == "behind" and chunk.value not in ("of", "having"):
                return chunk.value in ("to", "towards", "by", "through", "along", "through_between") and (
                    self._closing_verb(n) not in _STANDING
                )
            elif (
                chunk.kind == "and" and n + 1 < len(self.chunks) and self.chunks[n + 1].kind == SIDE
            ) or chunk.kind not in ("and", "behind"):
                return False
        return False

    def _closing_verb(self, number: int) -> str:
        return next((chunk.value for chunk in self.chunks[number:] if chunk.kind in ("verb", "comma", "stop")), "")

    def _is_first(self) -> bool:
        return not self.steps and not self._named and not self._places

    # Looking ahead.

    def _is_behind(self, number: int, *values: str) -> bool:
        """Return whether a chunk is one of these phrases behind a thing."""
        chunk = self.chunks[number] if 0 <= number < len(self.chunks) else None
        return chunk is not None and chunk.kind == "behind" and chunk.value in values

    def _next(self, number: int) -> str:
        return self.chunks[number + 1].kind if number + 1 < len(self.chunks) else ""

    def _verb_after(self, number: int) -> str:
        """Return the kind of the verb that follows, whatever adverbs are before it; "" if none does."""
        for chunk in self.chunks[number + 1 :]:
            if chunk.kind not in ("straight", "ahead", "there", "back_again", "then", "yours"):
                return chunk.value if chunk.kind == "verb" else ""
        return ""
