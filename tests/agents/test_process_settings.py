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

THREADS = """
import torch
from arramon_client.plugin.loader import load_agent

for name in ("language_only", "seeing_follower", "vision_only", "vl", "vl_grounded", "vl_map", "vl_sentencepiece"):
    torch.set_num_threads(2)
    load_agent(f"agents.{name}")
    print(name, torch.get_num_threads())
"""


def output_of(program: str) -> list[str]:
    run = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"OMP_NUM_THREADS": "2"},
    )
    return run.stdout.splitlines()


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallopt"), reason="only glibc has mallopt")
def test_blocks_of_memory_are_used_again_without_new_pages() -> None:
    (printed,) = output_of(BLOCKS)
    faults, threads = map(int, printed.split())
    assert faults < 1000  # Without the setting there are tens of thousands.
    assert threads == 1


def test_every_agent_with_a_network_plays_with_one_thread() -> None:
    threads = dict(line.split() for line in output_of(THREADS))
    assert len(threads) == 7
    assert set(threads.values()) == {"1"}, threads
