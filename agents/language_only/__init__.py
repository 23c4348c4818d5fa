"""`agents.vl` without images as input (extra `torch`)."""

from arramon_agents.vl import make_factory

__all__ = ["make_agent"]

make_agent = make_factory("language_only")
