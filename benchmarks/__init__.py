"""Commands that measure, one folder for each part that is measured: `python -m benchmarks.FOLDER.NAME`."""
