"""Generation of the data set: random, validated episodes in the project's own sections, reproducible from a seed."""

from arramon_dataset.generation.check import faults_of_episode
from arramon_dataset.generation.draft import Draft
from arramon_dataset.generation.draft_sampler import DraftSampler
from arramon_dataset.generation.draft_writer import DraftWriter
from arramon_dataset.generation.site import GenerationSite
from arramon_dataset.layout.solids import Solids

__all__ = ["Draft", "DraftSampler", "DraftWriter", "GenerationSite", "Solids", "faults_of_episode"]
