"""The project's own seven sections: street plans as data files, and the sections that are built from them."""

from server.episodes.plans.build import build_section
from server.episodes.plans.plan import Plan, Square, Street, plan_ids, read_plan

__all__ = ["Plan", "Square", "Street", "build_section", "plan_ids", "read_plan"]
