"""Agent that plays by the paper's vision-and-language model (section 5), in smaller sizes (extra `torch`).

`config.py` has the sizes, `model.py` the network, `agent.py` the player, `recipe.py`, `task.py` and `train.py` the
training, and `card.md` is the model card of the shipped weights. Other agents are the same code with other weights
(`make_factory`).
"""

from collections.abc import Callable, Sequence

from arramon_agents.requirements import REQUIRED_AT_PLAY, require
from arramon_client.agent import Agent
from arramon_client.errors import AgentLoadError

__all__ = ["make_agent", "make_factory"]


def make_factory(name: str, needs: Sequence[str] = REQUIRED_AT_PLAY) -> Callable[..., Agent]:
    """Return the function `make_agent` of an agent that plays by the paper's model.

    Args:
        name: name of the agent, and of the folder with its shipped weights.
        needs: optional modules that it imports.
    """

    def make_agent(weights: str | None = None, seed: int = 0, temperature: float | None = None) -> Agent:
        """Return the agent, with the shipped weights or others.

        Args:
            weights: a file written by `arramon-train`; None for the shipped one.
            seed: seed for sampling actions, used if the temperature is above 0.
            temperature: softmax temperature for sampling actions; 0 takes the best action. None for the temperature
                that the weights were validated with.

        Raises:
            AgentLoadError: if an extra is not installed, or the weights cannot be read.
        """
        require(needs, f"agents.{name}")
        from arramon_agents.process_settings import prepare_process
        from arramon_agents.vl.agent import LearnedAgent
        from arramon_agents.vl.policy import load_policy
        from arramon_agents.weights import find_weights

        prepare_process()
        try:
            policy = load_policy(find_weights(weights or name))
        except ValueError as error:
            raise AgentLoadError(f"agents.{name}: {error}") from error
        if temperature is None:
            temperature = float(policy.about.get("recipe", {}).get("temperature", 0.0))
        return LearnedAgent(policy, name=name, seed=seed, temperature=temperature)

    return make_agent


make_agent = make_factory("vl")
