"""Optional dependencies of trained agents (extras of arramon-agents): a check that they are installed."""

from collections.abc import Sequence
from importlib.util import find_spec

from arramon_client.errors import AgentLoadError

PLAYING = ("torch", "safetensors")
"""Modules that every trained agent imports at play."""

COMMAND = "scripts/setup"
"""Installs the extras in a clone of the repository."""


def require(modules: Sequence[str], who: str, extra: str = "torch") -> None:
    """Check that modules are installed.

    Args:
        modules: names of modules.
        who: what needs them, for the message.
        extra: of arramon-agents, which brings them.

    Raises:
        AgentLoadError: if one is missing; the message names the command that installs it.
    """
    missing = [name for name in modules if find_spec(name) is None]
    if missing:
        raise AgentLoadError(
            f"{who} needs {' and '.join(missing)}: install the extra with `{COMMAND}` in a clone of the repository, "
            f"or `pip install 'arramon-agents[{extra}]'`"
        )
