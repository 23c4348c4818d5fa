"""Loading of agents from files: `--agent ./my_agent.py`, `my_agent.py:Mine`, or an absolute path."""

import difflib
import importlib
import importlib.machinery
import importlib.util
import sys
from pathlib import Path
from types import ModuleType

from arramon_client.errors import AgentLoadError
from arramon_client.plugin.tracebacks import own_frames

SUFFIX = ".py"


def split_spec(spec: str) -> tuple[str, str]:
    """Split the value of `--agent` into a file's path and the name after the colon; ("", "") if it names no file."""
    if spec.endswith(SUFFIX):
        return spec, ""
    path, colon, attribute = spec.rpartition(":")
    return (path, attribute) if colon and path.endswith(SUFFIX) else ("", "")


def agent_label(spec: str) -> str:
    """Return an agent's name for results and the leaderboard; a file is named without its folder and suffix."""
    path, attribute = split_spec(spec)
    label = f"{Path(path).stem}:{attribute}".removesuffix(":") if path else spec
    return label.removesuffix(":Agent")


def load_file(path: Path, spec: str) -> ModuleType:
    """Import a file as a module with the file's name; as with `python FILE`, its folder is searched first for imports.

    Args:
        path: the file.
        spec: the value of `--agent`, for messages.

    Raises:
        AgentLoadError: if there is no such file, or it cannot be imported; `details` holds its traceback.
    """
    path = path.expanduser().absolute()
    if not path.is_file():
        raise AgentLoadError(_no_such_file(path, spec))
    folder = str(path.parent)
    if folder not in sys.path:
        sys.path.insert(0, folder)
    importlib.invalidate_caches()
    name = _module_name(path)
    known = sys.modules.get(name)
    if known is not None and _is_at(known.__spec__, path):
        return known
    found = importlib.util.spec_from_file_location(name, path)
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    sys.modules[name] = module
    try:
        found.loader.exec_module(module)
    except BaseException as error:
        del sys.modules[name]
        if isinstance(error, ModuleNotFoundError) and error.name is not None:
            reason = f"it imports {error.name}, which is neither installed nor in {folder}"
        elif isinstance(error, Exception | SystemExit):
            reason = f"the file {path} cannot be imported"
        else:
            raise
        raise AgentLoadError(f"agent {spec}: {reason}", own_frames(error)) from error
    return module


def _module_name(path: Path) -> str:
    """Return the file's own name if importing that name finds the file; else a name that hides no other module."""
    name = path.stem
    if not name.isidentifier():
        return f"agent_file_{''.join(letter if letter.isalnum() else '_' for letter in name)}"
    loaded = sys.modules.get(name)
    try:
        found = loaded.__spec__ if loaded is not None else importlib.util.find_spec(name)
    except (ImportError, ValueError):  # ValueError: a module without a specification, such as __main__
        found = None
    return name if _is_at(found, path) else f"agent_file_{name}"


def _is_at(found: "importlib.machinery.ModuleSpec | None", path: Path) -> bool:
    return found is not None and found.origin is not None and Path(found.origin).absolute() == path


def _no_such_file(path: Path, spec: str) -> str:
    if path.is_dir():
        return f"no agent {spec!r}: {path} is a folder, expected a file"
    beside = [each.name for each in path.parent.glob(f"*{SUFFIX}")] if path.parent.is_dir() else []
    close = difflib.get_close_matches(path.name, beside, n=1)
    suggestion = f" Did you mean {close[0]}?" if close else ""
    return f"no agent {spec!r}: there is no file {path}.{suggestion}"
