"""Benchmarks of agents: the tables of docs/results.md, docs/ablations.md and docs/transfer.md, and plots of paths."""
