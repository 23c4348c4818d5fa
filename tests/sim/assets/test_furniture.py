"""Street furniture: heights relative to the agent, and colliders that fit the meshes."""

import numpy as np
import pytest

from arramon_client.world import EYE_HEIGHT, FURNITURE
from arramon_server.sim.assets.furniture import COLOURS, IMPORTED_COLOURS, footprint_radius, piece_of
from arramon_server.sim.assets.roadside import ZEBRA_LENGTH, ZEBRA_WIDTH
from arramon_server.sim.footprints import PROBE_HEIGHT
from arramon_server.sim.section import ON_WALLS

HEIGHTS = {
    "cone": 0.43, "phone_booth": 0.85, "bench": 0.4, "lamp_post": 2.08, "traffic_light": 1.6, "dumpster": 0.5,
    "barrier": 0.44, "barrel": 0.46, "tyre_stack": 0.5, "hydrant": 0.47, "mailbox": 0.62, "bin": 0.53, "bags": 0.31,
    "tree": 2.0, "stop_sign": 1.61, "speed_sign": 1.66, "car": 0.47, "kiosk": 0.96, "planter": 0.52,
}  # fmt: skip
WIDER_ABOVE = ("lamp_post", "traffic_light", "tree", "stop_sign", "speed_sign")


def test_every_kind_that_stands_is_in_the_table() -> None:
    assert {*HEIGHTS, *ON_WALLS, "zebra_crossing"} == set(FURNITURE)


@pytest.mark.parametrize("kind", sorted(ON_WALLS))
def test_what_hangs_on_a_wall_is_above_the_heads_or_flat(kind: str) -> None:
    piece = piece_of(kind)
    assert piece.collider is None
    vertices = piece.mesh.vertices
    assert vertices[:, 1].min() >= -1e-6
    assert vertices[vertices[:, 1] > 0.15][:, 2].min(initial=9.0) > EYE_HEIGHT + 0.1


def test_a_zebra_crossing_is_flat() -> None:
    piece = piece_of("zebra_crossing")
    assert piece.collider is None
    assert np.ptp(piece.mesh.vertices[:, 2]) == 0.0
    assert np.ptp(piece.mesh.vertices, axis=0)[:2].tolist() == pytest.approx([ZEBRA_WIDTH, ZEBRA_LENGTH])


@pytest.mark.parametrize(
    ("kind", "colour"), [(k, c) for k in HEIGHTS for c in (*COLOURS.get(k, ("",)), *IMPORTED_COLOURS.get(k, ()))]
)
def test_pieces_have_the_expected_height_and_a_fitting_collider(kind: str, colour: str) -> None:
    piece = piece_of(kind, colour)
    assert piece.collider is not None
    low, high = piece.mesh.vertices.min(axis=0), piece.mesh.vertices.max(axis=0)
    assert low[2] >= 0.0
    assert high[2] == pytest.approx(HEIGHTS[kind], abs=0.07)
    assert piece.collider.height == pytest.approx(high[2], abs=0.06)
    assert piece.collider.height > PROBE_HEIGHT
    if kind not in WIDER_ABOVE:
        reach = np.abs(piece.mesh.vertices).max(axis=0)
        assert reach[0] == pytest.approx(piece.collider.half_width, abs=0.04)
        # A kiosk's canopy juts out above the heads.
        below = piece.mesh.vertices[:, 2] < EYE_HEIGHT
        reach = np.abs(piece.mesh.vertices[below if kind == "kiosk" else slice(None)]).max(axis=0)
        assert reach[1] == pytest.approx(piece.collider.half_length, abs=0.055)


@pytest.mark.parametrize(
    ("kind", "radius"), [("cone", 0.226), ("phone_booth", 0.382), ("barrier", 0.604), ("tree", 0.113), ("banner", 0.0)]
)
def test_footprint_radii_match_known_values(kind: str, radius: float) -> None:
    assert footprint_radius(kind) == pytest.approx(radius, abs=1e-3)


def test_empty_colour_means_the_first_colour() -> None:
    assert (piece_of("cone").mesh.uvs == piece_of("cone", "orange").mesh.uvs).all()
    assert (piece_of("cone", "blue").mesh.uvs != piece_of("cone", "orange").mesh.uvs).any()


@pytest.mark.parametrize(("kind", "colour", "words"), [
    ("fountain", "", "'fountain' is not one of"),
    ("cone", "pink", "a cone comes in orange, red, blue, green, white, not in 'pink'"),
])  # fmt: skip
def test_unknown_kinds_and_colours_are_refused(kind: str, colour: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        piece_of(kind, colour)
