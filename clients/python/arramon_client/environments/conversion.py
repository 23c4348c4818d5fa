"""Support of texts in Gymnasium's array conversion wrappers, such as `NumpyToTorch`."""

import sys
from types import ModuleType
from typing import Any

import numpy as np

MODULE = "gymnasium.wrappers.array_conversion"


def keep_texts_in_wrappers() -> None:
    """Make the wrappers, if they have been imported, pass texts and object arrays through unchanged.

    By default they fail on any text in an observation or info: they recurse endlessly into its characters, and PyTorch
    has no object arrays.
    """
    wrappers = sys.modules.get(MODULE)
    if wrappers is None or str in wrappers.array_conversion.registry:
        return
    convert = wrappers.array_conversion.dispatch(np.ndarray)

    def keep(value: Any, xp: ModuleType, device: Any = None) -> Any:  # noqa: ARG001 - Gymnasium's signature
        return value

    def convert_numbers(value: Any, xp: ModuleType, device: Any = None) -> Any:
        return value if value.dtype == object else convert(value, xp, device)

    wrappers.array_conversion.register(str, keep)
    wrappers.array_conversion.register(np.ndarray, convert_numbers)
