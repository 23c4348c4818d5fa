"""Placement of zebra crossings: on some of the streets that leave a junction, never on alleys or at squares."""

import math
from random import Random

from arramon_dataset.plans.plan import Plan
from arramon_dataset.plans.survey import MiddleLine, Mouth, meetings_of, tracks_of
from arramon_server.sim.assets.roadside import ZEBRA_LENGTH
from arramon_server.sim.section import Prop

NARROWEST = 4.0
"""Width of the narrowest street with a zebra crossing, in units."""

SHARE = 0.5
"""Share of a junction's streets that have one, on average. Every junction of three streets or more has one at least."""

APART = 4.5
"""Minimum distance between the middles of two zebra crossings, in units."""

BACK = 0.2
"""Distance of a zebra crossing from the junction's open ground, in units."""


def zebra_crossings(plan: Plan, random: Random) -> tuple[Prop, ...]:
    """Return a plan's zebra crossings; the same plan and random numbers give the same result.

    Args:
        plan: street plan.
        random: draws the streets.
    """
    tracks = tracks_of(plan)
    found: list[Prop] = []
    for meeting in meetings_of(plan, tracks):
        streets = [mouth for mouth in meeting.mouths if 2 * tracks[mouth.track].half_width >= NARROWEST]
        if meeting.corners is not None or len(streets) < 3:
            continue
        drawn = [mouth for mouth in streets if random.random() < SHARE]
        for mouth in drawn or [random.choice(streets)]:
            zebra = _zebra(mouth, tracks[mouth.track])
            if all(math.dist((zebra.x, zebra.z), (other.x, other.z)) > APART for other in found):
                found.append(zebra)
    return tuple(found)


def _zebra(mouth: Mouth, track: MiddleLine) -> Prop:
    x, z = track.places[mouth.at].tolist()
    heading = track.heading(mouth.at, mouth.way)
    angle, away = math.radians(heading), BACK + ZEBRA_LENGTH / 2
    x, z = round(x + away * math.sin(angle), 3), round(z + away * math.cos(angle), 3)
    return Prop("zebra_crossing", x, z, heading)
