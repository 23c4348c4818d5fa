"""Pictures for people: an episode from above, and through the agent's eyes."""

from server.show.episode import show

__all__ = ["show"]
