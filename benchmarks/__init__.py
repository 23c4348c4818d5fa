"""Benchmark commands, in a folder for each measured part: `python -m benchmarks.FOLDER.NAME`."""
