"""Large street furniture: parked cars, kiosks, planters, awnings over shops, and zebra crossings."""

from itertools import pairwise

from arramon_server.sim.assets.meshes import Vector, ball, box, lathe, merge, moved, plate, quad, stretched
from arramon_server.sim.assets.pieces import Piece, facing, in_colour
from arramon_server.sim.scene import BoxCollider, Mesh

ZEBRA_WIDTH, ZEBRA_LENGTH = 4.55, 1.4
"""Size of a zebra crossing across and along its street, in units. Pavements cover what is too wide for the street."""

_ZEBRA_BARS, _ZEBRA_HEIGHT = 7, 0.0045
"""Number of bars, and their height, in units: above the dashed lines, below the kerbs."""

_KIOSK_BANDS = ((0.64, 0.482, 90.0), (0.94, 0.322, 180.0), (0.64, 0.482, 270.0))
"""Width, distance from the middle, and side of the white bands around a kiosk."""

AWNING_WIDTH, AWNING_DEPTH = 1.5, 0.5
"""Size of an awning along the wall and out from it, in units."""


def car(colour: str) -> Piece:
    """Build a car, its front along +Y."""
    length, width = 1.36, 0.58
    # Body and cabin from the side: along and up.
    body = [(-0.68, 0.11), (0.68, 0.11), (0.68, 0.23), (0.6, 0.27), (-0.62, 0.29), (-0.68, 0.25)]
    cabin = [(-0.58, 0.28), (0.28, 0.27), (0.1, 0.44), (-0.44, 0.45)]
    shell = [moved(part, turn=-90.0) for part in plate(body, width)]
    glass = [moved(part, turn=-90.0) for part in plate(cabin, width - 0.08)]
    roof = moved(box(width - 0.06, 0.54, 0.03, base=0.435), (0.0, -0.17, 0.0))
    post = moved(box(width - 0.07, 0.04, 0.17, base=0.28), (0.0, -0.15, 0.0))
    tyre, hub = lathe([(0.115, 0.0), (0.115, 0.1), (0.0, 0.1)], 10), lathe([(0.065, 0.103), (0.0, 0.103)], 8)
    wheels, hubs = (
        [
            moved(moved(disc, pitch=-90.0), (side * (width / 2 - 0.09), y, 0.115), turn=90.0 * side)
            for side in (-1, 1)
            for y in (-0.42, 0.42)
        ]
        for disc in (tyre, hub)
    )
    front = length / 2 + 0.004
    lamps = [facing(0.13, 0.07, front, 0.15, x) for x in (-0.2, 0.2)]
    tails = [moved(facing(0.13, 0.07, front, 0.17, x), turn=180.0) for x in (-0.2, 0.2)]
    plates = [moved(facing(0.18, 0.06, front, 0.115), turn=turn) for turn in (0.0, 180.0)]
    mesh = merge(
        in_colour(colour, *shell, roof, post),
        in_colour("dark", *glass),
        in_colour("rubber", *wheels),
        in_colour("silver", *hubs),
        in_colour("lamp", *lamps),
        in_colour("light red", *tails),
        in_colour("white", *plates),
    )
    return Piece(mesh, BoxCollider(width / 2, length / 2, 0.46))


def kiosk(colour: str) -> Piece:
    """Build a kiosk: a booth with a counter, shelves behind it, and a striped canopy."""
    sides = [moved(box(0.05, 0.64, 0.9), (x, 0.0, 0.0)) for x in (-0.455, 0.455)]
    back = moved(box(0.9, 0.05, 0.9), (0.0, -0.295, 0.0))
    counter = moved(box(0.9, 0.3, 0.4), (0.0, 0.13, 0.0))
    board = moved(box(0.96, 0.1, 0.03, base=0.4), (0.0, 0.27, 0.0))
    roof = moved(box(1.04, 0.74, 0.06, base=0.9), (0.0, 0.0, 0.0))
    inside = facing(0.86, 0.45, -0.265, 0.42)
    goods = [facing(0.1, 0.1, -0.262, 0.5 + 0.17 * row, x) for row in range(2) for x in (-0.3, -0.1, 0.1, 0.3)]
    colours = ("orange", "yellow", "light green", "white")
    flanks = [moved(facing(0.46, 0.34, 0.482, 0.46), turn=turn) for turn in (90.0, 270.0)]
    flanks.append(moved(facing(0.7, 0.3, 0.322, 0.5), turn=180.0))
    bands = [moved(facing(wide, 0.08, out, 0.8), turn=turn) for wide, out, turn in _KIOSK_BANDS]
    canopy = _stripes(1.04, 0.2, 0.9, 0.36, 0.76, 8)
    mesh = merge(
        in_colour(colour, *sides, back, counter, roof),
        in_colour("wood", board),
        in_colour("dark", inside),
        in_colour("glass", *flanks),
        *(in_colour(colours[i % 4], part) for i, part in enumerate(goods)),
        in_colour("white", *canopy[::2], *bands),
        in_colour(colour, *canopy[1::2]),
    )
    return Piece(mesh, BoxCollider(0.52, 0.37, 0.96))


