"""Agent that reads and sees, by the paper's model (section 5) in its own sizes. It needs the extra `agents`."""

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
        AgentLoadError: if the extra is not installed, or the weights cannot be read.
    """
    return open_agent("vl", weights, seed, temperature)
