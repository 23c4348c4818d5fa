"""Agent that attends to the words at each step and matches them with what it sees (extra `torch`)."""

from arramon_agents.requirements import REQUIRED_AT_PLAY, require
from arramon_client.agent import Agent
from arramon_client.errors import AgentLoadError

__all__ = ["make_agent"]

SENSORS = ("rgb", "segmentation")


def make_agent(weights: str | None = None, sensor: str = SENSORS[0]) -> Agent:
    """Return the agent with the shipped weights, or with others.

    Args:
        weights: a file written by `arramon-train --agent vl_grounded`.
        sensor: "rgb" to perceive by the visual encoder, from RGB and depth; "segmentation" for perfect perception.

    Raises:
        AgentLoadError: if the extra is not installed, there is no such sensor, or the weights cannot be read.
    """
    if sensor not in SENSORS:
        raise AgentLoadError(f"agents.vl_grounded has no sensor {sensor!r}; expected one of {', '.join(SENSORS)}")
    require(REQUIRED_AT_PLAY, "agents.vl_grounded")
    from arramon_agents.perception.eyes.encoder import load as load_eyes
    from arramon_agents.process_settings import prepare_process
    from arramon_agents.vl_grounded.agent import GroundedAgent
    from arramon_agents.vl_grounded.network import read_weights
    from arramon_agents.vl_grounded.perception import EncoderPerception, SegmentationPerception
    from arramon_agents.weights import find_weights

    prepare_process()
    eyes = load_eyes()
    try:
        found = read_weights(find_weights(weights or "vl_grounded"))
    except ValueError as error:
        raise AgentLoadError(f"agents.vl_grounded: {error}") from error
    if found.eyes != eyes.fingerprint:
        raise AgentLoadError(
            f"agents.vl_grounded: its weights were trained on the visual encoder {found.eyes}, but {eyes.fingerprint} "
            "is installed"
        )
    return GroundedAgent(found, EncoderPerception(eyes) if sensor == SENSORS[0] else SegmentationPerception())
