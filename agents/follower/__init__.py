"""Follows instructions by text, depth and segmentation alone: a grounded upper bound, and the test of a data set."""

from agents.follower.agent import Agent

__all__ = ["Agent"]
