"""The ensemble predicts what its networks predict one by one."""

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from arramon_agents.vl_map.ensemble import PolicyEnsemble  # noqa: E402
from arramon_agents.vl_map.features import mirror  # noqa: E402
from arramon_agents.vl_map.network import PolicyNetwork, PolicySizes, batch_of  # noqa: E402
from arramon_agents.vl_map.policy import read_policy  # noqa: E402
from arramon_agents.weights import find_weights  # noqa: E402
from arramon_lang.meaning import Navigation, Thing, Walk  # noqa: E402
from tests.agents.vl_map.test_features import sample  # noqa: E402


@pytest.mark.parametrize(("width", "heads", "layers"), [(64, 4, 3), (32, 2, 1)])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_networks_are_evaluated_together(count: int, width: int, heads: int, layers: int) -> None:
    torch.manual_seed(5)
    networks = [PolicyNetwork(PolicySizes(width, heads, layers)).eval() for _ in range(count)]
    one, _ = sample()
    two, _ = sample(-1, Navigation((Walk("ahead"),), Thing("tv")))
    with torch.inference_mode():
        for batch in (batch_of([one]), batch_of([one, two, mirror(one)])):
            expected = torch.stack([network(batch) for network in networks])
            torch.testing.assert_close(PolicyEnsemble(networks)(batch), expected, rtol=1e-4, atol=1e-4)
            assert count == 1 or (expected[0] - expected[1]).abs().max() > 1e-2


def test_the_shipped_networks_prefer_the_same_options() -> None:
    networks, _ = read_policy(find_weights("vl_map"))
    batch = batch_of([sample()[0], mirror(sample()[0])])
    with torch.inference_mode():
        expected = torch.stack([network(batch) for network in networks.policies])
    found = PolicyEnsemble(networks.policies)(batch)
    torch.testing.assert_close(found, expected, rtol=1e-4, atol=1e-4)
    np.testing.assert_array_equal(
        found.argsort(2, descending=True)[..., :5], expected.argsort(2, descending=True)[..., :5]
    )
