"""Interpretation of parsed parts in order, with resolution of references such as "it" and "that bench"."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from arramon_client.world import COLLECTIBLES
from arramon_lang.clauses import focus_after, step_of
from arramon_lang.coreference import map_mentions, repeats
from arramon_lang.files import BARE
from arramon_lang.grammar import Grammar
from arramon_lang.meaning import TURNS, Assembly, Face, Rotate, Step, Thing, Walk, Where
from arramon_lang.reading.matching import Bindings
from arramon_lang.reading.outline import PartMeaning
from arramon_lang.reading.parsed_phrases import OWN, PRONOUN, SAME, NounPhrase

STEPS = ("turn", "face", "walk")

GROUND_KINDS = ("street", "alley", "square")
"""Kinds of places that objects lie on."""

POINT_KINDS = ("intersection", "t_junction", "zebra_crossing", "corner", "street_end")
"""Kinds of places that a walk reaches or passes as a point."""

CROSSED_KINDS = ("zebra_crossing", "intersection", "street", "square")
"""Kinds of places that a walk crosses."""


@dataclass(frozen=True, slots=True)
class ParsedPart:
    """An understood part of the text, from word `start` up to but excluding `end`.

    Attributes:
        label: key of the matched pattern.
        bound: values of its slots.
        cost: cost of this part in the segmentation of the text.
        begins_clause: whether a clause may begin there.
        only_read: whether its pattern is only read, never written.
        joined: whether only commas and "and" separate it from the part before.
    """

    end: int
    label: str
    bound: Bindings
    cost: float
    start: int = 0
    begins_clause: bool = False
    only_read: bool = False
    joined: bool = False


def bound_things(bound: Mapping[str, object], kind: str, *, is_between: bool) -> tuple[NounPhrase, ...]:
    """Return the noun phrases of a clause or relation; `kind` is the last word of its key ("same", "you")."""
    if kind in ("you", "corner"):
        return (NounPhrase(kind),)
    if kind == "same":
        other = bound.get("other")
        return (NounPhrase("", reference=PRONOUN), *([other] if isinstance(other, NounPhrase) else []))
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
    """Builder of a meaning from parsed parts, which tracks mentioned things to resolve references."""

    grammar: Grammar
    focus: Thing | None = None
    mentioned_things: list[Thing] = field(default_factory=list)
    named_things: list[Thing] = field(default_factory=list)
    identities: int = 0

    def meanings_of(self, item: ParsedPart) -> tuple[PartMeaning, ...]:
        """Return the content of one part of a navigation instruction: steps, the target, or relations of the target."""
        kind, bound = item.label.split()[0], dict(item.bound)
        if kind in (*STEPS, "landmark"):
            return tuple(self.step(item))
        if kind in ("target", "mention") and "target" in bound:
            return (self.target(bound),)
        return self.wheres(bound["where"]) if "where" in bound else ()

    def mention(self, named: NounPhrase) -> Thing:
        """Return the referent of a noun phrase, and record it as mentioned."""
        thing = self._thing(named)
        self.mentioned_things.append(thing)
        return thing

    def assembly(self, items: Sequence[ParsedPart], *, is_written: bool = False) -> Assembly:
        """Return the meaning of an assembly instruction: turns, the object to place, all relations.

        The object is the one that a clause says to place, or else the first one named that is not a landmark: "There
        is a red bowl; the mug goes on it."

        Args:
            items: parts of the text, in order.
            is_written: whether written patterns cover the text, which then states no relation twice.
        """
        turns: list[str] = []
        named: list[Thing] = []
        placed: list[Thing] = []
        wheres: tuple[Where, ...] = ()
        for item in items:
            bound = dict(item.bound)
            if item.label.startswith("turn"):
                direction = self.attribute(bound, "direction")
                if direction in TURNS:
                    turns.append(direction)
                continue
            about = bound.get("thing", bound.get("target"))
            if isinstance(about, NounPhrase):
                if len(named) == 1:
                    self.focus = named[0]
                thing = self._thing(about)
                if item.label.startswith("place") and not named:
                    placed.append(self.with_where(thing, (), bare=True))
                if not named or not thing.is_same(named[0]):
                    wheres += thing.where if not named else ()
                    named.append(self.with_where(thing, (), bare=True))
                    self.mentioned_things.append(named[-1])
            if "where" in bound:
                if self.focus is None and item.label == "where":
                    self.focus = named[0] if named else None
                if wheres and wheres[-1].things[-1].kind in COLLECTIBLES:
                    self.focus = wheres[-1].things[-1]
                wheres += tuple(map(self._of_last_kinds, self.wheres(bound["where"])))
        wheres = tuple(each for where in wheres for each in _simplified(where, () if is_written else wheres))
        landmarks = [thing for where in wheres for thing in where.things]
        carried = placed or [thing for thing in named if not any(thing.is_same(each) for each in landmarks)]
        thing = next(iter(carried), Thing("") if named and landmarks else next(iter(named), Thing("")))
        meaning = map_mentions(Assembly(tuple(turns), thing, wheres), lambda each: replace(each, number=""))
        assert isinstance(meaning, Assembly)
        return meaning

    def step(self, item: ParsedPart) -> list[Step]:
        """Return a clause's steps, one for each of its things ("past the bench and the cone"); empty if unclear."""
        bound = dict(item.bound)
        direction, side = self.attribute(bound, "direction"), self.attribute(bound, "side")
        words = ("walk past" if item.label == "landmark" else item.label.removesuffix(BARE)).split()
        size = 2 if words[0] == "walk" or (len(words) > 1 and words[0] == "turn") else 1
        key, rest = " ".join(words[:size]), words[size:]
        named = bound_things(bound, "same" if rest in (["same"], ["faced"]) else "", is_between=key == "walk between")
        if len(named) == 2 and not (named[1].kind or named[1].reference):
            named = named[0], replace(named[1], kind=named[0].kind)  # "The glass building and the brick one."
        things = self.things(named)
        if rest == ["crossed"]:
            return [Walk("past", (Thing("street"),))]
        if words[1:2] == ["face"]:
            self.focus = focus_after(things, self.focus)
            self.mentioned_things += things
            return [Rotate(direction), *(Face(thing) for thing in things)]
        if words[1:2] == ["with"]:
            self.focus = focus_after(things, self.focus)
            self.mentioned_things += things
            return [Rotate(direction), *(Walk("along", (thing,)) for thing in things)]
        if key == "face" and rest in (["to"], ["towards"]) and len(things) == 1:
            self.focus, self.mentioned_things = things[0], [*self.mentioned_things, *things]
            return [Face(things[0]), Walk(rest[0], things)]
        if item.label == "landmark":
            things = tuple(thing for thing in things if thing.kind != "street")
        things = tuple(
            self._of_last_kind(thing, CROSSED_KINDS if rest == ["zebra_crossing"] else ()) for thing in things
        )
        if rest in (["to"], ["towards"]) and key == "walk past" and len(things) == 2:
            self.focus, self.mentioned_things = focus_after(things[1:], self.focus), [*self.mentioned_things, *things]
            return [Walk("past", things[:1]), Walk(rest[0], things[1:])]
        each = [things] if key == "walk between" or len(things) < 2 else [(thing,) for thing in things]
        count = int(self.attribute(bound, "count") or 0)
        try:
            steps = [step_of(key, direction, about, side, count) for about in each]
        except (TypeError, ValueError):
            return []
        self.focus = focus_after(things, self.focus)
        self.mentioned_things += things
        return steps

    def _of_last_kind(self, thing: Thing, kinds: tuple[str, ...] = ()) -> Thing:
        """Return a thing, with the kind of the last mentioned thing if it states none ("past a blue one").

        Args:
            thing: as the text describes it.
            kinds: possible kinds, if the clause limits them ("over another one"); empty for any.
        """
        if thing.kind or not (thing.colour or thing.which or thing.look):
            return thing
        mentioned = [each.kind for each in self.mentioned_things if each.kind and (not kinds or each.kind in kinds)]
        return replace(thing, kind=mentioned[-1]) if mentioned else thing

    def _of_last_kinds(self, where: Where) -> Where:
        """Return a relation whose things without a kind have that of the last collectible ("the yellow one")."""
        return replace(where, things=tuple(self._of_last_kind(thing, COLLECTIBLES) for thing in where.things))

    def attribute(self, bound: Mapping[str, object], attribute: str) -> str:
        """Return the value that a clause states for an attribute ("direction"), or ""."""
        for slot, table in self.grammar.tables.items():
            value = bound.get(slot)
            if table.attribute == attribute and isinstance(value, str):
                return value
        return ""

    def target(self, bound: Mapping[str, object]) -> Thing:
        """Return the target that a clause names, with the relations that the clause states."""
        named = bound["target"]
        assert isinstance(named, NounPhrase)
        thing = self._thing(named)
        return self.with_where(thing, self.wheres(bound["where"])) if "where" in bound else thing

    def with_where(self, thing: Thing, wheres: tuple[Where, ...], *, bare: bool = False) -> Thing:
        """Return a thing with additional relations, or with none if `bare`."""
        where = () if bare else (*thing.where, *wheres)
        return replace(thing, where=where)

    def things(self, named: tuple[NounPhrase, ...]) -> tuple[Thing, ...]:
        """Return the referents of noun phrases; equal names refer to two things ("the two benches")."""
        things = tuple(self._thing(each) for each in named)
        if len(things) == 2 and things[0].is_same(things[1]):
            things = (things[0], replace(things[1], identity=self._new_identity(things[1])))
        return things

    def _thing(self, named: NounPhrase) -> Thing:
        """Return the referent of a noun phrase, resolving references to things mentioned before."""
        if named.reference == PRONOUN:
            return self.focus or (self.mentioned_things[-1] if self.mentioned_things else Thing(""))
        if named.reference == SAME:
            last = next((thing for thing in reversed(self.mentioned_things) if thing.kind == named.kind), None)
            if last is None and named.kind == "building":
                last = next((thing for thing in reversed(self.mentioned_things) if thing.kind == "shop_sign"), None)
            if last is not None:
                return last
        if named.reference == OWN:
            owners = [thing for thing in self.mentioned_things if thing.kind in ("building", "shop_sign", "wall")]
            named = replace(named, colour=owners[-1].colour, look=owners[-1].look) if owners else named
        wheres = self.wheres(named.where)
        thing = Thing(named.kind, named.colour, named.look, named.which, wheres, named.number, arms=named.arms)
        return replace(thing, identity=self._identity(thing))

    def _identity(self, thing: Thing) -> str:
        """Return the identity of the earlier thing whose name this repeats, possibly in fewer words, or a new identity.

        "The bench" after "the red bench" is the same thing; "another bench" and "the next bench" are new things.
        """
        for earlier in reversed(self.named_things):
            if repeats(thing, earlier):
                return earlier.identity
        return self._new_identity(thing)

    def _new_identity(self, thing: Thing) -> str:
        self.identities += 1
        self.named_things.append(replace(thing, identity=str(self.identities)))
        return str(self.identities)

    def wheres(self, placed: object) -> tuple[Where, ...]:
        """Return the relations in a clause's slot {where}."""
        assert isinstance(placed, tuple)
        wheres, focus = [], self.focus
        for each in placed:
            wheres.append(Where(each.relation, self.things(each.things), each.exactly))
            self.mentioned_things += wheres[-1].things
            self.focus = focus_after(wheres[-1].things, self.focus)
        self.focus = focus
        return tuple(wheres)


def _simplified(where: Where, wheres: Sequence[Where]) -> Iterator[Where]:
    """Yield a room relation simplified: "between" two walls is "against" both; "near" adds nothing to "left of"."""
    if where.relation == "on_top_of" and where.things[0].kind == "corner":
        yield replace(where, relation="near")
    elif where.relation == "on_top_of" and where.things[0].kind in GROUND_KINDS:
        return  # "On the square before you": a cell.
    elif where.relation == "between" and all(thing.kind == "wall" for thing in where.things):
        yield from (Where("against", (thing,)) for thing in where.things)
    elif where.relation != "near" or not any(_is_beside(each, where) for each in wheres):
        yield where


def _is_beside(where: Where, near: Where) -> bool:
    return where.relation in ("left_of", "right_of", "in_front_of", "behind") and where.things[0].is_same(
        near.things[0]
    )
