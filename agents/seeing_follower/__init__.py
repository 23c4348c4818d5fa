"""The follower with learned eyes and a learned reader: it plays by RGB and depth alone."""

from agents.seeing_follower.agent import Agent

__all__ = ["Agent"]
