"""Compilation of loops over arrays with numba."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

_F = TypeVar("_F", bound=Callable[..., Any])


def compiled(function: _F) -> _F:
    """Compile a function at its first call, and cache the code on disk, or in memory if no folder is writable."""
    try:
        return cast(_F, numba.njit(cache=True, nogil=True)(function))
    except RuntimeError:  # numba found no writable folder.
        return cast(_F, numba.njit(nogil=True)(function))
