"""The gate's position on the path after some steps, and the places of the path nearest to named things."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from arramon_dataset.instructions.gate.world import GateWorld
from arramon_dataset.paths import Place
from arramon_lang.meaning import Thing

HINDSIGHT = 5
"""Number of places before a step begins, or before a bend, from which a thing may already have been recognised."""


@dataclass(frozen=True, slots=True)
class GateProgress:
    """The position on the path after some steps, and the turns and things mentioned so far.

    Attributes:
        at: index of the path's place where they end.
        turned: indices of the places of the turns mentioned.
        faced: indices of the places where the instruction names a thing to face.
        named: identities of the things named so far.
        since: index of the place where the last step began.
        earlier: indices of the places of the turns mentioned before the last step.
        passed: index of the place where the path passes the last thing whose side is stated.
    """

    at: int = 0
    turned: tuple[int, ...] = ()
    faced: tuple[int, ...] = ()
    named: frozenset[str] = frozenset()
    since: int = 0
    earlier: frozenset[int] = frozenset()
    passed: int = 0

    @property
    def mentioned_turns(self) -> Iterator[int]:
        """Indices of the places of all turns mentioned, including those to face a thing."""
        yield from self.turned
        yield from self.faced

    @property
    def last_turn(self) -> int:
        """Index of the place of the last turn mentioned; 0 if there is none."""
        return max((*self.mentioned_turns, 0))

    @property
    def first_alternative(self) -> int:
        """Index of the first place from which a street may be mistaken for the one that the next step names."""
        return self.at if self.at and self.at in self.turned else self.at - 2


def places_ahead(world: GateWorld, at: int, count: int) -> range:
    """Return the indices of the next places of a path."""
    return range(at, min(at + count, len(world.path)))


def nearest_index(world: GateWorld, things: Sequence[Thing], at: int, limit: float) -> int | None:
    """Return the index where the path comes closest to things, from a place on; None if it stays farther away.

    Args:
        world: the gate's view of the turn.
        things: with identities.
        at: index of the place to begin with.
        limit: maximum distance, in units.
    """
    if things[0].kind in ("street", "alley"):
        road = world.road(things[0].identity)
        far = range(at, len(world.path))
        entered = (i for i in far if road is not None and road.distance(*world.path[i]) <= road.width / 2)
        return next(entered, None)
    landmarks = [landmark for thing in things for landmark in world.landmarks(thing.identity)]
    if len(things) == 1 and landmarks and landmarks[0].label.kind != "building":
        near = [world.geometry.first_approach(landmark.x, landmark.z, max(at - 2, 0), limit) for landmark in landmarks]
        return None if any(index is None for index in near) else max(index for index in near if index is not None)
    x, z = middle_of(world, things, at)
    junction = world.junction(things[0].identity)
    return world.geometry.first_approach(
        x, z, max(at - 2, 0), limit + (junction.radius if junction is not None else 0.0)
    )


def middle_of(world: GateWorld, things: Sequence[Thing], at: int) -> Place:
    """Return the middle of things or places; the path's place `at` if none of them exists."""
    places: list[Place] = []
    for thing in things:
        junction, corner = world.junction(thing.identity), world.corner(thing.identity)
        if junction is not None:
            places.append((junction.x, junction.z))
        elif corner is not None:
            places.append((corner.x, corner.z))
        else:
            places += [(landmark.x, landmark.z) for landmark in world.landmarks(thing.identity)]
    if not places:
        return world.path[at]
    return sum(x for x, _ in places) / len(places), sum(z for _, z in places) / len(places)
