"""Placement of zebra crossings on random streets at junctions, but not on alleys or at squares."""

import math
from random import Random

from arramon_dataset.plans.junction_detection import MiddleLine, Mouth, detect_junctions, middle_lines_of
from arramon_dataset.plans.plan import Plan
from arramon_server.sim.assets.roadside import ZEBRA_LENGTH
from arramon_server.sim.section import Prop

NARROWEST = 4.0
"""Width of the narrowest street with a zebra crossing, in units."""

SHARE = 0.5
"""Mean share of a junction's streets with a zebra crossing. A junction of three or more streets has at least one."""

APART = 4.5
"""Minimum distance between the centres of two zebra crossings, in units."""

BACK = 0.2
"""Distance of a zebra crossing from the junction's open ground, in units."""


def zebra_crossings(plan: Plan, random: Random) -> tuple[Prop, ...]:
    """Return a plan's zebra crossings; the same plan and random numbers give the same result.

    Args:
        plan: street plan.
        random: chooses the streets.
    """
    lines = middle_lines_of(plan)
    found: list[Prop] = []
    for detected in detect_junctions(plan, lines):
        streets = [mouth for mouth in detected.mouths if 2 * lines[mouth.line].half_width >= NARROWEST]
        if detected.corners is not None or len(streets) < 3:
            continue
        drawn = [mouth for mouth in streets if random.random() < SHARE]
        for mouth in drawn or [random.choice(streets)]:
            zebra = _zebra(mouth, lines[mouth.line])
            if all(math.dist((zebra.x, zebra.z), (other.x, other.z)) > APART for other in found):
                found.append(zebra)
    return tuple(found)


def _zebra(mouth: Mouth, line: MiddleLine) -> Prop:
    x, z = line.places[mouth.at].tolist()
    heading = line.heading(mouth.at, mouth.direction)
    angle, away = math.radians(heading), BACK + ZEBRA_LENGTH / 2
    x, z = round(x + away * math.sin(angle), 3), round(z + away * math.cos(angle), 3)
    return Prop("zebra_crossing", x, z, heading)
