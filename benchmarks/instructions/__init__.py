"""Benchmarks of instructions: truth and naturalness of generated ones, and how well free texts are understood."""
