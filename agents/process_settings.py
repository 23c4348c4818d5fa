"""Settings of a process that runs small networks on a processor."""

import ctypes

import torch

TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3
"""Parameters of glibc's `mallopt`, by their numbers in malloc.h."""

KEPT = 1 << 30
"""Bytes of freed memory at the end of the heap that stay with the process."""

MAPPED = 1 << 25
"""Least size in bytes of a block that is mapped on its own, the largest that glibc allows; such a block goes back to
the system when it is freed."""


def prepare_process() -> None:
    """Use one thread, and keep freed memory for the next step.

    A step is small: threads that wait for each other cost more than they do. The C library hands memory of several
    megabytes back to the system as soon as it is free; each step would then pay for new pages, which is a fifth of the
    visual encoder's time.
    """
    torch.set_num_threads(1)
    set_option = getattr(ctypes.CDLL(None), "mallopt", None)  # Only glibc has it.
    if set_option:
        set_option(TRIM_THRESHOLD, KEPT)
        set_option(MMAP_THRESHOLD, MAPPED)
