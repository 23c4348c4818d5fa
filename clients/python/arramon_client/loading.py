"""Turns what `--agent` names into an agent, and every way in which that fails into a message for the agent's author."""

import difflib
import importlib
import importlib.util
import pkgutil
import sys
from collections.abc import Callable, Iterable
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import cast

from arramon_client import agent as contract
from arramon_client.agent import Agent
from arramon_client.errors import AgentLoadError
from arramon_client.tracebacks import own_frames

ENTRY_POINTS = "arramon.agents"
"""The group in which an installed package may register its agents by name."""


def load_agent(spec: str) -> Agent:
    """The agent that `spec` names, made.

    Args:
        spec: the name of an entry point in the group `arramon.agents`; or `package.module`, whose `Agent` class or
            `make_agent()` is called without arguments; or `package.module:Name`, a class or function to call so, or an
            agent itself. Modules of the current working directory can be named, as with `python -m`.

    Raises:
        AgentLoadError: if there is no such thing, or it cannot be imported or made, or is no agent. Its `details` hold
            the agent's own traceback where there is one.
    """
    _make_working_directory_importable()
    entry = _entry_points().get(spec)
    if entry is not None:
        made = _make(_load_entry_point(entry), spec)
    else:
        name, _, attribute = spec.partition(":")
        _check_spelling(spec, name, attribute)
        module = _import(name, spec)
        made = _make(_member(module, attribute) if attribute else _default_member(module), spec)
    _check_is_agent(made, spec)
    return cast(Agent, made)


def _make_working_directory_importable() -> None:
    here = str(Path.cwd())
    if "" not in sys.path and here not in sys.path:
        sys.path.insert(0, here)


def _entry_points() -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in entry_points(group=ENTRY_POINTS)}


def _load_entry_point(entry: EntryPoint) -> object:
    module = _import(entry.module, entry.name)
    return _member(module, entry.attr) if entry.attr else _default_member(module)


def _check_spelling(spec: str, name: str, attribute: str) -> None:
    is_path = name.endswith(".py") or "/" in name or "\\" in name
    if is_path or not all(part.isidentifier() for part in name.split(".")) or (":" in spec and not attribute):
        hint = ""
        if is_path:
            dotted = name.removesuffix(".py").replace("\\", "/").strip("./").replace("/", ".")
            hint = f" Give it as a module, such as --agent {dotted}, from the folder that it is in."
        raise AgentLoadError(f"--agent {spec!r} is neither a module, a module:Class nor an installed name.{hint}")


def _import(name: str, spec: str) -> ModuleType:
    """Imports a module, and tells a module that is not there from one that cannot be imported."""
    importlib.invalidate_caches()
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        # Only a missing part of the dotted name itself means "no such module"; another name is missing inside of it.
        if error.name is not None and (name == error.name or name.startswith(error.name + ".")):
            raise AgentLoadError(_no_such_module(error.name, spec)) from error
        raise AgentLoadError(
            f"agent {spec}: it needs {error.name}, which is not installed", own_frames(error)
        ) from error
    except (Exception, SystemExit) as error:
        raise AgentLoadError(f"agent {spec}: its module {name} cannot be imported", own_frames(error)) from error


def _no_such_module(missing: str, spec: str) -> str:
    parent, _, _ = missing.rpartition(".")
    known: Iterable[str] = (info.name for info in pkgutil.iter_modules())
    if parent:
        prefix = parent + "."
        known = (info.name for info in pkgutil.iter_modules(sys.modules[parent].__path__, prefix))
    candidates = [*_entry_points(), *sorted(known)]
    close = difflib.get_close_matches(missing, candidates, n=1, cutoff=0.6)
    suggestion = f" Did you mean {close[0]}?" if close else ""
    where = f"in the package {parent}" if parent else f"installed, nor in the working directory {Path.cwd()}"
    return f"no agent {spec!r}: there is no module {missing} {where}.{suggestion}"


def _member(module: ModuleType, attribute: str) -> object:
    found: object = module
    for part in attribute.split("."):
        if not hasattr(found, part):
            close = difflib.get_close_matches(part, dir(found), n=1)
            suggestion = f" Did you mean {close[0]}?" if close else ""
            raise AgentLoadError(f"the module {module.__name__} has no {attribute}.{suggestion}")
        found = getattr(found, part)
    return found


def _default_member(module: ModuleType) -> object:
    """`Agent` or `make_agent` of the module; the contract's own `Agent`, imported for its type, does not count."""
    for name in ("Agent", "make_agent"):
        found = getattr(module, name, None)
        if found is not None and found is not contract.Agent:
            return found
    classes = [
        name for name, value in vars(module).items() if isinstance(value, type) and value.__module__ == module.__name__
    ]
    hint = f" Name one of its classes: {', '.join(f'{module.__name__}:{name}' for name in classes)}." if classes else ""
    raise AgentLoadError(f"the module {module.__name__} has neither a class Agent nor a function make_agent().{hint}")


def _make(found: object, spec: str) -> object:
    if not isinstance(found, type) and hasattr(found, "begin") and hasattr(found, "act"):
        return found
    if not callable(found):
        raise AgentLoadError(f"agent {spec}: {found!r} is neither an agent nor something to call for one")
    try:
        return cast(Callable[[], object], found)()
    except (Exception, SystemExit) as error:
        name = getattr(found, "__name__", repr(found))
        raise AgentLoadError(
            f"agent {spec}: {name}() raised {type(error).__name__} (it is called without arguments)", own_frames(error)
        ) from error


def _check_is_agent(made: object, spec: str) -> None:
    missing = [
        signature
        for name, signature in (("begin", "begin(episode)"), ("act", "act(observations)"))
        if not callable(getattr(made, name, None))
    ]
    if missing:
        raise AgentLoadError(
            f"agent {spec}: {type(made).__name__} has no method {' and no method '.join(missing)}; "
            "see arramon_client.agent for the two methods of an agent"
        )
