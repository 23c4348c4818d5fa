"""Decorators that compile the rasteriser with numba, with an on-disk cache."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core.options import DefaultOptions

_F = TypeVar("_F", bound=Callable[..., Any])

# Without Python's lock: meanwhile other threads encode images, and gRPC's own move bytes.
_OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True}
if hasattr(DefaultOptions, "_nrt"):
    # Compiled code allocates no arrays: without reference counting, drawing takes two thirds of the time.
    _OPTIONS["_nrt"] = False


def inlined(function: _F) -> _F:
    """Compile a function inline into its callers, as passing groups of arrays is expensive."""
    return cast(_F, numba.njit(function, forceinline=True, **_OPTIONS))


def cached(function: _F) -> _F:
    """Compile a function when it is first called, and cache the code on disk, or in memory if no folder is writable.

    The code on disk is renewed only when the function's own file changes, so all its callees must be in that file.
    """
    try:
        return cast(_F, numba.njit(function, cache=True, **_OPTIONS))
    except RuntimeError:  # numba found no writable folder
        return cast(_F, numba.njit(function, **_OPTIONS))


def is_compiled(function: Any) -> bool:
    """Return whether a `cached` function is compiled, in this process or on disk."""
    if function.signatures:
        return True
    if function.stats.cache_path is None:
        return False
    source = Path(function.py_func.__code__.co_filename)
    files = Path(function.stats.cache_path).glob(f"{source.stem}.{function.py_func.__name__}-*.nbi")
    return any(file.stat().st_mtime >= source.stat().st_mtime for file in files)
