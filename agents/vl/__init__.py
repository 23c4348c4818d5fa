"""Agent that reads and sees, by the paper's model (section 5) in its own sizes. It needs the extra `torch`.

`config.py` holds the sizes, `model.py` the network, `agent.py` how it plays, `recipe.py`, `task.py` and `train.py` how
it is trained, `card.md` how its weights were.
Other agents are configurations of it (`make_factory`): they differ in what their weights were trained with.
"""

from collections.abc import Callable, Sequence

from arramon_agents.requirements import PLAYING, require
from arramon_client.agent import Agent
from arramon_client.errors import AgentLoadError

__all__ = ["make_agent", "make_factory"]


def make_factory(name: str, needs: Sequence[str] = PLAYING) -> Callable[..., Agent]:
    """Return the function `make_agent` of an agent that plays by the paper's model.

    Args:
        name: of the agent, and of the folder that holds its shipped weights.
        needs: modules that it imports.
    """

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
