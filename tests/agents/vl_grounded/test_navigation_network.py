"""Navigation phase: single steps agree with training, guard of the pick-up, and steps without effect."""

import numpy as np
import numpy.typing as npt
import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from torch import nn  # noqa: E402

from arramon_agents.perception.eyes.grid import CHANNEL_NAMES  # noqa: E402
from arramon_agents.vl.model import START_ACTION  # noqa: E402
from arramon_agents.vl_grounded.navigation_player import NavigationPlayer, is_in_reach  # noqa: E402
from arramon_agents.vl_grounded.network import Grounded  # noqa: E402
from arramon_agents.vl_grounded.odometry import odometry  # noqa: E402

FORWARD, LEFT, RIGHT, INTERACT = range(4)

TOKENS = torch.tensor([[2, 3, 4]])


@pytest.fixture
def network() -> Grounded:
    torch.manual_seed(1)
    torch.set_num_threads(1)
    return Grounded(9).eval()


def frame(nearness: float = 0.0) -> npt.NDArray[np.uint8]:
    """Return features with a collectible of a nearness straight ahead."""
    features = np.zeros((7, 7, len(CHANNEL_NAMES)), np.uint8)
    features[4, 3, CHANNEL_NAMES.index("nearness of collectible")] = round(255 * nearness)
    return features


def last_layer(network: Grounded) -> nn.Linear:
    layer = network.street.output[-1]
    assert isinstance(layer, nn.Linear)
    return layer


def preferring(network: Grounded, *actions: int) -> Grounded:
    """Make a network prefer actions, the first one most."""
    with torch.no_grad():
        last_layer(network).weight.zero_()
        last_layer(network).bias.zero_()
        for number, action in enumerate(actions):
            last_layer(network).bias[action] = 10.0 - number
    return network


def test_a_walk_is_the_same_step_by_step_as_at_once(network: Grounded) -> None:
    random = np.random.default_rng(1)
    features = random.integers(0, 256, (6, 7, 7, len(CHANNEL_NAMES))).astype(np.uint8)
    features[..., CHANNEL_NAMES.index("nearness of collectible")] = 0
    walker = NavigationPlayer(network, TOKENS)
    depths = [np.full((4, 4), number, np.float32) for number in range(6)]
    actions = [walker.act(*given) for given in zip(features, depths, strict=True)]
    street, words = network.street, network.reading(TOKENS)
    before = torch.tensor([[START_ACTION, *actions[:-1]]])
    cells = torch.from_numpy(features)[None].float() / 255
    places = torch.from_numpy(odometry(actions[:-1]))[None]
    seen = street.step_inputs(network.reading, street.read_target(words, TOKENS), cells, before, places)
    values = street(network.reading, words, TOKENS, seen)[0]
    assert values[:, :INTERACT].argmax(1).tolist() == actions  # Nothing is near: a pick-up is ruled out.


@pytest.mark.parametrize(("fits", "nearness", "expected"), [(0.9, 0.5, True), (0.1, 0.5, False), (0.9, 0.1, False)])
def test_only_what_fits_and_is_near_can_be_picked_up(fits: float, nearness: float, expected: bool) -> None:
    assert is_in_reach(torch.full((49,), fits), frame(nearness)) is expected


def test_what_is_aside_is_not_in_reach() -> None:
    features = frame(0.5)
    assert not is_in_reach(torch.full((49,), 0.9), np.roll(features, 2, axis=1))


def test_after_a_blocked_step_it_turns_on_until_it_can_walk(network: Grounded) -> None:
    walker = NavigationPlayer(network, TOKENS)
    here = 0
    for moved, preferred, expected in (
        (True, (FORWARD, LEFT, RIGHT), FORWARD),
        (False, (FORWARD, LEFT, RIGHT), LEFT),  # The step was blocked.
        (True, (FORWARD, LEFT, RIGHT), FORWARD),
        (False, (FORWARD, RIGHT, LEFT), LEFT),  # Blocked again: not back to the wall.
        (True, (FORWARD, RIGHT, LEFT), FORWARD),
        (True, (RIGHT, FORWARD, LEFT), RIGHT),  # It could walk: all is open again.
        (True, (LEFT, FORWARD, RIGHT), FORWARD),  # It does not turn back at once.
    ):
        preferring(network, *preferred)
        here += moved
        assert walker.act(frame(), np.full((4, 4), here, np.float32)) == expected


def test_it_turns_no_farther_than_it_must(network: Grounded) -> None:
    walker = NavigationPlayer(preferring(network, LEFT), TOKENS)
    depths = [np.full((4, 4), number, np.float32) for number in (*range(7), 6, 7, 8)]
    # Half a circle, a step, which is blocked, and on.
    assert [walker.act(frame(), depth) for depth in depths] == [LEFT] * 6 + [FORWARD] + [LEFT] * 3


def test_a_step_without_effect_is_as_if_it_had_not_been_taken(network: Grounded) -> None:
    blocked, free = NavigationPlayer(network, TOKENS), NavigationPlayer(network, TOKENS)
    start, later = np.zeros((4, 4), np.float32), np.ones((4, 4), np.float32)
    preferring(network, FORWARD, LEFT, RIGHT)
    assert [blocked.act(frame(), start), blocked.act(frame(), start)] == [FORWARD, LEFT]
    preferring(network, LEFT)
    assert free.act(frame(), start) == LEFT
    for walker in (blocked, free):
        walker.act(frame(0.3), later)
    for one, other in zip(blocked.state, free.state, strict=True):
        torch.testing.assert_close(one, other)
