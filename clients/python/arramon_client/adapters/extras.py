"""The packages of the frameworks, imported with an error that names the extra to install."""

from collections.abc import Iterator
from contextlib import contextmanager

from arramon_client.errors import UsageError


@contextmanager
def extra(name: str) -> Iterator[None]:
    """Import packages of an extra of this distribution.

    Args:
        name: name of the extra.

    Raises:
        UsageError: if a package that is imported in the context is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        raise UsageError(
            f"{error.name} is not installed: install the extra {name!r}, with pip install 'arramon-client[{name}]'"
        ) from error
