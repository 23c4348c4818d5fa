"""Combination of a navigation text's parsed parts into steps and the target."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from arramon_lang.files import BARE
from arramon_lang.meaning import Navigation, Rotate, Step, Thing, Walk, Where
from arramon_lang.reading.discourse import CROSSED_KINDS, GROUND_KINDS, STEPS, Discourse, ParsedPart, bound_things
from arramon_lang.reading.parsed_phrases import NounPhrase

_AROUND = Rotate("around")

_RELATION_OF_POSITION = {"at": "near", "before": "in_front_of", "after": "behind"}

_POSITION_OF_RELATION = {relation: at for at, relation in _RELATION_OF_POSITION.items()}


def read_navigation(discourse: Discourse, items: Sequence[ParsedPart]) -> Navigation:
    """Return the meaning of a navigation instruction: steps in order, and the last target named.

    Before a target is named, bare things are passed ("past the bench, the tree, a cone"); after it, bare things and
    sides say where the target is ("the red mug, left, by the bench").
    """
    itinerary = _Itinerary(discourse)
    for item in _with_shared_sides(items):
        itinerary.add(item)
    return itinerary.navigation()


@dataclass(slots=True)
class _Itinerary:
    """Meaning of the text read so far.

    Attributes:
        discourse: resolves references.
        steps: steps in order.
        targets: objects that a clause says to pick up.
        mentioned: other collectibles.
        places_before: places stated before the target or step that they belong to.
        last: the last part that is a step.
        short_of: the thing just before which the last walk ends.
    """

    discourse: Discourse
    steps: list[Step] = field(default_factory=list)
    targets: list[Thing] = field(default_factory=list)
    mentioned: list[Thing] = field(default_factory=list)
    places_before: tuple[Where, ...] = ()
    last: ParsedPart | None = None
    short_of: Thing | None = None

    def add(self, item: ParsedPart) -> None:
        """Add the content of a parsed part."""
        kind, bound = item.label.split()[0], dict(item.bound)
        listed = self.targets or self.mentioned
        if kind == "all":
            _set_side(self.steps, self.discourse.attribute(bound, "side"))
        elif kind == "short":
            self._add_walk_short_of(item)
        elif listed and (where := self._place_of(item)) is not None:
            listed[-1] = self.discourse.with_where(listed[-1], where)
        elif kind in (*STEPS, "landmark"):
            self._add_steps(item)
        elif item.label == "target same":
            self.targets += [self.discourse.focus] if self.discourse.focus is not None and not listed else []
        elif kind in ("target", "mention") and "target" in bound:
            self._add_target(item, is_first=not listed)
        elif kind == "where":
            self._add_place(item, listed)

    def navigation(self) -> Navigation:
        """Return the steps and the last target; without an explicit target, the last of the best described ones."""
        patterns = self.discourse.grammar.looks["collectible"]
        collectibles = [thing for thing in self.discourse.mentioned_things if thing.look in patterns]
        candidates = self.targets or self.mentioned or collectibles or [Thing("")]
        kinds = [thing for thing in candidates if thing.kind] or candidates
        most = 0 if self.targets else max(map(_count_words, kinds))
        fullest = [thing for thing in kinds if _count_words(thing) >= most]
        return Navigation(tuple(self.steps), self._in_full(fullest[-1], [*collectibles, *self.mentioned]))

    def _add_walk_short_of(self, item: ParsedPart) -> None:
        things = self.discourse.things(bound_things(dict(item.bound), "", is_between=False))
        self.short_of, self.last = things[0], item
        self.steps.append(Walk("towards", things[:1]))

    def _add_steps(self, item: ParsedPart) -> None:
        found = self.discourse.step(item)
        if item.only_read:
            found = _at_place(self.places_before, found)
        turn = found[0] if found else None
        if self.short_of is not None and isinstance(turn, Rotate) and turn.thing is None:
            self.steps[-1:] = [replace(turn, at="before", thing=self.short_of), *found[1:]]
        else:
            self._add_without_repeating(item, found)
        self.places_before, self.last, self.short_of = (), item, None

    def _add_without_repeating(self, item: ParsedPart, found: list[Step]) -> None:
        """Add steps, but merge two turns stated in immediate succession: "go back, turn right around"."""
        last, is_close = self.last, self.last is not None and item.start <= self.last.end + 1
        is_free = item.only_read or (last is not None and last.only_read)
        is_repeated = self.steps[-1:] == [_AROUND] or (is_free and is_close)
        if found[:1] == [_AROUND] and _ends_in_turn(self.steps) and is_repeated:
            self.steps.pop()
        if not (self.steps[-1:] == [_AROUND] and item.only_read and is_close and _ends_in_turn(found)):
            self.steps += found

    def _add_target(self, item: ParsedPart, *, is_first: bool) -> None:
        last = self.last
        if is_first and last is not None and last.only_read and _is_by_side(last):
            self.places_before += _place_of_turn(self.steps, is_place=_is_worded_as_place(last))
        named = self.discourse.with_where(self.discourse.target(dict(item.bound)), self.places_before)
        (self.targets if item.label.startswith("target") else self.mentioned).append(named)
        self.places_before = ()

    def _add_place(self, item: ParsedPart, listed: list[Thing]) -> None:
        placed = dict(item.bound)["where"]
        if listed:
            listed[-1] = self.discourse.with_where(listed[-1], self.discourse.wheres(placed))
        elif item.begins_clause or (item.end - item.start > 1 and _is_of_reader(placed)):
            self.places_before += self.discourse.wheres(placed)

    def _place_of(self, item: ParsedPart) -> tuple[Where, ...] | None:
        """Return the relations that a clause states for a target named before it; None for other clauses."""
        bound = dict(item.bound)
        if item.label == "landmark" or (item.label.startswith("walk past") and item.only_read):
            things = self.discourse.things(bound_things(bound, "", is_between=False))
            return tuple(Where("near", (thing,)) for thing in things if thing.kind not in GROUND_KINDS)
        slight, _, side = self.discourse.attribute(bound, "direction").rpartition(" ")
        about = self.discourse.things(bound_things(bound, "", is_between=False))
        at = item.label.removesuffix(BARE).removeprefix("turn ")
        if item.label.endswith(BARE) and at in _RELATION_OF_POSITION and about:  # "The mug, right before the tree."
            return () if about[0].kind in GROUND_KINDS else (Where(_RELATION_OF_POSITION[at], about[:1]),)
        if item.label == "turn bare" or (item.label == "turn" and slight):
            return (Where(f"{side}_of", (Thing("you"),)),) if side in ("left", "right") else None
        return None

    def _in_full(self, target: Thing, mentions: Sequence[Thing]) -> Thing:
        """Return the target with an earlier mention's colour and look if it states neither ("Pick up the bucket.")."""
        if target.colour or target.look:
            return target
        fuller = [thing for thing in mentions if thing.kind == target.kind and thing.colour]
        return self.discourse.with_where(fuller[-1], target.where) if fuller else target


