"""Cameras and environments: frames and steps per second, and how well the cameras agree."""
