"""The first paraphrased episode and its site."""

import pytest

from arramon_dataset.generation.site import GenerationSite
from arramon_dataset.paraphrases.collection import generated_episodes, paraphrased_section
from arramon_dataset.plans import read_plan
from arramon_server.episodes.episode import Episode


@pytest.fixture(scope="session")
def site() -> GenerationSite:
    return GenerationSite(paraphrased_section(), read_plan("6"))


@pytest.fixture(scope="session")
def episode() -> Episode:
    return generated_episodes()[0]
