"""The project's own seven sections: street plans as data files, and the generation of sections from them."""

from arramon_dataset.plans.build import build_section
from arramon_dataset.plans.plan import OpenSquare, Plan, Street, plan_ids, read_plan

__all__ = ["OpenSquare", "Plan", "Street", "build_section", "plan_ids", "read_plan"]
