"""Process settings for running small networks on the CPU: number of threads, memory allocation."""

import ctypes

import torch

TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3
"""Parameters of glibc's `mallopt`, by their numbers in malloc.h."""

KEPT = 1 << 30
"""Bytes of free memory at the end of the heap that the process keeps."""

MAPPED = 1 << 25
"""Minimum size in bytes of blocks that are mapped individually and returned to the system when freed; glibc allows no
larger one."""


def prepare_process() -> None:
    """Use one thread, and keep freed memory for the next step.

    Steps are so small that the synchronisation of threads costs more than they save. By default the C library returns
    blocks of several megabytes to the system when they are freed; page faults on new ones would take a fifth of the
    visual encoder's time.
    """
    torch.set_num_threads(1)
    set_option = getattr(ctypes.CDLL(None), "mallopt", None)  # Only glibc has it.
    if set_option:
        set_option(TRIM_THRESHOLD, KEPT)
        set_option(MMAP_THRESHOLD, MAPPED)
