"""Agreement of two accounts of a text's meaning: a parsed meaning, and one that an annotator wrote down.

The measure compares what two careful people who read one text would both write down, and no more; its tolerances
follow from a comparison of two independent accounts of 20 texts (`data/second_meanings.jsonl`). An account of a
navigation is brought to one form: what is passed or reached, in order, divided by the turns, and the target with what
stands around it. Then two accounts agree if

- their **turns** are the same, in the same order: "left", "slightly left" and "around" are three directions;
- before each turn the **last thing** is the same, and the turn is made at, before or after it alike: "walk to the bank,
  turn right" and "turn right at the bank" are the same, "walk past the bank, turn right" is another ("after"). A thing
  that is only walked towards, until, along or beside leaves open where the turn is made;
- the **things on the way** are the same ones in the same order, each with the same kind, colour, look and side.
  "Past", "to" and "towards" say the same of a thing where another thing follows it before the next turn. "Between" is
  said of its two things; a turn "at" or "into" a street leads along it. "Straight on" and "along the street" name
  nothing, and are left out, and so is a walk to the target itself;
- the **target** has the same kind, colour and pattern;
- what stands **around the target** is the same. It may be told as passed or reached last, or as a relation:
  "past the phone booth; the ball is there", "the ball behind the phone booth", "near the phone booth". Opposite
  relations differ (before and behind a thing, left and right of it). That the target is "on your right", "straight
  ahead" or "on the road" may be left out, as people do in four of ten cases, but may not be contradicted;
- the one may leave out **one** thing on the way, or around the target, that the other has, and not the other way round:
  of "the crossing with the traffic light" and "the awning of the white building" one notes one thing and another two. A
  thing in another's place is never let pass, nor a missing last thing before a turn.

Two accounts of an assembly agree if turns and object are the same, and all relations. Where the object goes on top of
something, the relations that say where that stands may be left out ("on the dotted bowl near the brick wall"), but
not exchanged for others.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from arramon_lang.meaning import Assembly, Face, Navigation, Rotate, Step, Where
from benchmarks.instructions.names import ComparedName, name_read, name_said

LEFT_OUT = 1
"""Number of things in a navigation that one account may omit."""

_POSITIONS = {"to": {"at"}, "past": {"after"}}
"""Position of the walker after each kind of walk, for the turn that follows; other kinds leave it open."""

_AROUND = {"in_front_of": "before", "behind": "after"}

_BESIDE = {"near", "against", "diagonal_to", "between"}
"""Relations that do not determine the side of the thing on which the target is."""

_OPPOSITE = (
    {"before", "after"}, {"left_of", "right_of"}, {"in_front_of", "behind"}, {"on_top_of", "before"},
    {"on_top_of", "after"}, {"on_top_of", "left_of"}, {"on_top_of", "right_of"},
)  # fmt: skip

_GROUND = ("street", "alley", "square")

_SEEN = ComparedName("you")


@dataclass(frozen=True, slots=True)
class RouteMark:
    """A thing on the way or around the target; two of them for "between".

    Attributes:
        names: one name, or two.
        positions: of the walker or the target to it: "at", "before", "after", other relations; none if left open.
        side: "left" or "right" if said, "" if not, None where no side can be said.
    """

    names: tuple[ComparedName, ...]
    positions: frozenset[str] = frozenset()
    side: str | None = ""

    def is_same(self, other: "RouteMark") -> bool:
        """Return whether both are the same thing, without contradicting sides."""
        sides = self.side, other.side
        if None not in sides and self.side != other.side:
            return False
        return _match(self.names, other.names)

    def contradicts(self, other: "RouteMark") -> bool:
        """Return whether the positions exclude each other."""
        return _are_opposite(self.positions, other.positions)


@dataclass(frozen=True, slots=True)
class ComparedRoute:
    """A navigation in canonical form, for comparison.

    Attributes:
        turns: directions, in order.
        legs: things on the way: before each turn, and after the last one.
        around: things around the target, except those in the last leg.
        target: name of the target.
        seen: relations of the target to the viewer.
    """

    turns: tuple[str, ...]
    legs: tuple[tuple[RouteMark, ...], ...]
    around: tuple[RouteMark, ...]
    target: ComparedName
    seen: frozenset[str]


Relation = tuple[str, tuple[ComparedName, ...]]


def navigation_agrees(meaning: Navigation, said: Mapping[str, Any]) -> bool:
    """Return whether a parsed navigation agrees with a written meaning (see the module's docstring)."""
    return routes_agree(route_read(meaning), route_said(said))


def assembly_agrees(meaning: Assembly, said: Mapping[str, Any]) -> bool:
    """Return whether a parsed assembly agrees with a written meaning (see the module's docstring)."""
    placing = meaning.turns, name_read(meaning.thing), [*_relations_read(meaning.where)]
    return _placings_agree(placing, _placing_said(said))


def accounts_agree(one: Mapping[str, Any], other: Mapping[str, Any]) -> tuple[bool, bool]:
    """Return whether two written meanings of one text agree: of the navigation, of the assembly."""
    return routes_agree(route_said(one), route_said(other)), _placings_agree(_placing_said(one), _placing_said(other))


def route_read(meaning: Navigation) -> ComparedRoute:
    """Return the canonical route of a parsed meaning."""
    return _route(
        [part for step in meaning.steps for part in _parts_read(step)],
        name_read(meaning.target),
        [*_relations_read(meaning.target.where)],
    )


def route_said(said: Mapping[str, Any]) -> ComparedRoute:
    """Return the canonical route of a written meaning."""
    target = said["target"]
    return _route(
        [part for step in said["steps"] for part in _parts_said(step)],
        name_said(target["thing"]),
        [*_relations_said(target["where"])],
    )


def routes_agree(one: ComparedRoute, other: ComparedRoute) -> bool:
    """Return whether two routes agree within the tolerances for two readers of one text."""
    if one.turns != other.turns or not _same_target(one.target, other.target):
        return False
    if _are_opposite(one.seen, other.seen):
        return False
    if not all(map(_turned_alike, one.legs[:-1], other.legs[:-1])):
        return False
    left_out = [(_left_out(one, other)), (_left_out(other, one))]
    return any(count is not None and count <= LEFT_OUT for count in left_out)


def _left_out(full: ComparedRoute, short: ComparedRoute) -> int | None:
    """Return the number of things of `full` missing in `short`, or None if the rest differs."""
    count = 0
    for mine, theirs in zip(full.legs[:-1], short.legs[:-1], strict=True):
        if not _is_within(theirs, mine):
            return None
        count += len(mine) - len(theirs)
    mine, theirs = (*full.legs[-1], *full.around), (*short.legs[-1], *short.around)
    found: list[int] = []
    for mark in theirs:
        index = next(
            (n for n, each in enumerate(mine) if n not in found and each.is_same(mark) and not each.contradicts(mark)),
            None,
        )
        if index is None:
            return None
        found.append(index)
    passed = [n for n in found[: len(short.legs[-1])] if n < len(full.legs[-1])]
    return None if passed != sorted(passed) else count + len(mine) - len(theirs)


def _is_within(short: Sequence[RouteMark], full: Sequence[RouteMark]) -> bool:
    rest = iter(full)
    return all(any(mark.is_same(each) for each in rest) for mark in short)


def _turned_alike(one: Sequence[RouteMark], other: Sequence[RouteMark]) -> bool:
    """Return whether two legs end at the same thing, with a turn in the same place relative to it."""
    if not one or not other:
        return not one and not other
    mine, theirs = one[-1], other[-1]
    is_open = not mine.positions or not theirs.positions
    return mine.is_same(theirs) and (is_open or mine.positions == theirs.positions)


def _same_target(one: ComparedName, other: ComparedName) -> bool:
    patterns = {"dotted", "striped"}
    return one.fits(other) and one.says & patterns == other.says & patterns


def _route(parts: Sequence[RouteMark | str], target: ComparedName, relations: Sequence[Relation]) -> ComparedRoute:
    turns: list[str] = []
    legs: list[list[RouteMark]] = [[]]
    for part in parts:
        if isinstance(part, str):
            turns.append(part)
            legs.append([])
        elif legs[-1] and legs[-1][-1].is_same(part):
            legs[-1][-1] = replace(part, positions=part.positions or legs[-1][-1].positions)
        else:
            legs[-1].append(part)
    legs[-1] = [mark for mark in legs[-1] if not (len(mark.names) == 1 and mark.names[0].fits(target))]
    around: list[RouteMark] = []
    for relation, names in relations:
        if names == (_SEEN,) or (relation == "on_top_of" and names[0].kind in _GROUND):
            continue
        mark = RouteMark(names, frozenset({_AROUND.get(relation, relation)} - _BESIDE), None)
        if not (_merge(mark, legs[-1], replaces=True) or _merge(mark, around, replaces=False)):
            around.append(mark)
    seen = frozenset(relation for relation, names in relations if names == (_SEEN,))
    return ComparedRoute(tuple(turns), tuple(map(tuple, legs)), tuple(around), target, seen)


def _merge(mark: RouteMark, marks: list[RouteMark], *, replaces: bool) -> bool:
    """Add a mark's positions to those of the same thing, or put them in their place; return whether there is one."""
    for n, each in enumerate(marks):
        if each.is_same(mark):
            walked = {"at", "after"} if replaces and mark.positions else set()
            marks[n] = replace(each, positions=(each.positions - walked) | mark.positions)
            return True
    return False


def _parts_read(step: Step) -> Iterator[RouteMark | str]:
    if isinstance(step, Rotate):
        yield from _turn(step.direction, step.at, None if step.thing is None else name_read(step.thing))
    elif isinstance(step, Face):
        yield RouteMark((name_read(step.thing),))
    else:
        yield from _walk(step.way, tuple(map(name_read, step.things)), step.side)


def _parts_said(step: Sequence[Any]) -> Iterator[RouteMark | str]:
    sort, *rest = step
    if sort == "turn":
        direction, at, thing = [*rest, "", ""][:3]
        yield from _turn(direction, at, name_said(thing) if thing else None)
    elif sort == "face":
        yield RouteMark((name_said(rest[0]),))
    else:
        way, things, side = [*rest, "", ""][:3]
        yield from _walk(way, _names_said(things), side)


def _turn(direction: str, at: str, name: ComparedName | None) -> Iterator[RouteMark | str]:
    """Yield a turn and where it is made; one at a street or an alley leads into it."""
    into = name is not None and name.kind in ("street", "alley") and at == "at"
    if name is not None and not into:
        yield RouteMark((name,), frozenset({at}))
    yield direction
    if name is not None and into:
        yield from _walk("along", (name,), "")


def _walk(way: str, names: tuple[ComparedName, ...], side: str) -> Iterator[RouteMark]:
    if len(names) == 2 and names[0].fits(names[1]):
        names = names[:1]
    if names and not (names[0].kind == "street" and way != "past" and not names[0].which):
        yield RouteMark(names, frozenset(_POSITIONS.get(way, ())), side)


def _names_said(said: str | Sequence[str]) -> tuple[ComparedName, ...]:
    return tuple(name_said(name) for name in ([said] if isinstance(said, str) else said) if name)


def _relations_read(wheres: Sequence[Where]) -> Iterator[Relation]:
    for where in wheres:
        yield where.relation, tuple(map(name_read, where.things))


def _relations_said(wheres: Sequence[Sequence[Any]]) -> Iterator[Relation]:
    for relation, things in wheres:
        yield relation, _names_said(things)


def _are_opposite(one: frozenset[str], other: frozenset[str]) -> bool:
    return any({mine, theirs} in _OPPOSITE for mine in one for theirs in other)


def _match(names: Sequence[ComparedName], others: Sequence[ComparedName]) -> bool:
    if len(names) != len(others):
        return False
    return any(all(map(ComparedName.fits, names, order)) for order in (others, others[::-1]))


Placing = tuple[tuple[str, ...], ComparedName, list[Relation]]


def _placing_said(said: Mapping[str, Any]) -> Placing:
    room = said["room"]
    thing = name_said(room["thing"]) if room["thing"] else ComparedName("")
    return tuple(room["turns"]), thing, [*_relations_said(room["where"])]


def _placings_agree(one: Placing, other: Placing) -> bool:
    (turns, thing, relations), (their_turns, their_thing, their_relations) = one, other
    if turns != their_turns or (thing.kind and their_thing.kind and not _same_object(thing, their_thing)):
        return False
    only_mine = [each for each in relations if not any(_same_relation(each, their) for their in their_relations)]
    only_theirs = [each for each in their_relations if not any(_same_relation(each, mine) for mine in relations)]
    if not only_mine and not only_theirs:
        return True
    stacked = any(
        mine[0] == their[0] == "on_top_of" and _same_relation(mine, their)
        for mine in relations
        for their in their_relations
    )
    return stacked and not (only_mine and only_theirs)


def _same_object(one: ComparedName, other: ComparedName) -> bool:
    """Return whether both names fit the carried object. As there is only one, a shorter name is enough."""
    return one.kind == other.kind and (one.says <= other.says or other.says <= one.says)


def _same_relation(one: Relation, other: Relation) -> bool:
    (relation, names), (their_relation, their_names) = one, other
    by_wall = names[0].kind == "building" and {relation, their_relation} == {"near", "against"}
    return (relation == their_relation or by_wall) and _match(names, their_names)
