"""The extra `agents`: what trained agents need beside the client, and the one command that installs it."""

from collections.abc import Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING

from arramon_client.errors import AgentLoadError

if TYPE_CHECKING:
    from agents.learning.agent import LearnedAgent

PLAYING = ("torch", "safetensors")
"""Modules that every trained agent needs to play."""

COMMAND = "scripts/setup"
"""Installs the extra in a clone of the repository."""


def require(modules: Sequence[str], who: str) -> None:
    """Check that modules are installed.

    Args:
        modules: names of modules.
        who: what needs them, for the message.

    Raises:
        AgentLoadError: if one is missing; the message names the command that installs it.
    """
    missing = [name for name in modules if find_spec(name) is None]
    if missing:
        raise AgentLoadError(
            f"{who} needs {' and '.join(missing)}: install the extra with `{COMMAND}` in a clone of the repository, "
            "or `pip install 'arramon-server[agents]'`"
        )


def open_agent(
    name: str,
    weights: str | None = None,
    seed: int = 0,
    temperature: float | None = None,
    needs: Sequence[str] = PLAYING,
) -> "LearnedAgent":
    """Return a trained agent.

    Args:
        name: under which it plays; also of its weights among those that come along.
        weights: a file of other weights.
        seed: of the draws, where there are any.
        temperature: 0 takes the best action; above, actions are drawn by their values divided by it. None for that
            with which the weights were validated.
        needs: modules that it needs.

    Raises:
        AgentLoadError: if the extra is not installed, or the weights cannot be read.
    """
    require(needs, f"agents.{name}")
    import torch

    from agents.learning.agent import LearnedAgent
    from agents.learning.checkpoint import find_weights, load_policy

    torch.set_num_threads(1)  # A step is small: threads that wait for each other cost more than they do.
    try:
        policy = load_policy(find_weights(weights or name))
    except ValueError as error:
        raise AgentLoadError(f"agents.{name}: {error}") from error
    if temperature is None:
        temperature = float(policy.about.get("recipe", {}).get("temperature", 0.0))
    return LearnedAgent(policy, name=name, seed=seed, temperature=temperature)
