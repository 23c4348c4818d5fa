"""Tests of the project's agents."""
