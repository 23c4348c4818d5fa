"""Tests; the folders mirror the source tree."""

import os
from pathlib import Path

# Several test processes share the cores: more threads of BLAS and torch in each would only wait for each other.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

ROOT = Path(__file__).parents[1]
"""The root of the repository."""
