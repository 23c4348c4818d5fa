"""Benchmarks of the server: steps per second end to end, and the cost of each part."""
