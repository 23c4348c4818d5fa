"""Pictures of episodes for people: maps, and the agent's views along the ground truth."""

from arramon_dataset.pictures.episode import show, show_section

__all__ = ["show", "show_section"]
