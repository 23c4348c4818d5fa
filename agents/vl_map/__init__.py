"""Agent that remembers landmarks and free ground, and chooses waypoints on what it remembers by a learned policy: all
that it sees and reads is learned as well. It needs the extra `torch`."""

from arramon_agents.requirements import PLAYING, require
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
    """Return the agent with the shipped weights, or with others.

    Args:
        weights: a file written by `arramon-train --agent vl_map`.
        sensor: "rgb" to see by RGB and depth alone, "segmentation" to see without errors.
        reader: a file written by `arramon-train --agent reader` or `reader_tuning`; None for the shipped reader.
        mirror: whether the policy is asked about the mirror image too.
        looks: whether it turns around at first, and looks to either side before a decision.
        sums: whether what each view says of a thing is summed; if not, the largest view names it. With RGB alone.

    Raises:
        AgentLoadError: if the extra is not installed, there is no such sensor, or the weights cannot be read.
    """
    if sensor not in SENSORS:
        raise AgentLoadError(f"agents.vl_map has no sensor {sensor!r}; expected one of {', '.join(SENSORS)}")
    require(PLAYING, "agents.vl_map")
    from pathlib import Path

    from arramon_agents.process_settings import prepare_process
    from arramon_agents.reading.reader.reader import load as load_reader
    from arramon_agents.vl_map.agent import SeeingAgent, SegmentationAgent
    from arramon_agents.vl_map.policy import MapPolicy, read_policy
    from arramon_agents.vl_map.room import CellFinder
    from arramon_agents.weights import find_weights

    prepare_process()
    try:
        networks, _ = read_policy(find_weights(weights or "vl_map"))
        reads = load_reader(Path(reader) if reader else None)
    except ValueError as error:
        raise AgentLoadError(f"agents.vl_map: {error}") from error
    parts = MapPolicy(networks.policy, mirrored=mirror), CellFinder(networks.placer)
    if sensor == "rgb":
        return SeeingAgent(*parts, reader=reads, looks=looks, sums=sums)
    return SegmentationAgent(*parts, reads, looks=looks)
