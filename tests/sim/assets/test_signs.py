"""Signs of shops differ, and are lettered."""

from itertools import combinations

import numpy as np
import pytest

from arramon_client.world import EYE_HEIGHT, SHOPS
from arramon_server.sim.assets.signs import BASE, HEIGHT, shop_sign_mesh, shop_sign_texture


@pytest.mark.parametrize("shop", SHOPS)
def test_a_sign_shows_something_in_a_second_colour(shop: str) -> None:
    image = shop_sign_texture(shop)
    assert image.shape == (48, 128, 3)
    assert not image.flags.writeable
    colours, counts = np.unique(image.reshape(-1, 3), axis=0, return_counts=True)
    assert len(colours) == 2
    assert counts.min() > 0.1 * counts.sum()


def test_signs_differ() -> None:
    for one, other in combinations(SHOPS, 2):
        assert (shop_sign_texture(one) != shop_sign_texture(other)).any(axis=2).mean() > 0.3


def test_a_sign_hangs_above_the_heads() -> None:
    heights = shop_sign_mesh().vertices[:, 2]
    assert heights.min() == pytest.approx(BASE)
    assert heights.min() > EYE_HEIGHT
    assert heights.max() == pytest.approx(BASE + HEIGHT)


def test_an_unknown_shop_is_named() -> None:
    with pytest.raises(ValueError, match="'school' is not one of hotel, cafe"):
        shop_sign_texture("school")
