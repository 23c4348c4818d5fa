"""Makes the data set: episodes in the project's own sections, drawn from a seed, checked, told in every language."""

from server.episodes.generate.check import problems
from server.episodes.generate.draft import Draft
from server.episodes.generate.drawing import Drawer
from server.episodes.generate.site import Site, Writer
from server.episodes.solids import Solids

__all__ = ["Draft", "Drawer", "Site", "Solids", "Writer", "problems"]
