"""Options (discrete choices) of the policy: waypoints by direction and distance, and landmarks to pick up."""

from arramon_agents.vl_map.features import DIRECTIONS, THINGS

DISTANCES = (1.0, 2.2, 4.0, 6.5, 10.0)
"""Distances of waypoints, in units."""

WAYPOINTS = DIRECTIONS * len(DISTANCES)
"""Number of waypoints, indexed direction * len(DISTANCES) + distance. Option WAYPOINTS + i picks up landmark i."""

OPTIONS = WAYPOINTS + THINGS
"""Number of options."""
