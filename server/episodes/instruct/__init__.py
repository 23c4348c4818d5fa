"""From ground truth and what the camera sees of it to what an instruction means, and whether it leads there."""
