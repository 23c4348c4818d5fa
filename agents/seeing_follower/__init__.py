"""The follower with a visual encoder and the learned reader: it plays from RGB and depth alone."""

from arramon_agents.seeing_follower.agent import Agent

__all__ = ["Agent"]
