"""Pictures for people: maps of an episode, and the agent's views along its ground truth."""

from arramon_dataset.pictures.episode import show, show_section

__all__ = ["show", "show_section"]
