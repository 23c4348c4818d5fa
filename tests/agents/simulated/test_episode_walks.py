"""Simulated walks for training: the same in one process and in two, along paths and by a policy."""

import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from arramon_agents.reading.reader.reader import load  # noqa: E402
from arramon_agents.simulated.courses import training_courses  # noqa: E402
from arramon_agents.simulated.episode_walks import CoursePair, PlannedWalk, cpu_seconds, walk_episodes  # noqa: E402
from arramon_agents.vl_map.network import PolicyNetwork, PolicySizes  # noqa: E402
from tests import tiny  # noqa: E402
from tests.agents.simulated.same_walks import assert_same_walks  # noqa: E402


@pytest.fixture(scope="module")
def pairs(tmp_path_factory: pytest.TempPathFactory) -> list[CoursePair]:
    data = tmp_path_factory.mktemp("walks")
    tiny.write(data, "train", 3)
    return list(training_courses(data, ("en", "hi"), 0, load()).pairs)


@pytest.mark.parametrize("by_policy", [False, True])
def test_two_processes_walk_like_one(pairs: list[CoursePair], by_policy: bool) -> None:
    torch.manual_seed(3)
    network = PolicyNetwork(PolicySizes()).eval() if by_policy else None
    planned = [PlannedWalk(number % len(pairs), number, (1, number)) for number in range(3)]
    before = cpu_seconds()
    alone, together = (list(walk_episodes(pairs, planned, network, processes)) for processes in (1, 2))
    assert cpu_seconds() > before
    assert_same_walks(alone, together)
