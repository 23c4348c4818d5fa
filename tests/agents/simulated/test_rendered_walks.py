"""Walks in rendered streets: labelled as in simulated ones, and the same in one process and in two."""

import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from arramon_agents.reading.reader.reader import load  # noqa: E402
from arramon_agents.simulated import rendered_walks  # noqa: E402
from arramon_agents.simulated.courses import TrainingCourses, training_courses  # noqa: E402
from arramon_agents.simulated.episode_walks import PlannedWalk  # noqa: E402
from arramon_agents.simulated.rendered_walks import RenderedStreets, RenderedWalker, walk_rendered_episodes  # noqa: E402
from arramon_agents.vl_map.network import PolicyNetwork, PolicySizes  # noqa: E402
from tests import tiny  # noqa: E402
from tests.agents.simulated.same_walks import assert_same_walks  # noqa: E402


@pytest.fixture(scope="module")
def streets(tmp_path_factory: pytest.TempPathFactory) -> RenderedStreets:
    data = tmp_path_factory.mktemp("rendered")
    tiny.write(data, "train", 3)
    return RenderedStreets(data, "en")


@pytest.fixture(scope="module")
def courses(streets: RenderedStreets) -> TrainingCourses:
    return training_courses(streets.data, ("en", "hi"), 0, load())


@pytest.fixture
def network() -> PolicyNetwork:
    torch.manual_seed(3)
    return PolicyNetwork(PolicySizes()).eval()


def test_labels_lead_to_the_targets(
    streets: RenderedStreets, courses: TrainingCourses, network: PolicyNetwork, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Followed at each decision, the labels lead to both targets."""
    monkeypatch.setattr(rendered_walks, "ASTRAY", 1.0)
    walker = RenderedWalker(streets, courses, network)
    walked = [walker.walk(PlannedWalk(number, 0, (1, number))) for number in range(len(courses.pairs))]
    assert [each.picked for each in walked] == [2, 2]
    assert all(each.decisions[-1].label.thing >= 0 for each in walked)


def test_two_processes_walk_like_one(
    streets: RenderedStreets, courses: TrainingCourses, network: PolicyNetwork
) -> None:
    planned = [PlannedWalk(number, number, (1, number)) for number in range(2)]
    alone, together = (list(walk_rendered_episodes(streets, courses, planned, network, count)) for count in (1, 2))
    assert_same_walks(alone, together)
