"""Agent that takes shortest paths by the ground truth: the paper's baseline S/P (table 2)."""

from arramon_agents.shortest_path.agent import Agent

__all__ = ["Agent"]
