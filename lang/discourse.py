"""Interpretation of a text's parsed parts in order, resolving references such as "it" and "that bench"."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from lang.clauses import focus_of, step_of
from lang.grammar import Grammar
from lang.matching import Bindings
from lang.meaning import TURNS, Assembly, Navigation, Rotate, Step, Thing, Walk, Where
from lang.noun_phrases import OWN, PRONOUN, SAME, NounPhrase
from lang.outline import Part
from lang.reference import map_mentions, repeats

BARE = " bare"
"""Ends the key of a clause without a verb ("left at the bank"), which begins a clause of the text or is none."""

_STEPS = ("turn", "face", "walk")

_AROUND = Rotate("around")

_AT = {"at": "near", "before": "in_front_of", "after": "behind"}

_PLACED = {relation: at for at, relation in _AT.items()}

_GROUND = ("street", "alley", "square")
"""Kinds of things that objects lie on."""

_COLLECTIBLES = ("ball", "hourglass", "mug", "tv", "book", "bowl", "bucket")

_CROSSED = ("zebra_crossing", "intersection", "street", "square")
"""Kinds of things that one goes over."""


@dataclass(frozen=True, slots=True)
class Item:
    """A part of the text that was understood, from `start` up to but excluding `end`.

    Attributes:
        fresh: whether a clause may begin there.
        also: whether its pattern is only read.
        joined: whether only a comma or "and" stands before it.
    """

    end: int
    label: str
    bound: Bindings
    cost: float
    start: int = 0
    fresh: bool = False
    also: bool = False
    joined: bool = False


def things_in(bound: Mapping[str, object], kind: str, *, is_between: bool) -> tuple[NounPhrase, ...]:
    """Return the things of a clause or relation; `kind` is the rest of its key ("same", "you")."""
    if kind in ("same", "you", "corner"):
        return (NounPhrase("", back=PRONOUN) if kind == "same" else NounPhrase(kind),)
    things = tuple(
        bound[slot]
        for slot in ("thing", "landmark", "holder", "pair", "several", "other", "further", "wall")
        if slot in bound
    )
    if is_between and "pair" in bound:
        things = 2 * tuple(replace(each, number="") for each in things if isinstance(each, NounPhrase))
    joined = bound.get("joined")
    if isinstance(joined, tuple):
        things = joined
    return tuple(thing for thing in things if isinstance(thing, NounPhrase))


@dataclass(slots=True)
class Discourse:
    """Combines parsed items into a meaning, keeping track of the things mentioned to resolve references."""

    grammar: Grammar
    focus: Thing | None = None
    mentioned_things: list[Thing] = field(default_factory=list)
    named_things: list[Thing] = field(default_factory=list)
    identities: int = 0

    def navigation(self, items: Sequence[Item]) -> Navigation:
        """Return the meaning of a navigation instruction: steps in order, and the last target that is named.

        Before a target is named, things by themselves are passed ("past the bench, the tree, a cone"); after it they
        say where it is, and so do sides ("the red mug, left, by the bench").
        """
        steps: list[Step] = []
        targets: list[Thing] = []
        mentioned: list[Thing] = []
        before: tuple[Where, ...] = ()
        last: Item | None = None
        short_of: Thing | None = None
        for item in _with_shared_sides(items):
            kind, bound = item.label.split()[0], dict(item.bound)
            listed = targets or mentioned
            if kind in ("not", "detail"):
                continue
            if kind == "all":
                _put_aside(steps, self._attribute(bound, "side"))
                continue
            if kind == "short":
                short_of = next(iter(self._things(things_in(bound, "", is_between=False))), None)
                steps += [Walk("towards", (short_of,))] if short_of is not None else []
                last = item
                continue
            if listed and (where := self._place_of(item)) is not None:
                listed[-1] = self._with(listed[-1], where)
            elif kind in (*_STEPS, "landmark"):
                if short_of is not None and item.label.removesuffix(BARE) == "turn":
                    steps[-1:] = [Rotate(self._attribute(bound, "direction"), "before", short_of)]
                    last, short_of = item, None
                    continue
                short_of = None
                found = _at_place(before, self._step(item)) if item.also else self._step(item)
                if found[:1] == [_AROUND] and _on_the_spot(steps) and (steps[-1] == _AROUND or item.also or last.also):
                    steps.pop()  # "Go back, turn right around": one turn, said twice.
                if not (steps[-1:] == [_AROUND] and item.also and _on_the_spot(found)):
                    steps += found
                before, last = (), item
            elif item.label == "target same":
                targets += [self.focus] if self.focus is not None and not listed else []
            elif kind in ("target", "mention") and "target" in bound:
                if not listed and last is not None and last.also and _is_by_side(last):
                    before += self._place_of_turn(steps)
                named = self._with(self._target(bound), before)
                (targets if kind == "target" else mentioned).append(named)
                before = ()
            elif kind == "where" and listed:
                listed[-1] = self._with(listed[-1], self._wheres(bound["where"]))
            elif kind == "where" and (item.fresh or (item.end - item.start > 1 and _is_of_reader(bound["where"]))):
                before += self._wheres(bound["where"])
        collectibles = [thing for thing in self.mentioned_things if thing.look in self.grammar.looks["collectible"]]
        candidates = targets or mentioned or collectibles or [Thing("")]
        kinds = [thing for thing in candidates if thing.kind] or candidates
        most = max(bool(thing.colour) + bool(thing.look) for thing in kinds) if not targets else 0
        fullest = [thing for thing in kinds if bool(thing.colour) + bool(thing.look) >= most]
        return Navigation(tuple(steps), self._in_full(fullest[-1], [*collectibles, *mentioned]))

    @staticmethod
    def _place_of_turn(steps: list[Step]) -> tuple[Where, ...]:
        """Take away a slight turn at the end and return it as a place: "before the tree, a bit left, is the mug"."""
        turn = steps[-1] if steps else None
        if not isinstance(turn, Rotate) or not turn.direction.startswith("slightly"):
            return ()
        steps.pop()
        at = () if turn.thing is None else (Where(_AT[turn.at], (turn.thing,)),)
        return (*at, Where(f"{turn.direction.rpartition(' ')[2]}_of", (Thing("you"),)))

    def _place_of(self, item: Item) -> tuple[Where, ...] | None:
        """Return what a clause says of where the target is, that has been named before it; None if it is none such."""
        bound = dict(item.bound)
        if item.label == "landmark" or (item.label.startswith("walk past") and item.also):
            things = self._things(things_in(bound, "", is_between=False))
            return tuple(Where("near", (thing,)) for thing in things if thing.kind not in _GROUND)
        slight, _, side = self._attribute(bound, "direction").rpartition(" ")
        about = self._things(things_in(bound, "", is_between=False))
        if item.label.endswith(BARE) and item.label.split()[:2] in (["turn", "before"], ["turn", "after"]) and about:
            return (Where(_AT[item.label.split()[1]], about[:1]),)  # "The mug, right before the tree."
        if item.label == "turn bare" or (item.label == "turn" and slight):
            return (Where(f"{side}_of", (Thing("you"),)),) if side in ("left", "right") else None
        return None

    def part(self, item: Item) -> tuple[Part, ...]:
        """Return what one item of a navigation instruction says: steps, the object to pick up, or its relations."""
        kind, bound = item.label.split()[0], dict(item.bound)
        if kind in (*_STEPS, "landmark"):
            return tuple(self._step(item))
        if kind in ("target", "mention") and "target" in bound:
            return (self._target(bound),)
        return self._wheres(bound["where"]) if "where" in bound else ()

    def mention(self, named: NounPhrase) -> Thing:
        """Return the thing that a noun phrase means which stands alone."""
        thing = self._thing(named)
        self.mentioned_things.append(thing)
        return thing

    def _in_full(self, target: Thing, said: Sequence[Thing]) -> Thing:
        """Return the target with colour and look from an earlier mention if it lacks both ("Pick up the bucket.")."""
        if target.colour or target.look:
            return target
        fuller = [thing for thing in said if thing.kind == target.kind and thing.colour]
        return self._with(fuller[-1], target.where) if fuller else target

    def assembly(self, items: Sequence[Item]) -> Assembly:
        """Return the meaning of an assembly instruction: turns, the object to place, all relations.

        The object is the one that a clause says to place, or else the first that is named and is no landmark: "There is
        a red bowl; the mug goes on it."
        """
        turns: list[str] = []
        named: list[Thing] = []
        placed: list[Thing] = []
        wheres: tuple[Where, ...] = ()
        for item in items:
            bound = dict(item.bound)
            if item.label.startswith("turn"):
                direction = self._attribute(bound, "direction")
                if direction in TURNS:
                    turns.append(direction)
                continue
            about = bound.get("thing", bound.get("target"))
            if isinstance(about, NounPhrase):
                if len(named) == 1:
                    self.focus = named[0]
                thing = self._thing(about)
                if item.label.startswith("place") and not named:
                    placed.append(self._with(thing, (), bare=True))
                if not named or not thing.is_same(named[0]):
                    wheres += thing.where if not named else ()
                    named.append(self._with(thing, (), bare=True))
                    self.mentioned_things.append(named[-1])
            if "where" in bound:
                if self.focus is None and item.label == "where":
                    self.focus = named[0] if named else None
                if wheres and wheres[-1].things[-1].kind in _COLLECTIBLES:
                    self.focus = wheres[-1].things[-1]
                wheres += tuple(map(self._of_last_kinds, self._wheres(bound["where"])))
        wheres = tuple(each for where in wheres for each in _plainly(where, wheres))
        landmarks = [thing for where in wheres for thing in where.things]
        carried = placed or [thing for thing in named if not any(thing.is_same(each) for each in landmarks)]
        thing = next(iter(carried), Thing("") if named and landmarks else next(iter(named), Thing("")))
        meaning = map_mentions(Assembly(tuple(turns), thing, wheres), lambda each: replace(each, number=""))
        assert isinstance(meaning, Assembly)
        return meaning

    def _step(self, item: Item) -> list[Step]:
        """Return a clause's step, one for each of its things ("past the bench and the cone"), or none if unclear."""
        bound = dict(item.bound)
        direction, side = self._attribute(bound, "direction"), self._attribute(bound, "side")
        words = ("walk past" if item.label == "landmark" else item.label.removesuffix(BARE)).split()
        size = 2 if words[0] == "walk" or (len(words) > 1 and words[0] == "turn") else 1
        key, rest = " ".join(words[:size]), words[size:]
        named = things_in(bound, "same" if rest == ["same"] else "", is_between=key == "walk between")
        if len(named) == 2 and not (named[1].kind or named[1].back):
            named = named[0], replace(named[1], kind=named[0].kind)  # "The glass building and the brick one."
        things = self._things(named)
        if rest == ["crossed"]:
            return [Walk("past", (Thing("street"),))]
        if words[1:2] == ["with"]:
            self.focus = focus_of(things, self.focus)
            self.mentioned_things += things
            return [Rotate(direction), *(Walk("along", (thing,)) for thing in things)]
        if item.label == "landmark":
            things = tuple(thing for thing in things if thing.kind != "street")
        things = tuple(self._of_last_kind(thing, _CROSSED if rest == ["zebra_crossing"] else ()) for thing in things)
        each = [things] if key == "walk between" or len(things) < 2 else [(thing,) for thing in things]
        count = int(self._attribute(bound, "count") or 0)
        try:
            steps = [step_of(key, direction, about, side, count) for about in each]
        except (TypeError, ValueError):
            return []
        self.focus = focus_of(things, self.focus)
        self.mentioned_things += things
        return steps

    def _of_last_kind(self, thing: Thing, kinds: tuple[str, ...] = ()) -> Thing:
        """Return a thing of the street, with the kind of the last one if its own is not said ("past a blue one").

        Args:
            thing: as it is named.
            kinds: of which it is, if that is known ("over another one").
        """
        if thing.kind or not (thing.colour or thing.which or thing.look):
            return thing
        said = [each.kind for each in self.mentioned_things if each.kind and (not kinds or each.kind in kinds)]
        return replace(thing, kind=said[-1]) if said else thing

    def _of_last_kinds(self, where: Where) -> Where:
        """Return a relation to things with the kind of the last one where theirs is not said ("the yellow one")."""
        return replace(where, things=tuple(self._of_last_kind(thing, _COLLECTIBLES) for thing in where.things))

    def _attribute(self, bound: Mapping[str, object], attribute: str) -> str:
        for slot, table in self.grammar.tables.items():
            value = bound.get(slot)
            if table.attribute == attribute and isinstance(value, str):
                return value
        return ""

    def _target(self, bound: Mapping[str, object]) -> Thing:
        named = bound["target"]
        assert isinstance(named, NounPhrase)
        thing = self._thing(named)
        return self._with(thing, self._wheres(bound["where"])) if "where" in bound else thing

    def _with(self, thing: Thing, wheres: tuple[Where, ...], *, bare: bool = False) -> Thing:
        where = () if bare else (*thing.where, *wheres)
        return replace(thing, where=where)

    def _things(self, named: tuple[NounPhrase, ...]) -> tuple[Thing, ...]:
        """Return the things that noun phrases mean; two of one name are two things ("the two benches")."""
        things = tuple(self._thing(each) for each in named)
        if len(things) == 2 and things[0].is_same(things[1]):
            things = (things[0], replace(things[1], identity=self._new_identity(things[1])))
        return things

    def _thing(self, named: NounPhrase) -> Thing:
        """Return the thing that a noun phrase means, resolving references to things mentioned before."""
        if named.back == PRONOUN:
            return self.focus or (self.mentioned_things[-1] if self.mentioned_things else Thing(""))
        if named.back == SAME:
            last = next((thing for thing in reversed(self.mentioned_things) if thing.kind == named.kind), None)
            if last is None and named.kind == "building":
                last = next((thing for thing in reversed(self.mentioned_things) if thing.kind == "shop_sign"), None)
            if last is not None:
                return last
        if named.back == OWN:
            owners = [thing for thing in self.mentioned_things if thing.kind in ("building", "shop_sign", "wall")]
            named = replace(named, colour=owners[-1].colour, look=owners[-1].look) if owners else named
        wheres = self._wheres(named.where)
        thing = Thing(named.kind, named.colour, named.look, named.which, wheres, named.number)
        return replace(thing, identity=self._identity(thing))

    def _identity(self, thing: Thing) -> str:
        """Return the identity of an earlier thing that the name repeats, possibly with fewer words, or else a new one.

        "The bench" after "the red bench" is the same one; "another bench" and "the next bench" are new.
        """
        for earlier in reversed(self.named_things):
            if repeats(thing, earlier):
                return earlier.identity
        return self._new_identity(thing)

    def _new_identity(self, thing: Thing) -> str:
        self.identities += 1
        self.named_things.append(replace(thing, identity=str(self.identities)))
        return str(self.identities)

    def _wheres(self, placed: object) -> tuple[Where, ...]:
        assert isinstance(placed, tuple)
        wheres, focus = [], self.focus
        for each in placed:
            wheres.append(Where(each.relation, self._things(each.things), each.exactly))
            self.mentioned_things += wheres[-1].things
            self.focus = focus_of(wheres[-1].things, self.focus)
        self.focus = focus
        return tuple(wheres)


