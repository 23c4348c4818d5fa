"""Process settings: one thread, and freed memory stays with the process."""

import ctypes
import os
import subprocess
import sys

import pytest

BLOCKS = """
import resource
import numpy as np
import torch
from arramon_agents.process_settings import prepare_process

def faults():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(20):
        blocks = [np.ones(16 << 20, np.uint8) for _ in range(4)]
        del blocks
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

prepare_process()
faults()
print(faults(), torch.get_num_threads())
"""


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallopt"), reason="only glibc has mallopt")
def test_blocks_of_memory_are_used_again_without_new_pages() -> None:
    run = subprocess.run(
        [sys.executable, "-c", BLOCKS],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"OMP_NUM_THREADS": "2"},
    )
    faults, threads = map(int, run.stdout.split())
    assert faults < 1000  # Without the setting there are tens of thousands.
    assert threads == 1
