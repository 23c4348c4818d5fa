"""Steps of a route as the preposition parser adds them, one phrase at a time; `route_parser.py` decides which."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from arramon_lang.meaning import Rotate, Step, Thing, Walk
from arramon_lang.reading.chunks.prepositions.phrases import ListedThing, Phrase
from arramon_lang.reading.chunks.rules import ChunkRules
from arramon_lang.reading.discourse import CROSSED_KINDS, POINT_KINDS


@dataclass(slots=True)
class StepBuilder:
    """Steps of a route so far. Unlike a `RouteDraft`, it keeps nothing open: each phrase is complete when it is added.

    Attributes:
        rules: meanings of the language's relations and verbs.
        steps: steps in order.
        last: the last thing passed or reached.
        last_at: position relative to that thing, as in `Rotate.at`.
    """

    rules: ChunkRules
    steps: list[Step] = field(default_factory=list)
    last: Thing | None = None
    last_at: str = "at"

    def walk(self, phrase: Phrase) -> None:
        """Add walks to, along or past the things of a phrase, according to its relation."""
        value, named = phrase.value, phrase.named
        if value == "between" and len(named) > 1:
            self.steps.append(Walk("between", (named[0].thing, named[1].thing)))
            value, named = "past", named[2:]
        for each in named:
            self._walk_to(value, each)
            if value != "with" or not each.side:
                self.last, self.last_at = each.thing, "before" if value == "before" else "at"

    def pass_all(self, named: Sequence[ListedThing]) -> None:
        """Add walks past things."""
        for each in named:
            self._walk_to("past", each)
            self.last, self.last_at = each.thing, "at"

    def ahead(self) -> None:
        """Add a walk straight on, unless the last step is a walk."""
        if not self.steps or isinstance(self.steps[-1], Rotate):
            self.steps.append(Walk("ahead"))

    def rotate(self, direction: str, at: str = "", thing: Thing | None = None) -> None:
        """Add a turn on the spot, at a thing, or into a street; at a counted street ("the second street")."""
        if thing is not None and thing.kind in ("street", "alley") and not thing.which:
            self.steps += [Rotate(direction), Walk("along", (thing,))]
        else:
            self.steps.append(Rotate(direction, at if thing is not None else "", thing))

    def rotate_there(self, direction: str) -> None:
        """Add a turn at the last thing passed or reached."""
        last = self.steps[-1] if self.steps else None
        if isinstance(last, Walk) and last.way in ("to", "until") and last.things == (self.last,):
            if self.last_at == "at":
                self.rotate(direction)
                return
            self.steps.pop()  # "Not quite to the crossing. Left there."
        self.rotate(direction, self.last_at, self.last)

    def rotate_around(self) -> None:
        """Add a turn around, unless the last step is one."""
        if self.steps[-1:] != [Rotate("around")]:
            self.steps.append(Rotate("around"))

    def set_side(self, side: str) -> None:
        """Set the side of the last walk's thing."""
        last = self.steps[-1] if self.steps else None
        if isinstance(last, Walk) and last.things and not last.side:
            self.steps[-1] = replace(last, way="past" if last.way in ("to", "until") else last.way, side=side)

    def _walk_to(self, value: str, named: ListedThing) -> None:
        kind, thing = named.thing.kind, named.thing
        turn = self.steps[-1] if self.steps else None
        is_counted = kind in ("street", "alley") and bool(thing.which)
        if is_counted and value in ("into", "on") and isinstance(turn, Rotate) and turn.thing is None:
            self.steps[-1] = replace(turn, at="at", thing=thing)  # "Turn left into the second street."
            return
        way = self.rules.walks.get(value, "to" if self.rules.is_in(value, "reached") else "past")
        if kind == "street":
            thing = replace(thing, which="")
        if kind in ("street", "alley") and value not in ("over", "out_of") and way != "towards":
            way = "along"
        elif way == "along" and (kind in POINT_KINDS or value != "along"):
            way = "to" if kind in POINT_KINDS and value != "along" else "past"
        side = "" if kind in CROSSED_KINDS and value != "until" else named.side
        if value == "keep" and self._is_last(thing):
            self.set_side(side)
            return
        if side and way in ("to", "until"):
            way = "past" if way == "to" else "beside"
        if way == "along" and kind == "alley" and Walk("along", (thing,)) in self.steps[-3:]:
            return  # "Into the lane between the houses. Follow it."
        last = self.steps[-1] if self.steps else None
        is_meanwhile = value == "with" and bool(side) and isinstance(last, Walk) and last.way in ("to", "until")
        self.steps.insert(len(self.steps) - is_meanwhile, Walk(way, (thing,), side))

    def _is_last(self, thing: Thing) -> bool:
        last = self.steps[-1] if self.steps else None
        return isinstance(last, Walk) and last.things == (thing,)
