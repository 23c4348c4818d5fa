"""Loading of the agent named by `--agent`, with error messages for the agent's author."""

import difflib
import importlib
import pkgutil
import sys
from collections.abc import Callable, Iterable, Mapping
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import cast

from arramon_client.agent import Agent
from arramon_client.errors import AgentLoadError
from arramon_client.plugin import agent_calls, agent_files
from arramon_client.plugin.arguments import check_signature
from arramon_client.plugin.candidates import default_member
from arramon_client.plugin.tracebacks import own_frames

ENTRY_POINTS = "arramon.agents"
"""Entry-point group in which installed packages register agents by name, such as `agents.vl`."""

OWN_PREFIX = "agents."
"""Prefix of the names of the project's own agents, which are in the package arramon-agents."""


def load_agent(spec: str, arguments: Mapping[str, object] = MappingProxyType({})) -> Agent:
    """Load and construct the agent that `spec` names.

    Args:
        spec: one of

            - the name of an entry point in the group `arramon.agents`, such as `agents.vl`;
            - `package.module`, whose class `Agent`, function `make_agent()` or only agent class is called;
            - `path/to/file.py`, the same for a file, whose folder is searched for what it imports;
            - `package.module:Name` or `path/to/file.py:Name`, a class or function to call, or an agent itself.

            Entry points take precedence. Modules are searched for in the working directory first, as with `python -m`;
            a folder needs an `__init__.py` only if an installed package has the same name.
        arguments: keyword arguments for the class or function.

    Raises:
        AgentLoadError: if nothing has that name, or it cannot be imported or constructed, does not accept these
            arguments or requires others, or is not an agent. `details` holds the agent's own traceback if there is one.
    """
    _make_working_directory_importable()
    path, attribute = agent_files.split_spec(spec)
    name = path
    if not path:
        name, _, attribute = spec.partition(":")
    entry = _entry_points().get(name)
    if entry is not None:
        module = _import(entry.module, spec)
        attribute = attribute or entry.attr
    else:
        _check_spelling(spec, name, attribute, is_file=bool(path))
        module = agent_files.load_file(Path(path), spec) if path else _import(name, spec)
    found = _member(module, attribute) if attribute else default_member(module)
    made = _make(found, spec, arguments)
    _check_is_agent(made, spec)
    return cast(Agent, made)


def _make_working_directory_importable() -> None:
    here = str(Path.cwd())
    if "" not in sys.path and here not in sys.path:
        sys.path.insert(0, here)


def _entry_points() -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in entry_points(group=ENTRY_POINTS)}


def _check_spelling(spec: str, name: str, attribute: str, *, is_file: bool) -> None:
    is_path = "/" in name or "\\" in name
    is_module = not is_path and all(part.isidentifier() for part in name.split("."))
    if not (is_module or is_file) or (spec.endswith(":") and not attribute):
        hint = ""
        if is_path:
            dotted = name.replace("\\", "/").strip("./").replace("/", ".")
            hint = f" A file's name ends in .py; name a package as a module, e.g. --agent {dotted}."
        raise AgentLoadError(f"--agent {spec!r} is neither a module, a file, a module:Class nor an entry point.{hint}")


def _import(name: str, spec: str) -> ModuleType:
    """Import a module, with different errors for a missing module and for one that fails to import."""
    importlib.invalidate_caches()
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        # If the missing module is not a part of this dotted name, the module itself exists and imports a missing one.
        if error.name is not None and (name == error.name or name.startswith(error.name + ".")):
            raise AgentLoadError(_no_such_module(error.name, spec)) from error
        raise AgentLoadError(
            f"agent {spec}: it imports {error.name}, which is not installed", own_frames(error)
        ) from error
    except (Exception, SystemExit) as error:
        raise AgentLoadError(f"agent {spec}: its module {name} cannot be imported", own_frames(error)) from error


def _no_such_module(missing: str, spec: str) -> str:
    parent, _, _ = missing.rpartition(".")
    known: Iterable[str] = (info.name for info in pkgutil.iter_modules())
    if parent:
        prefix = parent + "."
        known = (info.name for info in pkgutil.iter_modules(sys.modules[parent].__path__, prefix))
    registered = _entry_points()
    candidates = [*registered, *(entry.module for entry in registered.values()), *sorted(known)]
    # Top-level names need a closer match: an environment has so many modules that a weak match means nothing.
    close = difflib.get_close_matches(missing, candidates, n=1, cutoff=0.6 if parent else 0.8)
    suggestion = f" Did you mean {close[0]}?" if close else ""
    if spec.startswith(OWN_PREFIX) and not any(name.startswith(OWN_PREFIX) for name in registered):
        suggestion = " ArraMon's agents are in the package arramon-agents, which is not installed."
    own = Path(*missing.split(".")).with_suffix(".py")
    if parent and own.is_file():  # A package with an `__init__.py` comes before a folder without one, wherever it is.
        suggestion = (
            f" The file {own} is hidden by the package in {sys.modules[parent].__path__[0]}: name it as ./{own}."
        )
    where = f"in the package {parent}" if parent else f"installed or in the working directory {Path.cwd()}"
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


def _make(found: object, spec: str, arguments: Mapping[str, object]) -> object:
    if not isinstance(found, type) and hasattr(found, "begin") and hasattr(found, "act"):
        if arguments:
            raise AgentLoadError(
                f"agent {spec}: it is an instance, and accepts no --agent-arg; name its class, or a function"
            )
        return found
    if not callable(found):
        raise AgentLoadError(f"agent {spec}: {found!r} is neither an agent nor a class or function that returns one")
    check_signature(found, arguments, spec)
    try:
        return cast(Callable[..., object], found)(**arguments)
    except AgentLoadError:  # The agent's own message says what is missing.
        raise
    except (Exception, SystemExit) as error:
        name = getattr(found, "__name__", repr(found))
        given = ", ".join(f"{each}={value!r}" for each, value in arguments.items())
        raise AgentLoadError(
            f"agent {spec}: {name}({given}) raised {type(error).__name__}: {error}", own_frames(error)
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
            "see arramon_client.agent for an agent's methods"
        )
    fault = agent_calls.fault_of_optional_methods(made)
    if fault:
        raise AgentLoadError(f"agent {spec}: {fault}; see arramon_client.agent for an agent's methods")