def _plainly(where: Where, wheres: Sequence[Where]) -> Iterator[Where]:
    """Yield what a relation in the room says: the corner of two walls is at both; what is left of a thing is near it."""
    if where.relation == "on_top_of" and where.things[0].kind == "corner":
        yield replace(where, relation="near")
    elif where.relation == "between" and all(thing.kind == "wall" for thing in where.things):
        yield from (Where("against", (thing,)) for thing in where.things)
    elif where.relation != "near" or not any(_is_beside(each, where) for each in wheres):
        yield where


def _is_beside(where: Where, near: Where) -> bool:
    return where.relation in ("left_of", "right_of", "in_front_of", "behind") and where.things[0].is_same(
        near.things[0]
    )


def _at_place(places: tuple[Where, ...], steps: list[Step]) -> list[Step]:
    """Return steps with the places that were told before them: "at the bank, where it opens up, go left"."""
    told = [where for where in places if where.relation in _PLACED and where.things[0].kind != "you"]
    if not told:
        return steps
    *others, last = told
    walks: list[Step] = [Walk("past" if each.relation == "behind" else "to", each.things) for each in others]
    if steps and isinstance(steps[0], Rotate) and steps[0].thing is None and steps[0] != _AROUND:
        return [*walks, replace(steps[0], at=_PLACED[last.relation], thing=last.things[0]), *steps[1:]]
    return [*walks, Walk("past" if last.relation == "behind" else "to", last.things), *steps]


