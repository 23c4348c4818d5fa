"""Texts pass through Gymnasium's wrappers that convert arrays, such as `NumpyToTorch`, which know no texts."""

import sys
from types import ModuleType
from typing import Any

import numpy as np

MODULE = "gymnasium.wrappers.array_conversion"


def keep_texts_in_wrappers() -> None:
    """Teach the wrappers, if they have been imported, to leave texts and arrays of objects as they are.

    Without it they fail on any text in an observation or an info: they take it apart into characters without end, and
    PyTorch has no arrays of objects.
    """
    wrappers = sys.modules.get(MODULE)
    if wrappers is None or str in wrappers.array_conversion.registry:
        return
    convert = wrappers.array_conversion.dispatch(np.ndarray)

    def leave(value: Any, xp: ModuleType, device: Any = None) -> Any:  # noqa: ARG001 - as the others
        return value

    def numbers(value: Any, xp: ModuleType, device: Any = None) -> Any:
        return value if value.dtype == object else convert(value, xp, device)

    wrappers.array_conversion.register(str, leave)
    wrappers.array_conversion.register(np.ndarray, numbers)
