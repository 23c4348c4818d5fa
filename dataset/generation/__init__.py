"""Generation of the data set: episodes drawn from a seed in the project's own sections, and validated."""

from arramon_dataset.generation.check import problems
from arramon_dataset.generation.draft import Draft
from arramon_dataset.generation.drawing import DraftSampler
from arramon_dataset.generation.site import Site, Writer
from arramon_dataset.layout.solids import Solids

__all__ = ["Draft", "DraftSampler", "Site", "Solids", "Writer", "problems"]