def _with_shared_sides(items: Sequence[Item]) -> list[Item]:
    """Return items where things that are only listed have the side of the last one ("bench, bin, booth on your left")."""
    found = list(items)
    for last, item in enumerate(items):
        side = [value for value in item.bound if value[0] == "side"]
        first = last
        while first > 0 and items[first].joined and items[first].label == items[first - 1].label == "landmark":
            first -= 1
        is_list = first < last and not (items[first].joined and items[first - 1].label.startswith("walk"))
        if side and is_list and not any(slot == "side" for each in items[first:last] for slot, _ in each.bound):
            found[first:last] = [
                each if _is_crossed(each) else replace(each, bound=(*each.bound, *side)) for each in items[first:last]
            ]
    return found


def _is_crossed(item: Item) -> bool:
    """Return whether a clause names something that one goes over, which is on no side."""
    return any(isinstance(named, NounPhrase) and named.kind in _CROSSED for _, named in item.bound)


def _put_aside(steps: list[Step], side: str) -> None:
    """Say of the things passed last that all are on a side."""
    for number in range(len(steps) - 1, -1, -1):
        step = steps[number]
        if not isinstance(step, Walk) or step.way != "past" or step.side:
            return
        if not any(thing.kind in _CROSSED for thing in step.things):
            steps[number] = replace(step, side=side)


def _on_the_spot(steps: Sequence[Step]) -> bool:
    """Return whether the last step is a turn without a place."""
    return bool(steps) and isinstance(steps[-1], Rotate) and steps[-1].thing is None


def _is_of_reader(placed: object) -> bool:
    """Return whether relations are all to who reads them: "look left"."""
    assert isinstance(placed, tuple)
    return all(thing.kind == "you" for where in placed for thing in where.things)


def _is_by_side(item: Item) -> bool:
    """Return whether an item is a turn that says only to which side, not by a verb of its own ("bear left")."""
    return item.label.startswith("turn") and "bearing" not in dict(item.bound)
