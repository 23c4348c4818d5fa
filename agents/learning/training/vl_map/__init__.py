"""Training of `vl_map`: its policy, and the network that finds the room's cell."""
