"""Random street plans for training sections, with the same kinds of streets as the seven plans made by hand.

A ring of four streets, a main street across it, cross streets on both sides of it, alleys and side streets between
these, dead ends, and a square on the main street. All of these are random; what does not fit is drawn again.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from random import Random

from arramon_dataset.plans.plan import OpenSquare, Pair, Plan, Street

HALF = (14.5, 17.0)
"""Range of half the ring's width and length, between the middle lines of its streets, in units."""

WIDTHS = {
    "main": (5.5, 6.0, 6.5),
    "ring": (4.5, 5.0),
    "street": (4.5, 5.0),
    "alley": (2.4, 2.6, 2.8),
    "yard": (3.0, 3.5, 4.0),
}
"""Widths of streets by their role, in units."""

JUNCTION_SPACING = 6.5
"""Minimum distance between two junctions on a street, in units: closer ones look like one crossing."""

MIN_BLOCK_DEPTH = 8.0
"""Minimum distance between parallel streets, and between an alley and the ends of its block, in units."""

CUT, CUT_SHARE = (6.0, 8.5), 0.3
"""Range of the length cut off a corner of the ring, in units, and the share of corners that are cut off."""

SLANT, SLANT_SHARE = (2.5, 6.0), 0.35
"""Range of the offset of a slanting cross street's far end, in units, and the share of such streets."""

CURVE_SHARE, CURVE = 0.4, (2.5, 4.5)
"""Share of main streets with a curve, and the range of its offset, in units."""

LANE_SHARE = 0.7
"""Probability of an alley or a side street through a block that is large enough."""

YARD = (5.5, 6.5)
"""Range of the length of dead ends outside the ring, from its middle line, in units."""

TRIES = 30
"""Maximum number of attempts to place a street."""


@dataclass
class _Sketch:
    """An unfinished plan. The main street runs along the `along` axis; the axes may be exchanged at the end.

    Attributes:
        left, right, bottom, top: of the ring's middle lines, in units.
        main: (across, along) of the main street's points.
        streets: all streets so far.
        leaving: for each side of the ring ("left" and so on), the positions on it at which streets leave it.
    """

    left: float
    right: float
    bottom: float
    top: float
    main: tuple[Pair, ...]
    streets: list[Street] = field(default_factory=list)
    leaving: dict[str, list[float]] = field(default_factory=lambda: {s: [] for s in ("left", "right", "bottom", "top")})

    def main_at(self, along: float) -> float:
        """Return the main street's `across` coordinate at an `along` coordinate, in units."""
        return _at(self.main, along)

    def add(self, name: str, role: str, points: Sequence[Pair], random: Random) -> Street:
        """Add a street of a role's width."""
        street = Street(name, random.choice(WIDTHS[role]), tuple((round(x, 2), round(y, 2)) for x, y in points))
        self.streets.append(street)
        return street


def draw_plan(id: str, origin: Pair, random: Random) -> Plan | None:  # noqa: A002 - as in `Plan`
    """Return a street plan, or None if its parts do not fit; the same random numbers give the same plan.

    The plan is not yet validated: `faults.faults_of_section` checks the section that is built from it.

    Args:
        id: of the section.
        origin: (x, z) of its middle in the world frame, in units.
        random: draws everything.
    """
    half_width, half_length = random.uniform(*HALF), random.uniform(*HALF)
    left, right, bottom, top = -half_width, half_width, -half_length, half_length
    sketch = _Sketch(left, right, bottom, top, _main(bottom, top, random))
    sketch.add("Main Street", "main", sketch.main, random)
    for end, side in ((sketch.main[0], "bottom"), (sketch.main[-1], "top")):
        sketch.leaving[side].append(end[0])
    sides = _cross_streets(sketch, random)
    if sides is None:
        return None
    for cross in sides:
        _blocks(sketch, cross, random)
    squares: tuple[OpenSquare, ...] = (_square(sketch, sides, random),)
    _ring(sketch, random)
    _yards(sketch, random)
    streets = tuple(sketch.streets)
    if random.random() < 0.5:
        streets, squares = _exchanged(streets, squares)
    heading = round(random.uniform(0.0, 179.9), 1)
    return Plan(id, f"Drawn {id}", heading, origin, streets, squares)


