"""Agent that keeps a map of landmarks and free ground, and chooses waypoints on it by a learned policy (extra `torch`).

Perception and reading of instructions are learned as well.
"""

from arramon_agents.requirements import REQUIRED_AT_PLAY, require
from arramon_client.agent import Agent
from arramon_client.errors import AgentLoadError

__all__ = ["make_agent"]

SENSORS = ("rgb", "segmentation")


def make_agent(
    weights: str | None = None,
    sensor: str = SENSORS[0],
    reader: str | None = None,
    mirror: bool = True,
    looks: bool = True,
    sums: bool = True,
) -> Agent:
    """Return the agent, with the shipped weights or others.

    Args:
        weights: a file written by `arramon-train --agent vl_map`; None for the shipped one.
        sensor: "rgb" to perceive by the visual encoder, from RGB and depth; "segmentation" for perfect perception.
        reader: a file written by `arramon-train --agent reader` or `reader_tuning`; None for the shipped reader.
        mirror: whether to average the policy over the input and its mirror image.
        looks: whether to turn around at the start, and to look to both sides before a decision.
        sums: whether to sum log probabilities over all views of a thing; otherwise its largest view names it. Only
            with the sensor "rgb".

    Raises:
        AgentLoadError: if the extra is not installed, there is no such sensor, or the weights cannot be read.
    """
    if sensor not in SENSORS:
        raise AgentLoadError(f"agents.vl_map has no sensor {sensor!r}; expected one of {', '.join(SENSORS)}")
    require(REQUIRED_AT_PLAY, "agents.vl_map")
    from pathlib import Path

    from arramon_agents.process_settings import prepare_process
    from arramon_agents.reading.reader.reader import load as load_reader
    from arramon_agents.vl_map.agent import SeeingAgent, SegmentationAgent
    from arramon_agents.vl_map.placement_network import CellFinder
    from arramon_agents.vl_map.policy import MapPolicy, read_policy
    from arramon_agents.weights import find_weights

    prepare_process()
    try:
        networks, _ = read_policy(find_weights(weights or "vl_map"))
        reads = load_reader(Path(reader) if reader else None)
    except ValueError as error:
        raise AgentLoadError(f"agents.vl_map: {error}") from error
    parts = MapPolicy(networks.policies, mirrored=mirror), CellFinder(networks.placer)
    if sensor == "rgb":
        return SeeingAgent(*parts, reader=reads, looks=looks, sums=sums)
    return SegmentationAgent(*parts, reads, looks=looks)
