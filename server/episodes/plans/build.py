"""From a street plan to a section: buildings, and what stands in the streets and hangs on the walls."""

from server.episodes.plans.blocks import bounds_of, build_up
from server.episodes.plans.landmarks import furnish
from server.episodes.plans.plan import Plan
from server.sim.section import Section


def build_section(plan: Plan, seed: str) -> Section:
    """The section of a plan; the same plan and seed give the same section, byte for byte.

    Where its streets run follows from the plan alone. The middle lines of all streets stay free.

    Args:
        plan: where the streets run.
        seed: draws heights, facades and furniture: of a hidden section, the host's secret.
    """
    buildings = build_up(plan, seed)
    return Section(plan.id, plan.heading, bounds_of(plan), buildings, furnish(plan, buildings, seed))
