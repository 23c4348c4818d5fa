"""Memory of what an agent has seen: labels of one frame, landmarks on a map, the contents of the room."""
