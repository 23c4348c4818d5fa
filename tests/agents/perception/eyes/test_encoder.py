"""The visual encoder with the shipped weights."""

from pathlib import Path

import numpy as np
import pytest

from arramon_agents.perception.eyes.encoder import FAR_WEIGHTS, WEIGHTS, Eyes, load, load_far
from arramon_agents.perception.eyes.scores import GridScores, NameScores
from arramon_agents.perception.registry import open_encoder
from arramon_agents.simulated.frames import FrameSource, label_names
from arramon_agents.weights import BadWeights

FRAMES = 24


@pytest.fixture(scope="module")
def eyes() -> Eyes:
    return load()


@pytest.fixture(scope="module")
def source() -> FrameSource:
    """Of a section that it was not trained in."""
    return FrameSource([("6", "0")], 224, 99)


def test_it_sees_in_streets_where_it_was_not_trained(eyes: Eyes, source: FrameSource) -> None:
    cells, names = GridScores(label_names()), NameScores(label_names())
    for number in range(FRAMES):
        frame = source.frame(number)
        cells.add(eyes.encode(frame.rgb[None], frame.depth[None])[0], frame.labels)
        names.add(eyes.things(frame.rgb[None], frame.depth[None])[0], frame.labels)
    groups = cells.groups()
    assert min(groups["kind"], groups["colour"], groups["pattern"], groups["wall"]) > 0.8
    assert min(groups["furniture"], groups["facade"]) > 0.6
    assert names.shares()["100 to 399 pixels"]["all"] > 0.7


def test_the_encoder_for_maps_names_things_that_are_far(eyes: Eyes, source: FrameSource) -> None:
    far_eyes, names = load_far(), NameScores(label_names())
    near, far = 0, 0
    for number in range(FRAMES):
        frame = source.frame(number)
        images = frame.rgb[None], frame.depth[None]
        near += sum(named.thing.ahead > 16.0 for named in eyes.things(*images)[0])
        seen = far_eyes.things(*images)[0]
        far += sum(named.thing.ahead > 16.0 for named in seen)
        names.add(seen, frame.labels)
    assert near == 0
    assert far >= 10
    assert names.shares()["100 to 399 pixels"]["all"] > 0.7
    assert far_eyes.fingerprint != eyes.fingerprint
    assert FAR_WEIGHTS.stat().st_size < 2_000_000


def test_it_meets_the_interface(eyes: Eyes, source: FrameSource) -> None:
    encoder = open_encoder("eyes")
    frames = [source.frame(number) for number in range(3)]
    rgb, depth = np.stack([frame.rgb for frame in frames]), np.stack([frame.depth for frame in frames])
    found = encoder.encode(rgb, depth)
    assert found.shape == (3, 7, 7, encoder.channels)
    assert found.dtype == np.float32
    assert found.min() >= 0.0
    assert found.max() <= 1.0
    assert len(encoder.channel_names) == encoder.channels <= 96
    alone = np.concatenate([encoder.encode(rgb[i : i + 1], depth[i : i + 1]) for i in range(3)])
    np.testing.assert_allclose(found, alone, atol=1e-5)
    assert encoder.fingerprint == eyes.fingerprint


def test_images_of_another_size_are_refused(eyes: Eyes) -> None:
    with pytest.raises(ValueError, match=r"expected \(B, 224, 224, 3\)"):
        eyes.encode(np.zeros((1, 112, 112, 3), np.uint8), np.zeros((1, 112, 112), np.float32))


def test_an_empty_frame_shows_nothing(eyes: Eyes) -> None:
    found = eyes.encode(np.zeros((1, 224, 224, 3), np.uint8), np.zeros((1, 224, 224), np.float32))
    assert eyes.things(np.zeros((1, 224, 224, 3), np.uint8), np.zeros((1, 224, 224), np.float32)) == [[]]
    assert not found[..., : eyes.channel_names.index("furniture:cone")].any()


def test_missing_and_foreign_weights_are_named(tmp_path: Path) -> None:
    with pytest.raises(BadWeights, match="there are no weights of the visual encoder at"):
        load(tmp_path / "none.safetensors")
    assert WEIGHTS.stat().st_size < 2_000_000


def test_a_file_that_is_cut_off_is_named(tmp_path: Path) -> None:
    path = tmp_path / "eyes.safetensors"
    path.write_bytes(WEIGHTS.read_bytes()[:1000])
    with pytest.raises(BadWeights, match="is no file of weights: Error while deserializing"):
        load(path)
