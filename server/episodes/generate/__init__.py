"""Makes the data set: episodes in the project's own sections, drawn from a seed, checked, told in every language."""

from server.episodes.generate.check import problems
from server.episodes.generate.draft import Draft, Writer
from server.episodes.generate.drawing import Drawer
from server.episodes.generate.solids import Solids

__all__ = ["Draft", "Drawer", "Solids", "Writer", "problems"]
