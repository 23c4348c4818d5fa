"""Input of the block network: the image as patches."""

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from arramon_agents.perception.eyes.network import CHANNELS, LOW, prepare  # noqa: E402
from arramon_agents.perception.eyes.pixel_rays import rays  # noqa: E402
from arramon_client.world import EYE_HEIGHT  # noqa: E402

SIZE = 112
PATCH = 2


def test_a_patch_has_the_values_of_its_pixels() -> None:
    random = np.random.default_rng(1)
    rgb = random.integers(0, 256, (2, SIZE, SIZE, 3), dtype=np.uint8)
    depth = random.uniform(0.5, 9.0, (2, SIZE, SIZE)).astype(np.float32)
    depth[0, 5, 7] = 0.0
    given = torch.nn.functional.pixel_shuffle(prepare(rgb, depth), PATCH)
    assert given.shape == (2, CHANNELS, SIZE, SIZE)
    images = given.numpy().transpose(0, 2, 3, 1)
    np.testing.assert_allclose(images[..., :3], rgb / 255.0 - 0.5, atol=1e-6)
    np.testing.assert_allclose(images[..., 3], np.where(depth > 0.0, 2.0 / (1.0 + depth), 0.0), rtol=1e-5)
    height = EYE_HEIGHT - rays(SIZE)[:, None] * depth[1]
    np.testing.assert_allclose(images[1, ..., 4], np.clip(height, 0.0, LOW) / LOW, atol=1e-5)
    assert images[0, 5, 7, 4] == images[0, 5, 7, 5] == 1.0
