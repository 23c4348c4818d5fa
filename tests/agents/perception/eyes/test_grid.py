"""The encoder's grid of cells, from named things and from blocks."""

import numpy as np
import pytest
import torch

from arramon_agents.perception.eyes.depth_segmentation import FrameThing
from arramon_agents.perception.eyes.detected_things import DetectedThing
from arramon_agents.perception.eyes.grid import CHANNEL_NAMES, NAMED_CHANNELS, add_things, grid_of_blocks
from arramon_agents.perception.eyes.network import Predictions, probabilities
from arramon_agents.perception.eyes.vocabulary import COLOURS, KINDS, LOOKS, NONE, codes_of

SURE = 20.0


def named(kind: str, colour: str, look: str, rows: slice, columns: slice, ahead: float = 3.0) -> DetectedThing:
    codes = codes_of(kind, colour, look)
    kinds, colours, looks = (np.zeros(len(names), np.float32) for names in (KINDS, COLOURS, LOOKS))
    for chances, code in zip((kinds, colours, looks), codes, strict=True):
        if code != NONE:
            chances[code] = 1.0
    mask = np.ones((rows.stop - rows.start, columns.stop - columns.start), bool)
    return DetectedThing(FrameThing(rows, columns, mask, 0.0, ahead, 0.3, 0.0, 0.3), kinds, colours, looks)


def lit(cell: np.ndarray) -> set[str]:
    return {name for name, value in zip(CHANNEL_NAMES, cell, strict=True) if value >= 0.5}


@pytest.mark.parametrize(
    ("label", "expected"),
    [
        (("mug", "blue", "dotted"), {"kind:mug", "colour:blue", "pattern:dotted", "collectible"}),
        (("cone", "red", ""), {"furniture:cone", "furniture colour:red"}),
        (("banner", "black", "star"), {"furniture:banner", "banner colour:black", "shape:star"}),
        (("shop_sign", "", "cafe"), {"furniture:shop_sign", "shop:cafe"}),
        (("building", "", "brick"), set()),
    ],
)
def test_a_thing_is_in_the_cells_that_it_covers(label: tuple[str, str, str], expected: set[str]) -> None:
    cells = np.zeros((7, 7, len(CHANNEL_NAMES)), np.float32)
    # Two columns of pixels reach into the third cell, which is enough; the row beside holds nothing.
    add_things(cells, [named(*label, slice(100, 120), slice(40, 66))], 224)
    assert lit(cells[3, 1]) == lit(cells[3, 2]) == expected
    assert not cells[2].any()
    assert not cells[3, 3].any()


def test_the_nearest_collectible_counts() -> None:
    cells = np.zeros((7, 7, len(CHANNEL_NAMES)), np.float32)
    near, far = (
        named("mug", "blue", "dotted", slice(100, 110), slice(40, 50), 1.0),
        named("ball", "red", "striped", slice(110, 120), slice(40, 50), 3.0),
    )
    add_things(cells, [near, far], 224)
    assert cells[3, 1, CHANNEL_NAMES.index("nearness of collectible")] == pytest.approx(0.5)
    assert {"kind:mug", "kind:ball"} <= lit(cells[3, 1])


def test_blocks_show_in_their_cells() -> None:
    logits = [torch.zeros(1, len(names), 28, 28) for names in (KINDS, COLOURS, LOOKS)]
    logits[0][:, KINDS.index("road")] = SURE
    code = codes_of("building", "", "glass")
    logits[0][0, code.kind, 5, 9] = 2 * SURE
    logits[2][0, code.look, 5, 9] = SURE
    depth = torch.full((1, 224, 224), 4.0)
    depth[0, 0, 0] = 1.0
    (cells,) = grid_of_blocks(probabilities(Predictions(tuple(logits))), depth)
    assert lit(cells[1, 2]) == {"facade:glass", "ground"}
    assert lit(cells[2, 2]) == {"ground"}
    assert cells[0, 0, CHANNEL_NAMES.index("nearness")] == pytest.approx(0.5)
    assert cells[0, 0, CHANNEL_NAMES.index("mean nearness")] == pytest.approx(0.2, abs=0.001)
    assert len(set(CHANNEL_NAMES)) == len(CHANNEL_NAMES) <= 96
    assert len(NAMED_CHANNELS) < len(CHANNEL_NAMES)
