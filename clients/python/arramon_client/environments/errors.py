"""Errors of the environments, in Gymnasium's own tree."""

import gymnasium


class BadArgument(gymnasium.error.Error, ValueError):
    """An argument names something that there is not, or contradicts another; the message says what there is."""


class NoBackend(gymnasium.error.DependencyNotInstalled):
    """The server package, which plays in process, is not installed, and no host was named."""
