"""Policy network: parameter count, options, and independence of inputs in a batch."""

import math

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from arramon_agents.simulated.walks import DecisionLabel  # noqa: E402
from arramon_agents.vl_map.features import DIRECTIONS, mirror  # noqa: E402
from arramon_agents.vl_map.network import (  # noqa: E402
    MASKED_LOGIT,
    PolicyNetwork,
    PolicySizes,
    batch_of,
    direction_bins,
    sizes_of,
    soft_bins,
)
from arramon_agents.vl_map.options import DISTANCES, OPTIONS, WAYPOINTS  # noqa: E402
from arramon_agents.vl_map.policy import MapPolicy  # noqa: E402
from arramon_agents.vl_map.recipe import MapRecipe  # noqa: E402
from arramon_agents.vl_map.task import option_targets  # noqa: E402
from arramon_lang.meaning import Navigation, Thing, Walk  # noqa: E402
from tests.agents.vl_map.test_features import sample  # noqa: E402


@pytest.fixture
def network() -> PolicyNetwork:
    torch.manual_seed(3)
    torch.set_num_threads(1)
    return PolicyNetwork(PolicySizes()).eval()


def test_size(network: PolicyNetwork) -> None:
    assert 120_000 < sum(parameter.numel() for parameter in network.parameters()) < 150_000


def test_only_collectibles_can_be_picked_up(network: PolicyNetwork) -> None:
    given, beliefs = sample()
    values = network(batch_of([given]))[0]
    assert values.shape == (OPTIONS,)
    can = [number for number in range(OPTIONS - WAYPOINTS) if values[WAYPOINTS + number] > MASKED_LOGIT]
    assert [beliefs[number].mark.label.kind for number in can] == ["mug"]


def test_the_better_match_is_picked_up_rather() -> None:
    network = PolicyNetwork(PolicySizes()).eval()
    asked, other = (sample(meaning=Navigation((), Thing("mug", colour)))[0] for colour in ("red", "blue"))
    values = [network(batch_of([given]))[0, WAYPOINTS:].max() for given in (asked, other)]
    assert values[0] > values[1]


def test_samples_of_a_batch_do_not_affect_each_other(network: PolicyNetwork) -> None:
    one, _ = sample()
    two, _ = sample(-1, Navigation((Walk("ahead"),), Thing("tv")))
    together = network(batch_of([one, two]))
    for number, each in enumerate((one, two)):
        torch.testing.assert_close(network(batch_of([each]))[0], together[number], rtol=1e-4, atol=1e-4)


def test_no_tensor_stays_on_the_cpu(network: PolicyNetwork) -> None:
    """The device "meta" computes shapes alone, and refuses tensors of other devices like a GPU."""
    logits, progress = network.to("meta").predict(batch_of([sample()[0]]).to("meta"))
    assert logits.shape == (1, OPTIONS)
    assert logits.device.type == progress.device.type == "meta"


def test_the_policy_decides_alike_in_a_mirrored_world(network: PolicyNetwork) -> None:
    given, beliefs = sample()
    policy = MapPolicy([network])
    values, mirrored = policy.option_values(given, beliefs), policy.option_values(mirror(given), beliefs)
    directions = -np.arange(DIRECTIONS) % DIRECTIONS
    shape = DIRECTIONS, len(DISTANCES)
    expected = values[:WAYPOINTS].reshape(shape)[directions]
    np.testing.assert_allclose(mirrored[:WAYPOINTS].reshape(shape), expected, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(mirrored[WAYPOINTS:], values[WAYPOINTS:], rtol=1e-4, atol=1e-4)
    alone = MapPolicy([network], mirrored=False).option_values(given, beliefs)
    np.testing.assert_allclose(alone, network(batch_of([given])).log_softmax(1)[0].detach(), rtol=1e-4, atol=1e-4)
    assert np.abs(alone - values).max() > 1e-3


@pytest.mark.parametrize(
    ("right", "ahead", "shares"),
    [(0.0, 2.0, {0: 1.0}), (3.0, 0.0, {6: 1.0}), (-1.0, 0.0, {18: 1.0}), (-0.1316525, 1.0, {0: 0.5, 23: 0.5})],
)
def test_directions(right: float, ahead: float, shares: dict[int, float]) -> None:
    found = direction_bins(torch.tensor([right]), torch.tensor([ahead]))[0]
    expected = [shares.get(number, 0.0) for number in range(DIRECTIONS)]
    np.testing.assert_allclose(found.numpy(), expected, atol=1e-4)


@pytest.mark.parametrize(
    ("value", "shares"),
    [(-1.0, [1, 0, 0]), (0.0, [1, 0, 0]), (0.5, [0.5, 0.5, 0]), (2.0, [0, 0.5, 0.5]), (9.0, [0, 0, 1])],
)
def test_shares(value: float, shares: list[float]) -> None:
    np.testing.assert_allclose(soft_bins(torch.tensor([value]), (0.0, 1.0, 3.0))[0].numpy(), shares, atol=1e-6)


def test_what_is_right() -> None:
    targets = option_targets(
        torch.tensor(
            [
                DecisionLabel(0.0, 4.0, -1, 0),
                DecisionLabel(-math.sqrt(6.5 * 10.0), 0.0, -1, 0),
                DecisionLabel(1.0, 1.0, 2, 0),
            ]
        )
    )
    assert targets.sum(1).tolist() == pytest.approx([1.0, 1.0, 1.0])
    assert targets[0, DISTANCES.index(4.0)] == pytest.approx(1.0)
    left = 18 * len(DISTANCES)
    assert targets[1, left + 3 : left + 5].tolist() == pytest.approx([0.5, 0.5])
    assert targets[2, WAYPOINTS + 2] == 1.0


def test_default_width_and_depth_give_the_default_sizes() -> None:
    assert sizes_of(MapRecipe.width, MapRecipe.layers) == PolicySizes()


@pytest.mark.parametrize(
    ("width", "layers", "message"),
    [
        (40, 3, "a width of 40, expected a positive multiple of 16"),
        (0, 3, "a width of 0, expected a positive multiple of 16"),
        (64, 1, "1 layers, expected at least 2"),
    ],
)
def test_impossible_sizes_are_refused(width: int, layers: int, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        sizes_of(width, layers)
