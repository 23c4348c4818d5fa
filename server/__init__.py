"""The ArraMon evaluation server."""

from importlib.metadata import version

__version__ = version("arramon-server")