@dataclass(frozen=True)
class _Cross:
    """A cross street, from the main street to a side of the ring.

    Attributes:
        side: "left" or "right".
        near, far: `along` coordinates of its ends at the main street and at the ring.
    """

    side: str
    near: float
    far: float

    def line(self, sketch: _Sketch) -> tuple[Pair, Pair]:
        """Return its middle line, from the main street to the ring."""
        return (sketch.main_at(self.near), self.near), (sketch.left if self.side == "left" else sketch.right, self.far)


def _main(bottom: float, top: float, random: Random) -> tuple[Pair, ...]:
    across = random.uniform(-4.0, 4.0)
    if random.random() >= CURVE_SHARE:
        return (across, bottom), (across, top)
    middle, swerve = random.uniform(-3.0, 3.0), math.copysign(random.uniform(*CURVE), -across)
    return (across, bottom), (across, middle - 4.0), (across + swerve, middle + 4.0), (across + swerve, top)


def _cross_streets(sketch: _Sketch, random: Random) -> tuple[list[_Cross], list[_Cross]] | None:
    """Add the cross streets, and return those of each side in ascending order; None if they do not fit."""
    sides: list[list[_Cross]] = []
    for side, count in zip(("left", "right"), random.choice(((1, 2), (2, 1), (2, 2), (1, 3), (3, 1))), strict=True):
        others = [cross.near for cross in (sides[0] if sides else [])]
        found: list[_Cross] = []
        for _ in range(TRIES * count):
            if len(found) == count:
                break
            cross = _cross(sketch, side, others, random)
            if all(
                min(abs(cross.near - one.near), abs(cross.far - one.far)) >= MIN_BLOCK_DEPTH for one in found
            ) and all(cross.near == other or abs(cross.near - other) >= JUNCTION_SPACING for other in others):
                found.append(cross)
        if len(found) < count:
            return None
        sides.append(sorted(found, key=lambda cross: cross.near))
        alley = random.randrange(count) if count > 1 else None
        for number, cross in enumerate(sides[-1]):
            role = "alley" if number == alley else "street"
            sketch.add(f"{side.title()} {role.title()} {number + 1}", role, cross.line(sketch), random)
            sketch.leaving[side].append(cross.far)
    return sides[0], sides[1]


def _cross(sketch: _Sketch, side: str, others: Sequence[float], random: Random) -> _Cross:
    low, high = sketch.bottom + MIN_BLOCK_DEPTH, sketch.top - MIN_BLOCK_DEPTH
    near = random.choice(others) if others and random.random() < 0.4 else random.uniform(low, high)
    if random.random() >= SLANT_SHARE:
        return _Cross(side, near, near)
    off = random.uniform(*SLANT) * random.choice((1, -1))
    return _Cross(side, near, min(max(near + off, low), high))


def _blocks(sketch: _Sketch, crosses: Sequence[_Cross], random: Random) -> None:
    """Add alleys and side streets through the blocks of one side that are large enough."""
    side = crosses[0].side
    edge = sketch.left if side == "left" else sketch.right
    low_line: tuple[Pair, Pair] = ((edge, sketch.bottom), (0.0, sketch.bottom))
    high_line: tuple[Pair, Pair] = ((edge, sketch.top), (0.0, sketch.top))
    lines = [low_line, *(cross.line(sketch) for cross in crosses), high_line]
    taken: dict[int, list[float]] = {}  # `across` coordinates of the alleys that meet each line.
    for number, (low, high) in enumerate(pairwise(lines)):
        if random.random() >= LANE_SHARE:
            continue
        for _ in range(TRIES):
            across = random.uniform(min(edge, 0.0), max(edge, 0.0))
            start, end = _along(low, across), _along(high, across)
            nearest = min(abs(across - sketch.main_at(place)) for place in (start, (start + end) / 2, end))
            others = taken.get(number, []) + taken.get(number + 1, [])
            if end - start < MIN_BLOCK_DEPTH or nearest < JUNCTION_SPACING or abs(across - edge) < JUNCTION_SPACING:
                continue
            if all(abs(across - other) >= JUNCTION_SPACING for other in others):
                role = random.choice(("alley", "alley", "street"))
                sketch.add(f"{side.title()} Lane {number + 1}", role, ((across, start), (across, end)), random)
                for line in (number, number + 1):
                    taken.setdefault(line, []).append(across)
                if low is low_line:
                    sketch.leaving["bottom"].append(across)
                if high is high_line:
                    sketch.leaving["top"].append(across)
                break


