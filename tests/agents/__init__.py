"""Tests of the agent plugins."""