def planter() -> Piece:
    """Build a long concrete tub with a hedge and flowers."""
    rim = [box(0.84, 0.36, 0.05, base=0.21)]
    bushes = [
        moved(stretched(ball(0.17, 0.0, sides=7, rings=4), 1.0, 0.9, 0.95), (x, 0.0, 0.34)) for x in (-0.26, 0.0, 0.26)
    ]
    petal = ball(0.04, 0.0, sides=5, rings=3)
    places = (
        (-0.34, 0.1, 0.44), (-0.16, 0.12, 0.42), (0.06, 0.13, 0.43), (0.25, 0.11, 0.45), (0.36, -0.02, 0.43),
        (-0.24, -0.11, 0.44), (0.1, -0.12, 0.44), (-0.05, 0.0, 0.51), (0.24, 0.0, 0.5), (-0.29, 0.0, 0.5),
    )  # fmt: skip
    flowers = [moved(petal, place) for place in places]
    mesh = merge(
        in_colour("concrete", box(0.8, 0.32, 0.22), *rim),
        in_colour("leaf", *bushes),
        in_colour("red", *flowers[::2]),
        in_colour("yellow", *flowers[1::2]),
    )
    return Piece(mesh, BoxCollider(0.42, 0.18, 0.52))


def awning(colour: str) -> Piece:
    """Build a striped awning: its back is in the X-Z plane, against the wall, and it slopes down along +Y."""
    stripes = _stripes(AWNING_WIDTH, 0.0, 1.02, AWNING_DEPTH, 0.8, 9)
    valance = [_hanging(strip) for strip in stripes]
    rail = moved(box(AWNING_WIDTH, 0.03, 0.04, base=1.01), (0.0, 0.015, 0.0))
    mesh = merge(
        in_colour(colour, *stripes[::2], *valance[::2], rail), in_colour("white", *stripes[1::2], *valance[1::2])
    )
    return Piece(mesh, None)


def zebra_crossing() -> Piece:
    """Build white bars on the road; one walks over them along X, the road runs along Y."""
    step = ZEBRA_WIDTH / (2 * _ZEBRA_BARS - 1)
    bars = []
    for i in range(_ZEBRA_BARS):
        x0, x1, y, z = -ZEBRA_WIDTH / 2 + 2 * i * step, -ZEBRA_WIDTH / 2 + (2 * i + 1) * step, ZEBRA_LENGTH / 2, 0.0
        corners: list[Vector] = [(x0, -y, z), (x1, -y, z), (x1, y, z), (x0, y, z)]
        bars.append(moved(quad(corners), (0.0, 0.0, _ZEBRA_HEIGHT)))
    return Piece(in_colour("white", *bars), None)


def _stripes(width: float, y0: float, z0: float, depth: float, z1: float, count: int) -> list[Mesh]:
    """Build strips of cloth side by side, visible from both sides: from (y0, z0) down to (y0 + depth, z1)."""
    edges = [width / 2 - i * width / count for i in range(count + 1)]
    strips = []
    for left, right in pairwise(edges):
        above: list[Vector] = [(left, y0 + depth, z1), (right, y0 + depth, z1), (right, y0, z0), (left, y0, z0)]
        strips.append(merge(quad(above), quad([above[1], above[0], above[3], above[2]])))
    return strips


def _hanging(strip: Mesh) -> Mesh:
    """Build the flap that hangs from the lower edge of a strip of cloth."""
    left, right = strip.vertices[0], strip.vertices[1]
    drop = 0.1
    corners: list[Vector] = [
        (float(left[0]), float(left[1]), float(left[2]) - drop),
        (float(right[0]), float(right[1]), float(right[2]) - drop),
        (float(right[0]), float(right[1]), float(right[2])),
        (float(left[0]), float(left[1]), float(left[2])),
    ]
    return merge(quad(corners), quad([corners[1], corners[0], corners[3], corners[2]]))
