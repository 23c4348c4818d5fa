"""Walks to the targets on the shortest way, by a privileged sensor: the paper's baseline S/P (table 2)."""

from agents.shortest_path.agent import Agent

__all__ = ["Agent"]
