"""Sections with random street plans, for the split `train_extra`."""

from collections.abc import Sequence
from functools import lru_cache

from arramon_dataset.generation.split_specs import FIRST_EXTRA
from arramon_dataset.plans import Plan, build_section
from arramon_dataset.plans.faults import faults_of_plan, faults_of_section
from arramon_dataset.plans.random_plan import draw_plan
from arramon_dataset.randomness import seeded
from arramon_server.errors import ArraMonError
from arramon_server.sim.section import Section

ATTEMPTS = 300
"""Maximum number of plans drawn for one section."""

SPACING, COLUMNS, ORIGIN = 70.0, 20, (400.0, 400.0)
"""The grid of the sections' centres: its spacing, in units; its number of columns; and (x, z) of the first section, far
from the seven sections planned by hand."""


def extra_sections(key: str, names: Sequence[str]) -> dict[str, tuple[Plan, Section]]:
    """Return random plans with their sections, by id; the same key and ids give the same result on every machine.

    Args:
        key: seeds plans, facades and furniture.
        names: ids of the sections, FIRST_EXTRA or more.

    Raises:
        ArraMonError: if no valid plan is found.
    """
    return {name: _draw(key, name) for name in names}


@lru_cache(maxsize=1024)
def _draw(key: str, name: str) -> tuple[Plan, Section]:
    row, column = divmod(int(name) - FIRST_EXTRA, COLUMNS)
    origin = ORIGIN[0] + SPACING * column, ORIGIN[1] + SPACING * row
    for attempt in range(ATTEMPTS):
        plan = draw_plan(name, origin, seeded(key, "plan", name, attempt))
        if plan is None or faults_of_plan(plan):
            continue
        section = build_section(plan, key)
        if not faults_of_section(plan, section):
            return plan, section
    raise ArraMonError(f"no good street plan of section {name} found in {ATTEMPTS} attempts")
