"""Rule-based agent that follows instructions by text, depth and segmentation alone (no pose, no ground truth).

It is an upper bound for grounded agents, and a check that the instructions of a data set can be followed.
"""

from arramon_agents.follower.agent import Agent

__all__ = ["Agent"]
