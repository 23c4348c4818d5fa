"""Sections that must meet the same requirements: the seven planned by hand, and some with random plans."""

from functools import cache

from arramon_dataset.generation.extra_sections import extra_sections
from arramon_dataset.plans import Plan, build_section, plan_ids, read_plan
from arramon_server.sim.section import Section

SEED = "arramon"
DRAWN = ("101", "102")
ALL = (*plan_ids(), *DRAWN)


def plan_of(section_id: str) -> Plan:
    return drawn(section_id)[0] if section_id in DRAWN else read_plan(section_id)


@cache
def section_of(section_id: str) -> Section:
    return drawn(section_id)[1] if section_id in DRAWN else build_section(read_plan(section_id), SEED)


def drawn(section_id: str) -> tuple[Plan, Section]:
    return extra_sections(SEED, [section_id])[section_id]
