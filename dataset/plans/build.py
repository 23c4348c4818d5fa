"""Generation of a section from a street plan: buildings, street furniture and banners."""

from arramon_dataset.plans.buildings import bounds_of, buildings_of_plan
from arramon_dataset.plans.plan import Plan
from arramon_dataset.plans.street_furniture import furnish_streets
from arramon_server.sim.section import Section


def build_section(plan: Plan, seed: str) -> Section:
    """Return the section of a plan; the same plan and seed give the same section, byte for byte.

    Its streets depend on the plan alone. The middle lines of all streets stay free.

    Args:
        plan: street plan.
        seed: seeds heights, facades and furniture; for a hidden section, the host's secret.
    """
    buildings = buildings_of_plan(plan, seed)
    return Section(plan.id, plan.heading, bounds_of(plan), buildings, furnish_streets(plan, buildings, seed))
