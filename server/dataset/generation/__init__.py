"""Generation of the data set: episodes drawn from a seed in the project's own sections, and validated."""

from server.dataset.generation.check import problems
from server.dataset.generation.draft import Draft
from server.dataset.generation.drawing import DraftSampler
from server.dataset.generation.site import Site, Writer
from server.dataset.layout.solids import Solids

__all__ = ["Draft", "DraftSampler", "Site", "Solids", "Writer", "problems"]
