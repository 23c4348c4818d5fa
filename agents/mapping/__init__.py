"""Mapping and planning of agents: ground map, landmarks, assembly room, and path planning on them."""
