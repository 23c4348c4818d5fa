"""How the rasteriser is compiled, and where compiled code is kept."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core.options import DefaultOptions

_F = TypeVar("_F", bound=Callable[..., Any])

_OPTIONS: dict[str, Any] = {"error_model": "numpy"}
if hasattr(DefaultOptions, "_nrt"):
    # No array is made in compiled code: without counting who refers to them, drawing takes two thirds of the time.
    _OPTIONS["_nrt"] = False


def inlined(function: _F) -> _F:
    """Compiled into whoever calls it: to pass groups of arrays on is dear."""
    return cast(_F, numba.njit(function, forceinline=True, **_OPTIONS))


def kept(function: _F) -> _F:
    """Compiled when first called, and kept on disk; without a folder that can be written, anew in every process.

    The code on disk is renewed when the function's own file changes, and only then: all that it calls must be there.
    """
    try:
        return cast(_F, numba.njit(function, cache=True, **_OPTIONS))
    except RuntimeError:  # numba found no such folder
        return cast(_F, numba.njit(function, **_OPTIONS))


def is_compiled(function: Any) -> bool:
    """Whether a `kept` function is compiled, in this process or on disk."""
    if function.signatures:
        return True
    if function.stats.cache_path is None:
        return False
    source = Path(function.py_func.__code__.co_filename)
    files = Path(function.stats.cache_path).glob(f"{source.stem}.{function.py_func.__name__}-*.nbi")
    return any(file.stat().st_mtime >= source.stat().st_mtime for file in files)
