"""Shop signs: a board on the wall and a projecting one, with a word in large letters or a pharmacy's cross."""

from functools import cache

from arramon_client.world import SHOPS
from arramon_server.sim.assets.meshes import box, merge, moved, painted
from arramon_server.sim.assets.palette import write
from arramon_server.sim.assets.pieces import facing
from arramon_server.sim.assets.textures import Colour, Image, fill, plain
from arramon_server.sim.scene import Mesh

_BOARDS: dict[str, tuple[Colour, Colour]] = {
    "hotel": ((22, 50, 140), (255, 230, 120)), "cafe": ((96, 54, 28), (250, 234, 206)),
    "bank": ((16, 96, 62), (246, 246, 240)), "bakery": ((250, 206, 60), (150, 30, 24)),
    "pharmacy": ((248, 248, 246), (10, 140, 60)), "cinema": ((140, 16, 60), (255, 255, 250)),
}  # fmt: skip
"""Colours of each board and of what it shows."""

"""Kinds of shops with signs."""

WIDTH, HEIGHT, BASE = 1.44, 0.54, 0.92
"""Size of a board, and height of its lower edge, in units."""

_DEPTH, _OUT, _BLADE = 0.07, 1.12, 0.42
"""Thickness of the boards; length and height of the projecting one, in units."""

_PX = (48, 128)


@cache
def shop_sign_texture(shop: str) -> Image:
    """Draw a board, (48, 128, 3) uint8. Read-only: callers share it.

    Raises:
        ValueError: for an unknown shop.
    """
    if shop not in _BOARDS:
        raise ValueError(f"{shop!r} is not one of {', '.join(SHOPS)}")
    ground, ink = _BOARDS[shop]
    height, width = _PX
    image = plain(height, width, ink)
    fill(image, 2, 2, width - 2, height - 2, ground)
    if shop == "pharmacy":
        fill(image, width / 2 - 7, 5, width / 2 + 7, height - 5, ink)
        fill(image, width / 2 - 19, height / 2 - 7, width / 2 + 19, height / 2 + 7, ink)
    else:
        dot = min((width - 10) // (4 * len(shop) - 1), (height - 10) // 5)
        write(image, shop.upper(), (height - 5 * dot) // 2, dot, ink)
    image.flags.writeable = False
    return image


@cache
def shop_sign_mesh() -> Mesh:
    """Build a board flat on the wall, and beside it a projecting one, readable along the street.

    The back is in the X-Z plane, against the wall, and it faces +Y.
    """
    board = moved(box(WIDTH, _DEPTH, HEIGHT, base=BASE), (0.0, _DEPTH / 2, 0.0))
    across = moved(box(_DEPTH, _OUT, _BLADE, base=BASE), (WIDTH / 2 + _DEPTH, _OUT / 2, 0.0))
    place = (WIDTH / 2 + _DEPTH, _OUT / 2, 0.0)
    sides = [moved(facing(_OUT, _BLADE, _DEPTH / 2 + 0.002, BASE), place, turn) for turn in (90.0, 270.0)]
    return merge(painted(merge(board, across), (0.005, 0.01)), facing(WIDTH, HEIGHT, _DEPTH + 0.002, BASE), *sides)
