"""The packages of the frameworks, imported with an error that names the extra to install."""

from importlib import import_module
from types import ModuleType

from arramon_client.errors import UsageError


def require(module: str, extra: str) -> ModuleType:
    """Return a module of an optional package.

    Args:
        module: name of the module.
        extra: extra of this distribution that installs it.

    Raises:
        UsageError: if the package is not installed.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise UsageError(
            f"{error.name} is not installed: install the extra {extra!r}, with pip install 'arramon-client[{extra}]'"
        ) from error
