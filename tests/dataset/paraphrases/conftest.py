"""The first paraphrased episode and its site."""

import pytest

from server.dataset.generation.site import Site
from server.dataset.paraphrases.collection import generated_episodes, paraphrased_section
from server.dataset.plans import read_plan
from server.episodes.episode import Episode


@pytest.fixture(scope="session")
def site() -> Site:
    return Site(paraphrased_section(), read_plan("6"))


@pytest.fixture(scope="session")
def episode() -> Episode:
    return generated_episodes()[0]