def _count_words(thing: Thing) -> int:
    return bool(thing.colour) + bool(thing.look)


def _place_of_turn(steps: list[Step], *, is_place: bool) -> tuple[Where, ...]:
    """Remove a turn at the end of the steps and return it as a place: "before the tree, a bit left, is the mug".

    Args:
        steps: steps before the target, modified in place.
        is_place: whether the wording of a right-angle turn also fits a place ("to the left").
    """
    turn = steps[-1] if steps else None
    is_side = isinstance(turn, Rotate) and (turn.direction.startswith("slightly") or (is_place and turn != _AROUND))
    if not isinstance(turn, Rotate) or not is_side:
        return ()
    steps.pop()
    at = () if turn.thing is None else (Where(_RELATION_OF_POSITION[turn.at], (turn.thing,)),)
    return (*at, Where(f"{turn.direction.rpartition(' ')[2]}_of", (Thing("you"),)))


def _at_place(places: tuple[Where, ...], steps: list[Step]) -> list[Step]:
    """Return steps, at the places stated before them: "at the bank, where it opens up, go left"."""
    stated = [where for where in places if where.relation in _POSITION_OF_RELATION and where.things[0].kind != "you"]
    if not stated:
        return steps
    *others, last = stated
    walks: list[Step] = [Walk("past" if each.relation == "behind" else "to", each.things) for each in others]
    if steps and isinstance(steps[0], Rotate) and steps[0].thing is None and steps[0] != _AROUND:
        return [*walks, replace(steps[0], at=_POSITION_OF_RELATION[last.relation], thing=last.things[0]), *steps[1:]]
    return [*walks, Walk("past" if last.relation == "behind" else "to", last.things), *steps]


def _with_shared_sides(items: Sequence[ParsedPart]) -> list[ParsedPart]:
    """Return the parts, with the side of the last thing given to all of a list of three or more bare things."""
    found = list(items)
    for last, item in enumerate(items):
        side = [value for value in item.bound if value[0] == "side"]
        first = last
        while first > 0 and items[first].joined and items[first].label == items[first - 1].label == "landmark":
            first -= 1
        is_list = first < last - 1 and not (items[first].joined and items[first - 1].label.startswith("walk"))
        if side and is_list and not any(slot == "side" for each in items[first:last] for slot, _ in each.bound):
            found[first:last] = [
                each if _is_crossed(each) else replace(each, bound=(*each.bound, *side)) for each in items[first:last]
            ]
    return found


def _is_crossed(item: ParsedPart) -> bool:
    """Return whether a clause names something that is crossed, which has no side."""
    return any(isinstance(named, NounPhrase) and named.kind in CROSSED_KINDS for _, named in item.bound)


def _set_side(steps: list[Step], side: str) -> None:
    """Give a side to all things passed last."""
    for number in range(len(steps) - 1, -1, -1):
        step = steps[number]
        if not isinstance(step, Walk) or step.way != "past" or step.side:
            return
        if not any(thing.kind in CROSSED_KINDS for thing in step.things):
            steps[number] = replace(step, side=side)


def _ends_in_turn(steps: Sequence[Step]) -> bool:
    """Return whether the last step is a turn on the spot."""
    return bool(steps) and isinstance(steps[-1], Rotate) and steps[-1].thing is None


def _is_worded_as_place(item: ParsedPart) -> bool:
    """Return whether a turn without a verb is worded like a place: "to the left", not "left"."""
    return item.label == "turn" + BARE and item.end - item.start >= len(("to", "the", "left"))


def _is_of_reader(placed: object) -> bool:
    """Return whether all relations are to the reader: "on your left"."""
    assert isinstance(placed, tuple)
    return all(thing.kind == "you" for where in placed for thing in where.things)


def _is_by_side(item: ParsedPart) -> bool:
    """Return whether a part is a turn that states only a side, without a turning verb of its own ("bear left")."""
    return item.label.startswith("turn") and "bearing" not in dict(item.bound)
