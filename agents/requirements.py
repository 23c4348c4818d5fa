"""Optional dependencies of trained agents (the extra `agents`): check that they are installed, then open an agent."""

from collections.abc import Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING

from arramon_client.errors import AgentLoadError

if TYPE_CHECKING:
    from arramon_agents.vl.agent import LearnedAgent

PLAYING = ("torch", "safetensors")
"""Modules that every trained agent imports at play."""

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
        name: of the agent, and of its shipped weights.
        weights: path of other weights; None for the shipped ones.
        seed: for sampling actions, where the temperature is above 0.
        temperature: of the softmax from which actions are sampled; 0 takes the best action. None for the one with
            which the weights were validated.
        needs: modules that it imports.

    Raises:
        AgentLoadError: if the extra is not installed, or the weights cannot be read.
    """
    require(needs, f"agents.{name}")
    from arramon_agents.process_settings import prepare_process
    from arramon_agents.vl.agent import LearnedAgent
    from arramon_agents.weights import find_weights, load_policy

    prepare_process()
    try:
        policy = load_policy(find_weights(weights or name))
    except ValueError as error:
        raise AgentLoadError(f"agents.{name}: {error}") from error
    if temperature is None:
        temperature = float(policy.about.get("recipe", {}).get("temperature", 0.0))
    return LearnedAgent(policy, name=name, seed=seed, temperature=temperature)
