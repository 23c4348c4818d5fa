"""Description of a way through a town: legs between junctions, turns, and the target's side of the street."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from examples.sampling.town import CELL, Spot, Town, TownPoint

SHORTEST_LEG = 4
"""Least number of steps of a leg."""


@dataclass(frozen=True)
class RouteLeg:
    """A straight part of a way.

    Attributes:
        turn: the turn before it: 0 none, 1 right, -1 left, 2 around.
        into_alley: whether it leads into an alley.
        passed: number of intersections that it passes before its end.
        end: "+" for an intersection, "L" for a corner, "" if it ends at the target.
    """

    turn: int
    into_alley: bool
    passed: int
    end: str


def legs_of(town: Town, spots: Sequence[Spot], target: TownPoint) -> list[RouteLeg] | None:
    """Return the legs of a way to `target`; None if it turns at a place without a junction."""
    places = [spot.place for i, spot in enumerate(spots) if i == 0 or spot.place != spots[i - 1].place]
    runs = _runs(_quarters(places))
    legs = []
    facing, left = spots[0].heading, _zone(town, places[0])
    for number, (first, last, quarter) in enumerate(runs):
        turn = _turn(facing, 3 * quarter)
        if number and turn not in (-1, 1):
            return None
        is_last = number == len(runs) - 1
        end = _zone(town, target) if is_last else _nearest_zone(town, places, last)
        if end is None and not is_last:
            return None
        visited = [zone for zone, _ in groupby(_zone(town, place) for place in places[first : last + 1])]
        passed = {zone for zone in visited if zone and zone[0] == "+"} - {left, end}
        marks = [town.at(place) for place in places[first : last + 1]]
        alley = "a" in marks and marks[0] != "a"
        legs.append(RouteLeg(turn, alley, len(passed), "" if is_last or end is None else end[0]))
        facing, left = 3 * quarter, end
    return legs


def _turn(heading: int, wanted: int) -> int:
    """Return the turn, as in `RouteLeg`, between two headings, given in steps of 30 degrees."""
    steps = (wanted - heading + 6) % 12 - 6
    if abs(steps) <= 1:
        return 0
    return 2 if abs(steps) >= 5 else int(math.copysign(1, steps))


def _quarters(places: Sequence[TownPoint]) -> list[int]:
    """Return for each place the walking direction: 0 along, 1 across, 2 and 3 their opposites."""
    found: list[int] = []
    for i in range(len(places)):
        before, after = places[max(i - 3, 0)], places[min(i + 3, len(places) - 1)]
        across, along = after.across - before.across, after.along - before.along
        choices = {0: along, 1: across, 2: -along, 3: -across}
        if found:
            choices[found[-1]] *= 1.3  # keep the direction unless another one is clearly better
        found.append(max(choices, key=lambda quarter: choices[quarter]))
    return found


def _runs(quarters: Sequence[int]) -> list[tuple[int, int, int]]:
    """Return (first, last, quarter) of each stretch in one direction; short ones are merged."""
    runs: list[tuple[int, int, int]] = []
    start = 0
    for quarter, members in groupby(quarters):
        length = len(list(members))
        if runs and (length < SHORTEST_LEG or runs[-1][2] == quarter):
            runs[-1] = (runs[-1][0], start + length - 1, runs[-1][2])
        else:
            runs.append((start, start + length - 1, quarter))
        start += length
    if len(runs) > 1 and runs[0][1] - runs[0][0] < SHORTEST_LEG - 1:
        runs[:2] = [(0, runs[1][1], runs[1][2])]
    return runs


def _zone(town: Town, place: TownPoint) -> tuple[str, int] | None:
    return town.zones.get((math.floor(place.along / CELL), math.floor(place.across / CELL)))


def _nearest_zone(town: Town, places: Sequence[TownPoint], index: int) -> tuple[str, int] | None:
    """Return the junction at or near a place of the way."""
    for offset in (0, 1, -1, 2, -2, 3, -3):
        if 0 <= index + offset < len(places) and (zone := _zone(town, places[index + offset])):
            return zone
    return None


def side_of(town: Town, target: TownPoint, spots: Sequence[Spot]) -> str:
    """Return the target's location relative to the way: "+", "L", "a" (the alley), "right", "left" or "middle"."""
    mark = town.at(target)
    if mark in "+La":
        return mark
    quarter = _runs(_quarters([spot.place for spot in spots]))[-1][2]
    across, along = ((1, 0), (0, -1), (-1, 0), (0, 1))[quarter]
    right, left = (_to_wall(town, target, sign * across, sign * along) for sign in (1, -1))
    if abs(right - left) < 0.8:
        return "middle"
    return "right" if right < left else "left"


def _to_wall(town: Town, place: TownPoint, across: int, along: int) -> float:
    distance, point = 0.0, place
    while distance < 5.0 and town.at(point) != "#":
        distance += 0.25
        point = TownPoint(place.across + distance * across, place.along + distance * along)
    return distance