def _square(sketch: _Sketch, sides: Sequence[Sequence[_Cross]], random: Random) -> OpenSquare:
    """Return an open square on the main street, where a cross street leaves it."""
    cross = random.choice([cross for side in sides for cross in side])
    across, towards = sketch.main_at(cross.near), -1.0 if random.random() < 0.5 else 1.0
    half = sketch.streets[0].width / 2
    near, far = (
        across - towards * random.uniform(half, half + 1.0),
        across + towards * random.uniform(half + 2.5, half + 4.5),
    )
    low, high = cross.near - random.uniform(3.0, 5.0), cross.near + random.uniform(3.0, 5.0)
    corners = [(near, low), (far, low), (far, high), (near, high)]
    if random.random() < 0.4:  # One corner is cut off.
        corners[2:3] = [(far, high - 2.0), (far - towards * 2.0, high)]
    return OpenSquare("Square", tuple((round(x, 2), round(y, 2)) for x, y in corners))


def _ring(sketch: _Sketch, random: Random) -> None:
    """Add the ring's four streets. At a corner that is cut off, the left and right streets take the diagonal."""
    half = max(WIDTHS["ring"]) / 2  # At other corners each street extends to the far edge of the other.
    left, right, bottom, top = sketch.left, sketch.right, sketch.bottom, sketch.top
    cuts = {(one, other): _cut(sketch, one, other, random) for one in ("left", "right") for other in ("bottom", "top")}
    for side, across, inward in (("left", left, 1.0), ("right", right, -1.0)):
        first, last = cuts[side, "bottom"], cuts[side, "top"]
        start = [(across + inward * first, bottom), (across, bottom + first)] if first else [(across, bottom - half)]
        end = [(across, top - last), (across + inward * last, top)] if last else [(across, top + half)]
        sketch.add(f"{side.title()} Ring", "ring", (*start, *end), random)
    for side, along in (("bottom", bottom), ("top", top)):
        first, last = cuts["left", side] or -half, cuts["right", side] or -half
        sketch.add(f"{side.title()} Ring", "ring", ((left + first, along), (right - last, along)), random)


def _cut(sketch: _Sketch, one: str, other: str, random: Random) -> float:
    """Return the length cut off the ring's corner between two sides, in units; 0 for none."""
    cut = random.uniform(*CUT)
    if random.random() >= CUT_SHARE:
        return 0.0
    ends = [(one, getattr(sketch, other)), (other, getattr(sketch, one))]
    if any(abs(place - corner) < cut + JUNCTION_SPACING for side, corner in ends for place in sketch.leaving[side]):
        return 0.0
    for side, corner in ends:
        sketch.leaving[side].append(corner - math.copysign(cut, corner))
    return cut


def _yards(sketch: _Sketch, random: Random) -> None:
    """Add dead ends on the outside of the ring."""
    for side in random.sample(("left", "right", "bottom", "top"), random.choice((1, 1, 2))):
        along = side in ("left", "right")
        low, high = (sketch.bottom, sketch.top) if along else (sketch.left, sketch.right)
        edge = getattr(sketch, side)
        for _ in range(TRIES):
            place = random.uniform(low + JUNCTION_SPACING, high - JUNCTION_SPACING)
            if all(abs(place - other) >= JUNCTION_SPACING for other in sketch.leaving[side]):
                end = edge + math.copysign(random.uniform(*YARD), edge)
                points = ((edge, place), (end, place)) if along else ((place, edge), (place, end))
                sketch.add(f"{side.title()} Yard", "yard", points, random)
                sketch.leaving[side].append(place)
                break


def _exchanged(
    streets: Sequence[Street], squares: Sequence[OpenSquare]
) -> tuple[tuple[Street, ...], tuple[OpenSquare, ...]]:
    """Return streets and squares with their axes exchanged."""

    def turned(points: Sequence[Pair]) -> Iterator[Pair]:
        return ((y, x) for x, y in points)

    return (
        tuple(Street(street.name, street.width, tuple(turned(street.points))) for street in streets),
        tuple(OpenSquare(square.name, tuple(turned(square.corners))) for square in squares),
    )


def _at(line: Sequence[Pair], along: float) -> float:
    """Return the `across` coordinate of a line that runs along, at an `along` coordinate."""
    for (x0, y0), (x1, y1) in pairwise(line):
        if along <= y1:
            return x0 + (x1 - x0) * (along - y0) / (y1 - y0)
    return line[-1][0]


def _along(line: tuple[Pair, Pair], across: float) -> float:
    """Return the `along` coordinate of a line that runs across, at an `across` coordinate."""
    (x0, y0), (x1, y1) = line
    return y0 + (y1 - y0) * (across - x0) / (x1 - x0)
