"""Benchmarks of agents: the tables of docs/results, and plots of paths."""
