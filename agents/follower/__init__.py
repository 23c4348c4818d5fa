"""Rule-based agent that follows instructions by text, depth and segmentation alone: a grounded upper bound, and the
test of a data set's instructions."""

from arramon_agents.follower.agent import Agent

__all__ = ["Agent"]
