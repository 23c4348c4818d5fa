"""`agents.vl` without images: it reads but does not see. It needs the extra `torch`."""

from arramon_agents.vl import make_factory

__all__ = ["make_agent"]

make_agent = make_factory("language_only")
