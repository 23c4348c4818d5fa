"""Tests of the benchmarks of the simulation."""
