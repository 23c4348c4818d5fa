"""What agents remember of the world, and how they move on it: map of the ground, landmarks, the assembly room."""
