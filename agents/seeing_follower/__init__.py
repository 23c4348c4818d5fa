"""The rule-based follower with a visual encoder and the learned reader, from RGB and depth alone."""

from arramon_agents.seeing_follower.agent import Agent

__all__ = ["Agent"]
