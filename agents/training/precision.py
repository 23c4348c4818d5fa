"""Precision of matrix products in training, depending on what the device supports."""

from collections.abc import Callable

import torch

from arramon_agents.training.recipe import PRECISIONS

FLOAT32, BFLOAT16 = PRECISIONS


def has_bfloat16(device: str) -> bool:
    """Return whether a device supports bfloat16 natively, so that it is faster than float32.

    CPUs need AVX-512 or AMX with bfloat16; without, networks are slower than in float32, or fail (LSTM).

    Args:
        device: name of a torch device, such as "cpu" or "cuda".
    """
    if torch.device(device).type != "cpu":
        return True
    mkldnn = torch.backends.mkldnn.is_available()  # type: ignore[no-untyped-call]
    return mkldnn and bool(torch.ops.mkldnn._is_mkldnn_bf16_supported())


def usable_precision(precision: str, device: str, report: Callable[[str], None]) -> str:
    """Return the precision, or "float32" if the device does not support "bfloat16".

    Args:
        precision: "float32" or "bfloat16".
        device: name of a torch device.
        report: receives a line if the precision is replaced.
    """
    if precision != BFLOAT16 or has_bfloat16(device):
        return precision
    report("this processor has no bfloat16: training in float32, which takes longer")
    return FLOAT32
