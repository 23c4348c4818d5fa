"""Optional dependencies of trained agents (extras of arramon-agents): a check that they are installed."""

from collections.abc import Sequence
from importlib.util import find_spec

from arramon_client.errors import AgentLoadError

REQUIRED_AT_PLAY = ("torch", "safetensors")
"""Modules that all trained agents need at play."""

COMMAND = "scripts/setup"
"""Command that installs the extras in a clone of the repository."""


def require(modules: Sequence[str], who: str, extra: str = "torch") -> None:
    """Check that modules are installed.

    Args:
        modules: names of modules.
        who: name of the component that needs them, for the message.
        extra: extra of arramon-agents that installs them.

    Raises:
        AgentLoadError: if a module is missing; the message names the command that installs it.
    """
    missing = [name for name in modules if find_spec(name) is None]
    if missing:
        raise AgentLoadError(
            f"{who} needs {' and '.join(missing)}: install the extra with `{COMMAND}` in a clone of the repository, "
            f"or `pip install 'arramon-agents[{extra}]'`"
        )
