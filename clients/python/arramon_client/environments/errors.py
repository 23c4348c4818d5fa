"""Errors of the environments, in Gymnasium's own tree."""

import gymnasium


class BadArgument(gymnasium.error.Error, ValueError):
    """An argument names something that there is not, or contradicts another; the message says what there is."""


class UnknownArgument(BadArgument, TypeError):
    """There is no argument of that name: a TypeError as well, as Python's own, which libraries look for."""


class NoBackend(gymnasium.error.DependencyNotInstalled):
    """The server package, which plays in process, is not installed, and no host was named."""


class CannotCopy(gymnasium.error.Error, TypeError):
    """An environment cannot be pickled or copied, or a pickled one cannot be restored; the message says why."""
