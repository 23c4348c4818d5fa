"""Choice of the agent in a module, if `--agent` names only the module."""

import inspect
from types import FunctionType, ModuleType

from arramon_client.errors import AgentLoadError

METHODS = ("begin", "act")
"""Methods that every agent has; `end` is optional."""


def default_member(module: ModuleType) -> object:
    """Return the module's `Agent`, else its function `make_agent`, else its only class with an agent's methods.

    Imported classes are not candidates, unless they come from the module's own package: a package's `__init__.py` may
    import its `Agent`. Base classes of others in the module, abstract classes and private ones are not either.

    Raises:
        AgentLoadError: if there is no candidate, or several; the message says how to name one.
    """
    named = getattr(module, "Agent", None)
    if named is not None and _is_own(named, module) and (_has_methods(named) or not isinstance(named, type)):
        return named
    factory = getattr(module, "make_agent", None)
    if factory is not None:
        return factory
    candidates = _candidates(module)
    if len(candidates) == 1:
        return candidates[0]
    if not candidates and named is not None and _is_own(named, module):
        return named  # The caller reports the missing method.
    raise AgentLoadError(_describe(module, candidates, named))


def _describe(module: ModuleType, candidates: list[type], named: object) -> str:
    name = module.__name__
    if candidates:
        listed = ", ".join(f":{each.__name__}" for each in candidates)
        return (
            f"the module {name} has several agents: name one, as in --agent {name}:{candidates[0].__name__} ({listed})"
        )
    said = (
        f"the module {name} has neither a class Agent nor a function make_agent() nor another class with begin and act"
    )
    classes = [each for each in vars(module).values() if isinstance(each, type) and _is_own(each, module)]
    if classes:
        listed = ", ".join(each.__name__ for each in classes)
        said += f"; without these methods: {listed}"
    if isinstance(named, type) and not getattr(named, "_is_protocol", False):
        said += f". Its Agent is imported from {named.__module__}: to play with it, write {name}:Agent"
    return said + "."


def _candidates(module: ModuleType) -> list[type]:
    agents = [
        each
        for name, each in vars(module).items()
        if not name.startswith("_")
        and isinstance(each, type)
        and _is_own(each, module)
        and _has_methods(each)
        and not inspect.isabstract(each)
        and not getattr(each, "_is_protocol", False)
    ]
    agents = list(dict.fromkeys(agents))
    return [each for each in agents if not any(other is not each and issubclass(other, each) for other in agents)]


def _is_own(value: object, module: ModuleType) -> bool:
    """Return whether a value was defined in a module or its submodules, rather than imported from elsewhere.

    Only classes and functions name their own module. The `__module__` of other objects, such as a `functools.partial`,
    is that of their class, so they count as defined in the module.
    """
    if not isinstance(value, type | FunctionType):
        return True
    own = module.__name__
    return value.__module__ == own or value.__module__.startswith(f"{own}.")


def _has_methods(value: object) -> bool:
    return all(callable(getattr(value, name, None)) for name in METHODS)
