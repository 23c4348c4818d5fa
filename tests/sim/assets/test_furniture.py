"""Street furniture is in scale with the agent, and its colliders fit what is seen."""

import numpy as np
import pytest

from server.sim.assets.furniture import COLOURS, footprint_radius, piece_of
from server.sim.bullet import PROBE_HEIGHT
from server.sim.section import PROP_KINDS

HEIGHTS = {
    "cone": 0.3, "phone_booth": 0.85, "bench": 0.31, "lamp_post": 1.8, "traffic_light": 1.3, "dumpster": 0.5,
    "barrier": 0.38, "barrel": 0.34, "tyre_stack": 0.4, "hydrant": 0.29, "mailbox": 0.46, "bin": 0.37, "bags": 0.2,
    "tree": 2.0, "stop_sign": 1.2, "speed_sign": 1.2,
}  # fmt: skip
WIDER_ABOVE = ("lamp_post", "traffic_light", "tree", "stop_sign", "speed_sign")


def test_every_kind_but_the_banner_is_in_the_table() -> None:
    assert {*HEIGHTS, "banner"} == set(PROP_KINDS)


@pytest.mark.parametrize(("kind", "colour"), [(k, c) for k in HEIGHTS for c in COLOURS.get(k, ("",))])
def test_a_piece_is_as_tall_as_it_should_be_and_its_collider_holds_it(kind: str, colour: str) -> None:
    piece = piece_of(kind, colour)
    assert piece.collider is not None
    low, high = piece.mesh.vertices.min(axis=0), piece.mesh.vertices.max(axis=0)
    assert low[2] >= 0.0
    assert high[2] == pytest.approx(HEIGHTS[kind], abs=0.07)
    assert piece.collider.height == pytest.approx(high[2], abs=0.06)
    assert piece.collider.height > PROBE_HEIGHT
    if kind not in WIDER_ABOVE:
        reach = np.abs(piece.mesh.vertices).max(axis=0)
        assert reach[0] == pytest.approx(piece.collider.half_width, abs=0.025)
        assert reach[1] == pytest.approx(piece.collider.half_length, abs=0.035)


@pytest.mark.parametrize(
    ("kind", "radius"), [("cone", 0.156), ("phone_booth", 0.382), ("barrier", 0.525), ("tree", 0.113), ("banner", 0.0)]
)
def test_footprints(kind: str, radius: float) -> None:
    assert footprint_radius(kind) == pytest.approx(radius, abs=1e-3)


def test_an_empty_colour_is_the_first() -> None:
    assert (piece_of("cone").mesh.uvs == piece_of("cone", "orange").mesh.uvs).all()
    assert (piece_of("cone", "blue").mesh.uvs != piece_of("cone", "orange").mesh.uvs).any()


@pytest.mark.parametrize(("kind", "colour", "words"), [
    ("fountain", "", "'fountain' is not one of"), ("cone", "pink", "a cone comes in orange, red, blue, not in 'pink'"),
])  # fmt: skip
def test_what_is_unknown_is_named(kind: str, colour: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        piece_of(kind, colour)
