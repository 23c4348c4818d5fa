"""Navigation instructions read by chunks: what is passed and reached, turns, and where the object to pick up is."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from lang.chunks import LOOK, SIDE, THING, Chunk
from lang.discourse import Discourse
from lang.grammar import Grammar
from lang.meaning import Face, Navigation, Rotate, Step, Thing, Walk, Where
from lang.noun_phrases import NounPhrase, NounPhraseReader

_BOUNDARIES = ("comma", "then", "stop", "and")

_GROUND = ("street", "alley", "square")

_POINTS = ("intersection", "t_junction", "corner", "zebra_crossing", "street_end")
"""Kinds of places on the way that are told apart by what is at them: "the crossing by the bank" passes the bank too."""

_ROUND = ("around", "back")

_FACADES = ("building", "awning", "shop_sign", "wall")
"""Kinds of things that something stands in front of, where of others it is said to be beyond them."""

_PASSED = ("by", "through", "beyond", "after")
"""Phrases that say of all things that are listed before them that they are passed."""

_ATS = {"before": "before", "after": "after", "beyond": "after", "through": "after", "behind": "after"}
"""Where a turn is made that follows such a phrase; otherwise at the thing."""

_WHERES = {
    "at": "near", "near": "near", "in_front_of": "in_front_of", "before": "in_front_of", "behind": "behind",
    "between": "between", "on_top_of": "on_top_of", "left_of": "left_of", "right_of": "right_of", "along": "near",
    "against": "near",
    "diagonal": "diagonal_to",
}  # fmt: skip
"""Relations of the target that phrases name; the others say that something has been passed or reached."""

_SIGNS = ("there", "back_again", "which", "one_side", "other_side", "repeat", "until")
"""Words that change what the next chunks mean."""

_MOVING = ("turn", "turn_round", "walk", "return", "become", "look")
"""Verbs that make a side a turn."""


@dataclass(slots=True)
class _Named:
    """A thing that has been named, and what is said of it before the phrase or the verb that it belongs to.

    Attributes:
        joined: what stands between it and the one before: "", "and", "comma" or "then".
        side: "left" or "right" if said before it.
        at: things that tell it apart ("the crossing by the bank"), passed as well.
        again: whether a pronoun names it.
    """

    thing: Thing
    joined: str
    side: str = ""
    at: tuple["_Place", ...] = ()
    again: bool = False


@dataclass(frozen=True, slots=True)
class _Place:
    """Things and the phrase behind them, of which what follows says whether they are passed, turned at or beside."""

    value: str
    named: tuple[_Named, ...]


@dataclass(slots=True)
class RouteReader:
    """Reads one text's chunks.

    Attributes:
        chunks: of the text.
        grammar: of the language.
        noun_phrases: its reader, which knows what can be picked up.
    """

    chunks: Sequence[Chunk]
    grammar: Grammar
    noun_phrases: NounPhraseReader
    steps: list[Step] = field(default_factory=list)
    _named: list[_Named] = field(default_factory=list)
    _places: list[_Place] = field(default_factory=list)
    _where: list[Where] = field(default_factory=list)
    _said: list[Thing] = field(default_factory=list)
    _joined: str = "then"
    _side: str = ""
    _describes: bool = False
    _signs: set[str] = field(default_factory=set)
    _target: Thing | None = None
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
        return self.chunks[number + 1].value in ("of", "having", "object")

    def _add(self, thing: Thing) -> None:
        at: tuple[_Place, ...] = ()
        if self._describes and self._named:
            size = self._joined_size() if thing.kind in _POINTS else 1
            at = (_Place("near", tuple(self._named[-size:])),)
            del self._named[-size:]
        elif self._describes and self._places:
            at = (self._places.pop(),)
        shown = at[0].named[0].thing if at else thing
        is_shop = thing.kind in ("building", "shop_sign") and shown.kind == "shop_sign" and bool(shown.look)
        if at and (is_shop or (thing.kind == "corner" and shown.kind in ("building", "shop_sign"))):
            thing, at = shown, ()  # The building with the cinema's sign, or the cinema's corner: the cinema.
        self._named.append(_Named(thing, self._joined, self._side, at))
        self._said.append(thing)
        if "other_side" in self._signs and len(self._named) > 1:
            self._signs.discard("one_side")
            pair = (self._named[-2], self._named[-1])
            self._named[-2:] = []
            self._places.append(_Place("between", pair))
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
        if "there" in self._signs and not self._where and self._said and self._said[-1].kind not in _GROUND:
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
            if not self._joined or chunk.kind == "then":
                # "A then B on the left" is one list, "A, then B on the left" two.
                self._joined = "comma" if chunk.kind == "then" and not self._joined else chunk.kind
            if chunk.kind == "then" and self._target is None and self._places and self._places[-1].value in _PASSED:
                self._resolve()
            if chunk.kind != "and":
                self._side = ""
        elif chunk.kind == "it" and self._next(number) == "behind" and self.chunks[number + 1].value == "in":
            within = [thing for thing in self._said if thing.kind in _GROUND]
            self._named += [_Named(thing, "and", again=True) for thing in (within or self._said)[-1:]]
        elif chunk.kind in ("it", "them") and self._said and self._next(number) == "behind":
            self._named += [
                _Named(thing, "and", again=True) for thing in self._said[-2 if chunk.kind == "them" else -1 :]
            ]
        elif chunk.kind == "all" and self._named:
            self._named = [replace(each, joined="comma") for each in self._named]
            self._joined = ""
        elif chunk.kind in _SIGNS:
            self._signs.add(chunk.kind)
        elif chunk.kind in ("straight", "ahead") and not self._named:
            if self._places and self._places[-1].value in (*_PASSED, "through_between") and self._target is None:
                self._resolve()
            self._ahead()

    def _behind(self, value: str, number: int) -> None:
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

    def _place(self, value: str) -> None:
        """Take the last named things for a place; those that are listed before them are passed."""
        size = 2 if value in ("between", "through_between") else self._joined_size()
        if value in _PASSED:
            size = len(self._named)
        listed, self._named = self._named[:-size], self._named[-size:]
        if listed:
            self._resolve()
            self._pass(listed)
        self._places.append(_Place(value, tuple(self._named)))
        self._named = []
        self._joined = ""

    def _joined_size(self) -> int:
        size = 1
        while size < len(self._named) and self._named[-size].joined == "and":
            size += 1
        return size

    def _verb(self, value: str, number: int) -> None:
        if value in ("see", "be", "keep", "place") and "one_side" in self._signs:
            return
        is_coming = value == "come"
        if is_coming:
            if not (self._named and self._named[-1].side):
                self._signs.add("there")
            value = "see"
        if value in ("see", "be", "keep", "place") and self._named:
            if self._target is not None:
                self._where += [Where("near", (each.thing,)) for each in self._named]
            elif "which" in self._signs:
                del self._said[-len(self._named) :]
            elif value == "be" and self._places and self._places[-1].value == "at" and not self._named[-1].side:
                self._named = list(self._places.pop().named)  # "On the building is a flag": it is the building.
                self._verb(value, number)
            else:
                self._resolve()
                self._pass(self._named[:-1])
                last = self._named[-1]
                self._pass_beside(last)
                if is_coming and last.side:
                    self._come_beside(last)
                else:
                    self._walk("past" if last.side else "until", last)
            self._named = []
            self._signs.discard("which")
        elif value == "pass" and self._target is None:
            self._resolve()
            self._pass(self._named)
            self._named = []
        elif value in ("walk", "return"):
            if self._next(number) == "behind" and self.chunks[number + 1].value == "having":
                return
            if value == "return" and not self.steps and not self._places:
                self._rotate("around")
            self._walk_verb()
        elif value in ("turn", "look", "back") and self._places and self._places[-1].value == "towards":
            last = self._places.pop().named[-1]
            self._resolve()
            if value != "back":
                self.steps.append(Face(last.thing))
            elif self._next(number) != SIDE:
                self._rotate("around")
        elif value == "turn_round" or (value == "turn" and "back_again" in self._signs and self._next(number) != SIDE):
            self._rotate("around")

    def _walk_verb(self) -> None:
        if self._target is not None:
            return
        if "back_again" in self._signs and not self.steps and not self._places:
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

    def _walk(self, way: str, named: _Named) -> None:
        if named.thing.kind != "street" or way == "past":
            self.steps.append(Walk(way, (named.thing,), named.side))

    def _pass(self, named: Sequence[_Named], side: str = "") -> None:
        begins = max((n for n, each in enumerate(named) if each.joined == "then"), default=0)
        for number, each in enumerate(named):
            self._pass_beside(each, side)
            if each.thing.kind == "street":
                continue
            last = self._last_walks(1)
            if (
                each.thing.kind not in _POINTS
                and last
                and last[0].way == "past"
                and each.thing.is_same(last[0].things[0])
            ):
                continue
            if each.again and any(step == Walk("past", (each.thing,), step.side) for step in self._last_walks(2)):
                continue
            is_sided = number >= begins and (each.thing.kind not in _POINTS or each is named[-1])
            own = each.side or (side if is_sided else "")
            self.steps.append(Walk("past", (each.thing,), own))

    def _last_walks(self, count: int) -> list[Walk]:
        return [step for step in self.steps[-count:] if isinstance(step, Walk)]

    def _pass_beside(self, named: _Named, side: str = "") -> None:
        """Pass what tells a place of the way apart."""
        for place in named.at:
            if place.value == "between" and len(place.named) > 1 and named.thing.kind in ("street", "alley"):
                self.steps.append(Walk("between", tuple(each.thing for each in place.named[:2])))
            elif named.thing.kind in _POINTS:
                self._pass(place.named, side)

    def _resolve(self, *, reaching: bool = False) -> None:
        """Take the places that nothing has been said to happen at for things on the way."""
        for number, place in enumerate(self._places, 1):
            if place.value in ("between", "through_between") and len(place.named) > 1:
                one, other = place.named[:2]
                self.steps.append(Walk("between", (one.thing, other.thing)))
            elif place.value in ("to", "towards", "along"):
                for each in place.named:
                    self._walk_to(place.value, each)
            elif place.value == "before":
                for each in place.named:
                    self._walk("until", each)
            elif reaching and number == len(self._places):
                for each in place.named:
                    self._walk_to("along" if each.thing.kind in _GROUND else "to", each)
            elif place.value == "at" and place.named[-1].thing.kind in _GROUND:
                self._walk_to("along", place.named[-1])
            else:
                self._pass(place.named)
        self._places = []

    def _come_beside(self, named: _Named) -> None:
        if "until" in self._signs and self.steps[-1:] == [Walk("ahead")]:
            self.steps.pop()  # "Go on until it is on your left" is one walk.
        self._walk("beside", named)

    def _walk_to(self, way: str, named: _Named) -> None:
        self._pass_beside(named)
        self._walk(way, named)

    def _place_target(self) -> None:
        """Take the places that are open for those of the target."""
        last = self._places[-1] if self._places else _Place("", ())
        for place in self._places:
            things = tuple(each.thing for each in place.named)
            relation = _WHERES.get(place.value)
            if (
                place.value == "beyond"
                and (place is last or last.named[0].thing.kind in ("corner", "street"))
                and things[-1].kind in _FACADES
            ):
                relation = "in_front_of"
            if relation is None:
                self._places = [place]
                if self._target is None:
                    self._resolve()
                continue
            about = [things[:2]] if relation == "between" and len(things) > 1 else [(thing,) for thing in things]
            relation = "near" if relation == "between" and len(things) < 2 else relation
            for each in about:
                if each[0].kind == "square" and self._target is None:
                    self.steps.append(Walk("to", each))
                elif each[0].kind == "alley" and self._target is None:
                    self.steps.append(Walk("along", each))
                elif each[0].kind != "street":
                    self._where.append(Where(relation, each))
            for named in place.named:
                self._where += [Where("near", (more.thing,)) for at in named.at for more in at.named]
        self._places = []

    # Sides.

    def _turn_or_side(self, number: int, chosen: int) -> int:
        """Take a side for a turn, for that of a thing, or for that of the target; return the last chunk explained."""
        chunk, following = self.chunks[number], self._next(number)
        verb = self._verb_after(number)
        turning = verb in _MOVING
        end = number + (verb in ("turn", "turn_round"))
        if self._target is not None or (self._relation == number and not end > number):
            return number
        if verb == "turn_round":
            self._rotate("around")
            return end
        if chunk.value in _ROUND:
            is_whole = following in (*_BOUNDARIES, "")
            if (
                turning
                or (self._is_first() and is_whole)
                or (chunk.value == "around" and (self._is_first() or is_whole))
            ):
                self._rotate("around")
            return end
        direction = f"slightly {chunk.value}" if chunk.slight else chunk.value
        if self._named and not self._joined and verb != "turn":
            self._resolve()
            if verb == "come":
                self._pass(self._named[:-1], chunk.value)
                self._come_beside(replace(self._named[-1], side=chunk.value))
            else:
                self._pass(self._named, chunk.value)
            self._named = []
            return number + (verb == "come")
        last = self.steps[-1] if self.steps else None
        if "repeat" in self._signs and isinstance(last, Rotate) and last.direction == direction:
            return end
        if turning:
            self._rotate(direction)
            return end
        if verb in ("keep", "place", "be", "see", "come") or (verb == "pass" and not self._places):
            return number
        if self._is_of_target(number, chosen) and not self._is_alone(number + 1, chosen):
            if self._places and self._is_after(number, "from"):
                self._places[-1] = replace(self._places[-1], value=f"{chunk.value}_of")
            return number
        is_paired = bool(self._named) and bool(self._named[-1].side) and self._joined == "and"
        if following == THING and is_paired:
            self._side = chunk.value
            return number
        if following == THING and not self._is_way(number + 1):
            self._resolve()
            self._pass(self._named)
            self._named = []
            self._side = chunk.value
            return number
        if following == "behind" and self.chunks[number + 1].value in ("of", "having"):
            if not self._is_way(number + 2):
                self._side = chunk.value
                return number + 1
            self._rotate(direction)
            return number + 1
        self._rotate(direction)
        return number

    def _is_of_target(self, number: int, chosen: int) -> bool:
        """Return whether a side says where the target is."""
        chunk = self.chunks[number]
        between = [each.kind for each in self.chunks[number + 1 : chosen]]
        if chosen < number or "stop" in between:
            return False
        verbs = [each.value for each in self.chunks[number + 1 : chosen] if each.kind == "verb"]
        if any(value in ("walk", "turn", "pass") for value in verbs) or SIDE in between or "then" in between:
            return False
        if chunk.nominal or chunk.slight:
            return not any(self._is_alone(n, chosen) for n in range(number + 1, chosen))
        if self._places and self._next(number) == "comma" and number + 2 == chosen:
            return True
        return self._next(number) not in _BOUNDARIES and not self._is_way(number + 1)

    def _is_after(self, number: int, value: str) -> bool:
        return number > 0 and self.chunks[number - 1].kind == "behind" and self.chunks[number - 1].value == value

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
                    self._closing_verb(n) not in ("be", "see", "come", "keep", "place")
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

    def _rotate(self, direction: str) -> None:
        self._pass(self._named)
        self._named = []
        place = self._places.pop() if self._places else None
        before = self._said[-1:]
        if place is not None and place.named[-1].thing.kind == "corner" and place.value == "at":
            if self._places and self._places[-1].value in ("after", "beyond", "before", "near", "in_front_of", "at"):
                place = self._places.pop()
            elif "there" in self._signs:
                place, before = None, self._said[-2:-1]
        if place is None:
            self._resolve()
            if "there" in self._signs and before and self.steps:
                self.steps.append(Rotate(direction, "at", before[0]))
            elif not (direction == "around" and self.steps[-1:] == [Rotate("around")]):
                self.steps.append(Rotate(direction))
        elif place.value in ("along", "between"):  # "Turn left along the wall": the wall comes after the turn.
            self._resolve()
            self.steps.append(Rotate(direction))
            self._places.append(place)
            self._resolve()
        elif place.value in ("through_between", "to", "towards"):
            self._places.append(place)
            self._resolve()
            at = place.named[-1].thing
            self.steps.append(Rotate(direction, "at", at) if "there" in self._signs else Rotate(direction))
        else:
            self._resolve()
            last = place.named[-1]
            self._pass(place.named[:-1])
            self._pass_beside(last)
            if last.thing.kind in ("street", "alley") and place.value in ("at", "near", "in_front_of"):
                self.steps += [Rotate(direction), Walk("along", (last.thing,))]
            else:
                self.steps.append(Rotate(direction, _ATS.get(place.value, "at"), last.thing))
        self._signs.discard("there")
        self._joined = "then"

    # Looking ahead.

    def _next(self, number: int) -> str:
        return self.chunks[number + 1].kind if number + 1 < len(self.chunks) else ""

    def _verb_after(self, number: int) -> str:
        """Return the kind of the verb that follows, whatever adverbs are before it; "" if none does."""
        for chunk in self.chunks[number + 1 :]:
            if chunk.kind not in ("straight", "ahead", "there", "back_again", "then", "yours"):
                return chunk.value if chunk.kind == "verb" else ""
        return ""
