"""Labelled frames from the simulator."""

import numpy as np
import pytest

from arramon_agents.simulated.frames import FrameSource, label_names
from arramon_server.sim.labels import LABELS, SegmentationLabel


@pytest.fixture(scope="module")
def source() -> FrameSource:
    return FrameSource([("6", "0")], 112, 3)


def test_a_number_is_always_the_same_frame(source: FrameSource) -> None:
    again = FrameSource([("6", "0")], 112, 3)
    for number in (5, 2):
        one, other = source.frame(number), again.frame(number)
        assert np.array_equal(one.rgb, other.rgb)
        assert np.array_equal(one.labels, other.labels)
    assert not np.array_equal(source.frame(2).rgb, source.frame(5).rgb)


def test_frames_show_streets_and_rooms_with_collectibles(source: FrameSource) -> None:
    shown: set[str] = set()
    for number in range(60):
        frame = source.frame(number)
        assert frame.rgb.shape == (112, 112, 3)
        assert frame.depth.dtype == np.float32
        assert not frame.depth[frame.labels == LABELS.index(SegmentationLabel("nothing"))].any()
        shown |= {label_names()[label][0] for label in np.unique(frame.labels)}
    assert {"road", "building", "floor", "wall", "mug", "ball", "cone", "banner"} <= shown
