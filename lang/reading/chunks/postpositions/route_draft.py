"""Draft of a route: its steps so far, and things and places whose role the text has not yet revealed."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from arramon_lang.meaning import Rotate, Step, Thing, Walk, Where
from arramon_lang.reading.chunks.chunker import THEN
from arramon_lang.reading.chunks.sequence import ChunkSequence
from arramon_lang.reading.discourse import GROUND_KINDS, POINT_KINDS

_BY_CORNER = ("after", "far_side", "beyond", "before", "near", "in_front_of", "at")
"""Relations to a thing at a corner that say more of a turn than the corner does."""

_FACADES = ("building", "awning", "shop_sign", "wall")
"""Kinds of things for which "beyond" means in front of them."""


@dataclass(slots=True)
class PendingThing:
    """A named thing whose postposition or verb has not been read yet.

    Attributes:
        thing: the thing.
        joined: conjunction between it and the thing before: "", "and", "comma" or "then".
        side: "left" or "right" if stated before it.
        at: landmarks that identify it ("the crossing by the bank"), which are passed as well.
        again: whether a pronoun refers to it.
    """

    thing: Thing
    joined: str
    side: str = ""
    at: tuple["PendingPlace", ...] = ()
    again: bool = False


@dataclass(frozen=True, slots=True)
class PendingPlace:
    """Things with their postposition; the following words decide whether they are passed, turned at or landmarks."""

    value: str
    named: tuple[PendingThing, ...]


@dataclass(slots=True, kw_only=True)
class RouteDraft:
    """Steps of a text so far, and things and places whose role is still open.

    Attributes:
        text: chunks of the text.
        steps: steps in order.
    """

    text: ChunkSequence
    steps: list[Step] = field(default_factory=list)
    _pending: list[PendingThing] = field(default_factory=list)
    _places: list[PendingPlace] = field(default_factory=list)
    _where: list[Where] = field(default_factory=list)
    _mentioned: list[Thing] = field(default_factory=list)
    _joined: str = THEN
    _flags: set[str] = field(default_factory=set)
    _target: Thing | None = None

    def _add_place(self, value: str) -> None:
        """Turn the last pending things into a place, and pass those listed before them."""
        size = 2 if value in ("between", "through_between") else self._joined_size()
        if self.text.rules.is_in(value, "passing"):
            size = len(self._pending)
        listed, self._pending = self._pending[:-size], self._pending[-size:]
        if listed:
            self._walk_to_places()
            self._pass(listed)
        is_walk = self.text.rules.is_in(value, "leading", "passing") and value not in self.text.rules.target_relations
        if is_walk and self._pending[0].joined in ("comma", THEN) and self._places and self._target is None:
            self._walk_to_places(reaching=self._is_reached(self._places[-1]))
        self._places.append(PendingPlace(value, tuple(self._pending)))
        self._pending = []
        self._joined = ""

    def _is_passing(self, *more: str) -> bool:
        """Return whether the last place before the target is one that is passed."""
        last = self._places[-1].value if self._places and self._target is None else None
        return last is not None and (last in more or self.text.rules.is_in(last, "passing"))

    def _is_reached(self, place: PendingPlace) -> bool:
        """Return whether a walk ends at a place: "near the tree", "at the bank"."""
        return place.value in ("at", "near", "in_front_of")

    def _joined_size(self) -> int:
        size = 1
        while size < len(self._pending) and self._pending[-size].joined == "and":
            size += 1
        return size

    def _walk(self, way: str, named: PendingThing) -> None:
        if named.thing.kind != "street" or way == "past":
            self.steps.append(Walk(way, (named.thing,), named.side))

    def _pass(self, named: Sequence[PendingThing], side: str = "") -> None:
        begins = max((n for n, each in enumerate(named) if each.joined == THEN), default=0)
        for number, each in enumerate(named):
            self._pass_beside(each, side)
            if each.thing.kind == "street":
                continue
            if self._is_passed(each):
                continue
            is_sided = number >= begins and (each.thing.kind not in POINT_KINDS or each is named[-1])
            own = each.side or (side if is_sided else "")
            self.steps.append(Walk("past", (each.thing,), own))

    def _is_passed(self, named: PendingThing) -> bool:
        """Return whether the last walk already passed the same thing."""
        last = [
            step for step in self.steps[-2 if named.again else -1 :] if isinstance(step, Walk) and step.way == "past"
        ]
        may_be_another = named.thing.kind in POINT_KINDS and not named.again
        return not may_be_another and any(named.thing.is_same(step.things[0]) for step in last)

    def _pass_beside(self, named: PendingThing, side: str = "") -> None:
        """Pass the landmarks that identify a place on the way."""
        for place in named.at:
            if place.value == "between" and len(place.named) > 1 and named.thing.kind in ("street", "alley"):
                self.steps.append(Walk("between", tuple(each.thing for each in place.named[:2])))
            elif named.thing.kind in POINT_KINDS:
                self._pass(place.named, side)

    def _walk_beside(self, named: PendingThing) -> None:
        if "until" in self._flags and self.steps[-1:] == [Walk("ahead")]:
            self.steps.pop()  # "Go on until it is on your left" is one walk.
        self._walk("beside", named)

    def _walk_to(self, way: str, named: PendingThing) -> None:
        self._pass_beside(named)
        self._walk(way, named)

    def _walk_to_places(self, *, reaching: bool = False) -> None:
        """Turn the open places into walks."""
        for number, place in enumerate(self._places, 1):
            way = self.text.rules.walks.get(place.value)
            if place.value in ("between", "through_between") and len(place.named) > 1:
                one, other = place.named[:2]
                self.steps.append(Walk("between", (one.thing, other.thing)))
            elif way == "until":
                for each in place.named:
                    self._walk(way, each)
            elif way is not None:
                for each in place.named:
                    self._walk_to(way, each)
            elif reaching and number == len(self._places):
                for each in place.named:
                    self._walk_to("along" if each.thing.kind in GROUND_KINDS else "to", each)
            elif self._is_turned_into(place):  # "The first street on the left."
                self.steps.append(Rotate(place.named[-1].side, "at", place.named[-1].thing))
            elif place.value == "at" and place.named[-1].thing.kind in GROUND_KINDS:
                self._walk_to("along", place.named[-1])
            else:
                self._pass(place.named)
        self._places = []

    def _is_turned_into(self, place: PendingPlace) -> bool:
        last = place.named[-1]
        return place.value == "at" and last.thing.kind in ("street", "alley") and bool(last.side)

    def _locate_target(self) -> None:
        """Turn the open places into relations of the target."""
        places, self._places = self._places, []
        for place in places:
            relation = self._target_relation(place, places[-1])
            if relation is not None:
                self._relate_target(relation, place.named)
            elif self._target is None:
                self._places = [place]
                self._walk_to_places()

    def _target_relation(self, place: PendingPlace, last: PendingPlace) -> str | None:
        """Return the target's relation to a place, or None if the place is passed or reached."""
        if place.value == "beyond" and place.named[-1].thing.kind in _FACADES:
            return "in_front_of" if place is last or last.named[0].thing.kind in ("corner", "street") else None
        relation = self.text.rules.target_relations.get(place.value)
        if self._target is not None and place.value in ("beyond", "after", "far_side"):
            return "behind"
        return "near" if relation == "between" and len(place.named) < 2 else relation

    def _relate_target(self, relation: str, named: Sequence[PendingThing]) -> None:
        things = tuple(each.thing for each in named)
        for about in [things[:2]] if relation == "between" else [(thing,) for thing in things]:
            if about[0].kind in ("square", "alley") and self._target is None:
                self.steps.append(Walk("to" if about[0].kind == "square" else "along", about))
            elif about[0].kind != "street":
                self._where.append(Where(relation, about))
        more = [each for one in named for at in one.at for each in at.named]
        self._where += [Where("near", (each.thing,)) for each in more]

    def _add_turn(self, direction: str) -> None:
        """Add a turn, at the last place or thing if they say where it is made."""
        self._pass(self._pending)
        self._pending = []
        place, before = self._turning_place()
        self._walk_to_places()
        if place is None:
            if "there" in self._flags and before and self.steps:
                if self.steps[-1] == Walk("until", (before[0],)):
                    self.steps.pop()  # "Where you see the bank, turn left": at the bank, not where it comes in view.
                self.steps.append(Rotate(direction, "at", before[0]))
            elif not (direction == "around" and self.steps[-1:] == [Rotate("around")]):
                self.steps.append(Rotate(direction))
        elif place.value in ("along", "between", "towards") and "there" not in self._flags:
            # "Turn left along the wall": the wall comes after the turn.
            self.steps.append(Rotate(direction))
            self._places = [place]
            self._walk_to_places()
        elif place.value in ("through_between", "to", "towards"):
            self._places = [place]
            self._walk_to_places()
            at = place.named[-1].thing
            self.steps.append(Rotate(direction, "at", at) if "there" in self._flags else Rotate(direction))
        else:
            self._add_turn_at(direction, place)
        self._flags.discard("there")
        self._joined = THEN

    def _turning_place(self) -> tuple[PendingPlace | None, Sequence[Thing]]:
        """Remove and return the place of a turn, and the referent of "there"."""
        place = self._places.pop() if self._places else None
        before = self._mentioned[-1:]
        if place is not None and place.named[-1].thing.kind == "corner" and place.value == "at":
            if self._places and self._places[-1].value in _BY_CORNER:
                place = self._places.pop()
            elif "there" in self._flags:
                place, before = None, self._mentioned[-2:-1]
        return place, before

    def _add_turn_at(self, direction: str, place: PendingPlace) -> None:
        last = place.named[-1]
        self._pass(place.named[:-1])
        self._pass_beside(last)
        is_street = last.thing.kind in ("street", "alley") and not last.thing.which
        if is_street and self._is_reached(place):
            self.steps += [Rotate(direction), Walk("along", (last.thing,))]
        else:
            self.steps.append(Rotate(direction, self.text.rules.turn_positions.get(place.value, "at"), last.thing))
