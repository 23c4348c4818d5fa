"""Benchmarks of cameras, collision checks and environments: their speed, and the agreement of implementations."""
