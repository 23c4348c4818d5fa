"""Street plans of sections, and their validated TOML files."""

import json
import math
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
from pydantic import ConfigDict, Field, TypeAdapter

from arramon_dataset.layout.grid import Points, to_world_frame
from arramon_server.episodes.split_files import parse_json, read_bytes
from arramon_server.errors import BadFile, NotFound

FOLDER = Path(__file__).parent
"""Folder of the project's own plans: one file for each section, named by its id."""

Pair = tuple[float, float]

NARROWEST = 2.0
"""Width of the narrowest alley, in units."""

_STRICT = ConfigDict(extra="forbid")


@dataclass(frozen=True, slots=True)
class Street:
    """A street of constant width along a polyline.

    Attributes:
        name: for people; no instruction uses it.
        width: between the facades, in units: 2 to 3 for an alley, 5 to 8 for a street.
        points: (across, along) of the ends and corners of its middle line, in the plan's frame, in units. Where it
            meets another street, the line extends to the other's middle; elsewhere it ends at a facade.
    """

    __pydantic_config__: ClassVar[ConfigDict] = _STRICT

    name: str
    width: Annotated[float, Field(ge=NARROWEST)]
    points: Annotated[tuple[Pair, ...], Field(min_length=2)]


@dataclass(frozen=True, slots=True)
class OpenSquare:
    """An open square.

    Attributes:
        name: for people; no instruction uses it.
        corners: (across, along) of its corners in order around it, in the plan's frame, in units.
    """

    __pydantic_config__: ClassVar[ConfigDict] = _STRICT

    name: str
    corners: Annotated[tuple[Pair, ...], Field(min_length=3)]


@dataclass(frozen=True, slots=True)
class Plan:
    """The streets and open squares of a section; buildings cover the rest of the ground.

    The plan's frame is turned: `along` points in the direction of `heading`, `across` 90 degrees clockwise from it.

    Attributes:
        id: of the section, for example "1".
        name: for people; no instruction uses it.
        heading: of the main streets, degrees clockwise from +z.
        origin: (x, z) of the plan's (0, 0) in the world frame, in units.
    """

    __pydantic_config__: ClassVar[ConfigDict] = _STRICT

    id: str
    name: str
    heading: Annotated[float, Field(ge=0.0, lt=180.0)]
    origin: Pair
    streets: Annotated[tuple[Street, ...], Field(min_length=1)]
    squares: tuple[OpenSquare, ...] = ()

    def world(self, points: Points) -> Points:
        """Convert (n, 2) of (across, along) in the plan's frame to (n, 2) of (x, z) in the world frame."""
        moved: Points = to_world_frame(points, self.heading) + np.asarray(self.origin)
        return moved

    def lines(self) -> tuple[Points, ...]:
        """Return the middle lines of all streets, each (n, 2) of (x, z) in the world frame."""
        return tuple(self.world(np.array(street.points)) for street in self.streets)


_PLAN = TypeAdapter(Plan)


def plan_ids() -> tuple[str, ...]:
    """Return the ids of all sections with a plan, in order."""
    return tuple(sorted((path.stem for path in FOLDER.glob("*.toml")), key=_natural))


def read_plan(id: str, folder: Path = FOLDER) -> Plan:  # noqa: A002 - the usual name
    """Read and validate the street plan of a section.

    Args:
        id: of the section, for example "1".
        folder: of the plan files.

    Raises:
        NotFound: if there is no such plan.
        BadFile: if the content is invalid; the message names the field and what was expected.
    """
    path = folder / f"{id}.toml"
    if not path.is_file():
        raise NotFound(f"there is no plan of section {id!r}; there are {', '.join(plan_ids())}")
    try:
        table = tomllib.loads(read_bytes(path).decode())
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise BadFile(path, f"is not TOML: {error}") from error
    try:
        data = json.dumps(table, allow_nan=False, default=str)
    except ValueError as error:
        raise BadFile(path, "contains a number that is not finite") from error
    plan = parse_json(_PLAN, data.encode(), path)
    _check(plan, path)
    return plan


def _check(plan: Plan, path: Path) -> None:
    if plan.id != path.stem:
        raise BadFile(path, f"is {plan.id!r}; expected {path.stem!r}, the file's name", field="id")
    for field, pieces in _corners(plan):
        for start, end in pairwise(pieces):
            if math.dist(start, end) < 0.5:
                raise BadFile(path, f"{start} and {end} are the same point, or nearly", field=field)


def _corners(plan: Plan) -> Iterator[tuple[str, tuple[Pair, ...]]]:
    for i, street in enumerate(plan.streets):
        yield f"streets[{i}].points", street.points
    for i, square in enumerate(plan.squares):
        yield f"squares[{i}].corners", square.corners


def _natural(name: str) -> tuple[tuple[int, str], ...]:
    """Return a sort key that orders numbers by value."""
    return tuple((int(part or 0), rest) for part, rest in re.findall(r"(\d*)(\D*)", name))
