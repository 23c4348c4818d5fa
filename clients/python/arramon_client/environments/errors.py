"""Exceptions of the environments, derived from Gymnasium's own."""

import gymnasium


class BadArgument(gymnasium.error.Error, ValueError):
    """An argument names something unknown, or contradicts another one; the message states what was expected."""


class UnknownArgument(BadArgument, TypeError):
    """There is no argument with that name. It is also a TypeError, which libraries look for."""


class NoBackend(gymnasium.error.DependencyNotInstalled):
    """The server package, required to play in this process, is not installed, and no host was named."""


class CannotCopy(gymnasium.error.Error, TypeError):
    """An environment cannot be pickled or copied, or a pickled one cannot be restored; the message says why."""
