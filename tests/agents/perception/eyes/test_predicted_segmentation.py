"""The segmentation that the encoder predicts from its blocks."""

from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np
import numpy.typing as npt
import torch

from arramon_agents.mapping.probabilistic_landmark_memory import one_hot_of
from arramon_agents.perception.eyes.depth_segmentation import find_parts
from arramon_agents.perception.eyes.detected_things import DetectedThing, NamedParts
from arramon_agents.perception.eyes.encoder import Eyes
from arramon_agents.perception.eyes.pixel_rays import rays
from arramon_agents.perception.eyes.predicted_segmentation import LABELS, predict_percepts
from arramon_agents.perception.eyes.reach import NEAR
from arramon_agents.perception.eyes.vocabulary import COLOURS, KINDS, LOOKS
from arramon_agents.perception.frame_cache import FrameCache
from arramon_client.agent import Label
from arramon_client.world import EYE_HEIGHT
from tests.agents.perception.eyes.depth_images import SIZE, image

BLOCKS = 28
STRIPE, KERB = 239, 192
"""Least of the three colours of a stripe of a zebra crossing, and of the brightest stone beside the road."""


class _Blocks:
    """An encoder with the same probabilities in all blocks, that calls all things mugs, or finds none."""

    def __init__(
        self, kinds: dict[str, float], looks: dict[tuple[str, str], float], *, finds_mugs: bool = False
    ) -> None:
        self._finds_mugs = finds_mugs
        self.found = [_spread(kinds.get(kind, 0.0) for kind in KINDS), _spread(0.0 for _ in COLOURS)]
        self.found.append(_spread(looks.get(look, 0.0) for look in LOOKS))

    def blocks(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> list[torch.Tensor]:
        return self.found

    def parts(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> list[NamedParts]:
        names = one_hot_of(Label("mug", "red", "dotted"))
        found = [find_parts(each) for each in depth]
        if not self._finds_mugs:
            found = [replace(cut, things=[], parts=[]) for cut in found]
        return [NamedParts([DetectedThing(each, *names) for each in cut.things], cut) for cut in found]


def _spread(values: object) -> torch.Tensor:
    return torch.tensor(list(cast("list[float]", values)))[None, :, None, None].expand(1, -1, BLOCKS, BLOCKS)


def _labels(eyes: _Blocks, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> list[list[str]]:
    (sight,) = predict_percepts(cast(Eyes, eyes), rgb[None], depth[None])
    return [[LABELS[number].look or LABELS[number].kind for number in row] for row in sight.labels.tolist()]


def test_only_bright_pixels_on_the_ground_are_of_a_zebra_crossing() -> None:
    down = rays(SIZE)[:, None]
    depth = np.where(down > 0.0, EYE_HEIGHT / np.maximum(down, 1e-3), 0.0).astype(np.float32)
    depth = np.broadcast_to(depth, (SIZE, SIZE))
    rgb = np.full((SIZE, SIZE, 3), KERB, np.uint8)
    rgb[:, 100:110] = STRIPE
    labels = _labels(_Blocks({"zebra_crossing": 0.9, "road": 0.1}, {}), rgb, depth)
    assert labels[200][98:112] == ["road"] * 2 + ["zebra_crossing"] * 10 + ["road"] * 2


def test_a_facade_is_known_where_its_blocks_at_eye_height_agree() -> None:
    rgb, depth = np.zeros((SIZE, SIZE, 3), np.uint8), np.full((SIZE, SIZE), 0.5, np.float32)
    for share, expected in ((0.9, "brick"), (0.5, "building")):
        # At the horizon a block shows more of the ground than of a far building.
        looks = {("facade", "brick"): share, ("facade", "glass"): 1.0 - share}
        eyes = _Blocks({"building": 0.4, "road": 0.6}, looks)
        assert _labels(eyes, rgb, depth)[112][60] == expected


def test_what_is_too_small_to_be_named_is_no_building() -> None:
    """Otherwise a far object to pick up is a wall on the map, before itself."""
    depth = image((-4.0, 4.0, 14.0, 3.0), (-0.1, 0.1, 12.0, 0.2))
    eyes = _Blocks({"building": 1.0}, {("facade", "brick"): 1.0})
    labels = np.array(_labels(eyes, np.zeros((SIZE, SIZE, 3), np.uint8), depth))
    small = depth == np.float32(12.0)
    assert 0 < small.sum() < NEAR.pixels
    assert set(labels[small]) == {"pavement"}
    assert set(labels[depth == np.float32(14.0)]) == {"brick"}


def test_a_facade_is_not_that_of_a_higher_building_behind() -> None:
    depth = np.full((SIZE, SIZE), 20.0, np.float32)
    depth[:104] = 30.0
    eyes = _Blocks({"building": 1.0}, {("facade", "brick"): 1.0})
    brick, glass = (LOOKS.index(("facade", look)) for look in ("brick", "glass"))
    looks = eyes.found[2].clone()
    looks[:, [brick, glass], :13] = torch.tensor([0.0, 1.0])[None, :, None, None]
    eyes.found[2] = looks
    assert _labels(eyes, np.zeros((SIZE, SIZE, 3), np.uint8), depth)[112][60] == "brick"


def test_rims_are_of_the_thing_and_no_building() -> None:
    depth = image((-4.0, 4.0, 14.0, 3.0), (-0.2, 0.2, 3.0, 0.3), (-0.2, -0.05, 2.8, 0.25))
    eyes = _Blocks({"building": 1.0}, {("facade", "brick"): 1.0}, finds_mugs=True)
    labels = np.array(_labels(eyes, np.zeros((SIZE, SIZE, 3), np.uint8), depth))
    upright = (depth == np.float32(3.0)) & (EYE_HEIGHT - rays(SIZE)[:, None] * depth > 0.05)
    assert set(labels[upright]) == {"mug"}


class _Counting(_Blocks):
    """An encoder that counts the frames that it sees."""

    def __init__(self) -> None:
        super().__init__({"road": 1.0}, {})
        self.frames = 0

    def blocks(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> list[torch.Tensor]:
        self.frames += len(rgb)
        return [part.expand(len(rgb), -1, -1, -1) for part in super().blocks(rgb, depth)]


def test_a_frame_is_seen_once_as_long_as_it_is_remembered() -> None:
    eyes = _Counting()
    memory = FrameCache(partial(predict_percepts, cast(Eyes, eyes)), frames=3)
    depth = np.ones((4, SIZE, SIZE), np.float32)
    rgb = np.zeros((4, SIZE, SIZE, 3), np.uint8)
    rgb[1:, 0, 0, 0] = 1, 2, 3
    first = memory.find(rgb[[0, 1, 0]], depth[:3])
    assert first[0] is first[2]
    assert eyes.frames == 2
    assert memory.find(rgb[[1, 0]], depth[:2]) == [first[1], first[0]]
    assert eyes.frames == 2
    memory.find(rgb[[0]], 2.0 * depth[:1])  # The same colours at another distance.
    assert eyes.frames == 3
    memory.find(rgb[2:], depth[:2])  # Now the first ones are forgotten.
    memory.find(rgb[[1]], depth[:1])
    assert eyes.frames == 6
