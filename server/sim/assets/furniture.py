"""Street furniture: mesh and collider of every kind of prop, in scale with the agent (a unit is about three metres).

All kinds but banners share the texture of `palette`. Every collider is taller than `footprints.PROBE_HEIGHT`.
"""

import math
from collections.abc import Callable
from functools import cache
from itertools import pairwise

from arramon_client.world import FURNITURE
from arramon_server.sim.assets import roadside
from arramon_server.sim.assets.banners import banner_mesh
from arramon_server.sim.assets.meshes import ball, box, lathe, mapped, merge, moved, plate, stretched
from arramon_server.sim.assets.palette import SPEED_FACE, STOP_FACE, STRIPES
from arramon_server.sim.assets.pieces import Piece, facing, in_colour, pole
from arramon_server.sim.assets.signs import shop_sign_mesh
from arramon_server.sim.scene import BoxCollider

COLOURS: dict[str, tuple[str, ...]] = {
    "cone": ("orange", "red", "blue"),
    "dumpster": ("green", "silver"),
    "barrier": ("concrete", "white", "red"),
    "barrel": ("red", "yellow", "gold"),
    "car": ("red", "blue", "white", "yellow"),
    "kiosk": ("green", "red", "blue"),
    "awning": ("red", "blue", "green", "yellow"),
}
"""Colours of the kinds with several; the first is the default."""

IMPORTED_COLOURS: dict[str, tuple[str, ...]] = {
    "cone": ("green", "white"),
    "barrier": ("yellow",),
    "barrel": ("brown", "orange"),
    "bench": ("silver",),
    "bin": ("silver", "black"),
    "lamp_post": ("black",),
    "traffic_light": ("yellow",),
}
"""Further colours, from people's instructions in imported texts; street plans and random drawing do not use them."""


_LARGER = {
    "cone": 1.45, "hydrant": 1.6, "bin": 1.45, "barrel": 1.35, "mailbox": 1.35, "bags": 1.5, "tyre_stack": 1.25,
    "bench": 1.3, "barrier": 1.15, "traffic_light": 1.2, "stop_sign": 1.35, "speed_sign": 1.4, "lamp_post": 1.15,
}  # fmt: skip
"""Enlargement of small things, so that they can be recognised in a frame of 224 pixels."""


@cache
def piece_of(kind: str, colour: str = "") -> Piece:
    """Build the mesh and collider of a prop.

    Args:
        kind: one of `section.PROP_KINDS`.
        colour: colour of kinds with several; ignored otherwise.

    Raises:
        ValueError: for an unknown kind, or a colour that the kind does not have.
    """
    if kind not in FURNITURE:
        raise ValueError(f"{kind!r} is not one of {', '.join(FURNITURE)}")
    colours = (*COLOURS.get(kind, ()), *IMPORTED_COLOURS.get(kind, ()))
    if kind in COLOURS or (kind in IMPORTED_COLOURS and colour):
        chosen = colour or COLOURS[kind][0]
        if chosen not in colours:
            raise ValueError(f"a {kind} comes in {', '.join(colours)}, not in {colour!r}")
        piece = _COLOURED[kind](chosen)
    else:
        piece = _PLAIN[kind]()
    return piece.scaled(_LARGER[kind]) if kind in _LARGER else piece


@cache
def footprint_radius(kind: str) -> float:
    """Return the radius of a circle that contains the colliders of all props of a kind, in units; 0 without colliders.

    Raises:
        ValueError: for an unknown kind.
    """
    pieces = [piece_of(kind, colour) for colour in COLOURS.get(kind, ("",))]
    boxes = [piece.collider for piece in pieces if piece.collider is not None]
    return max((math.hypot(box.half_width, box.half_length) for box in boxes), default=0.0)


def _cone(colour: str) -> Piece:
    bands = [(0.085, 0.025, 0.064, 0.11), (0.064, 0.11, 0.046, 0.18), (0.046, 0.18, 0.018, 0.29)]
    rings = [lathe([(r0, z0), (r1, z1)], 10) for r0, z0, r1, z1 in bands]
    mesh = merge(
        in_colour(colour, rings[0], rings[2], lathe([(0.018, 0.29), (0.0, 0.3)], 10)),
        in_colour("white", rings[1]),
        in_colour("dark" if colour == "orange" else colour, box(0.22, 0.22, 0.025)),
    )
    return Piece(mesh, BoxCollider(0.11, 0.11, 0.3))


def _phone_booth() -> Piece:
    side = merge(
        in_colour(
            "glass", *(facing(0.15, 0.16, 0.252, 0.12 + 0.19 * row, x) for row in range(3) for x in (-0.095, 0.095))
        ),
        in_colour("white", facing(0.36, 0.07, 0.252, 0.71)),
    )
    mesh = merge(
        in_colour("blue", box(0.5, 0.5, 0.8), box(0.54, 0.54, 0.05, base=0.8)),
        in_colour("dark blue", box(0.52, 0.52, 0.06)),
        *(moved(side, turn=90.0 * i) for i in range(4)),
    )
    return Piece(mesh, BoxCollider(0.27, 0.27, 0.85))


def _bench(colour: str = "wood") -> Piece:
    seat = [moved(box(0.64, 0.065, 0.02, base=0.15), (0.0, y, 0.0)) for y in (-0.05, 0.025, 0.1)]
    back = [moved(box(0.64, 0.02, 0.05, base=z), (0.0, -0.1, 0.0)) for z in (0.19, 0.26)]
    legs = [moved(box(0.03, 0.2, 0.15), (x, 0.02, 0.0)) for x in (-0.26, 0.26)]
    posts = [moved(box(0.03, 0.025, 0.31), (x, -0.122, 0.0)) for x in (-0.26, 0.26)]
    return Piece(
        merge(in_colour(colour, *seat, *back), in_colour("dark", *legs, *posts)), BoxCollider(0.32, 0.14, 0.31)
    )


def _lamp_post(colour: str = "dark green") -> Piece:
    foot = lathe([(0.08, 0.0), (0.08, 0.1), (0.035, 0.16)], 8)
    lantern = lathe([(0.05, 1.5), (0.1, 1.7)], 6)
    cap = lathe([(0.0, 1.69), (0.13, 1.7), (0.03, 1.78), (0.0, 1.82)], 6)
    mesh = merge(in_colour(colour, foot, pole(0.03, 1.5), cap), in_colour("lamp", lantern))
    return Piece(mesh, BoxCollider(0.08, 0.08, 1.8))


def _traffic_light(colour: str = "black") -> Piece:
    disc = moved(lathe([(0.05, 0.0), (0.0, 0.01)], 10), pitch=-90.0)
    lights = [
        in_colour(colour, moved(disc, (0.0, 0.072, z)))
        for colour, z in (("light red", 1.22), ("light amber", 1.09), ("light green", 0.96))
    ]
    mesh = merge(
        in_colour("dark", pole(0.035, 0.9), lathe([(0.08, 0.0), (0.08, 0.06), (0.0, 0.06)], 8)),
        in_colour(colour, box(0.16, 0.14, 0.42, base=0.88)),
        in_colour("yellow", moved(box(0.24, 0.015, 0.5, base=0.84), (0.0, 0.02, 0.0))),
        *lights,
    )
    return Piece(mesh, BoxCollider(0.08, 0.08, 1.3))


def _dumpster(colour: str) -> Piece:
    side = "silver" if colour == "silver" else "green"
    trim = "metal" if colour == "silver" else "dark green"
    ribs = [moved(box(0.04, 0.6, 0.34, base=0.06), (x, 0.0, 0.0)) for x in (-0.38, -0.13, 0.13, 0.38)]
    wheels = [moved(box(0.06, 0.08, 0.06), (x, y, 0.0)) for x in (-0.42, 0.42) for y in (-0.2, 0.2)]
    lid = moved(box(1.04, 0.6, 0.03), (0.0, 0.0, 0.45), pitch=-5.0)
    mesh = merge(
        in_colour(side, box(1.0, 0.56, 0.38, base=0.05)),
        in_colour(trim, *ribs, box(1.06, 0.62, 0.04, base=0.4)),
        in_colour("black", lid, *wheels),
    )
    return Piece(mesh, BoxCollider(0.53, 0.31, 0.5))


def _barrier(colour: str) -> Piece:
    if colour == "white":
        boards = [mapped(box(1.0, 0.03, 0.1, base=z), *STRIPES) for z in (0.12, 0.28)]
        legs = [moved(box(0.04, 0.24, 0.04), (x, 0.0, 0.0)) for x in (-0.42, 0.42)]
        posts = [moved(box(0.04, 0.025, 0.4), (x, 0.0, 0.0)) for x in (-0.42, 0.42)]
        return Piece(merge(in_colour("white", *legs, *posts), *boards), BoxCollider(0.5, 0.12, 0.4))
    outline = [
        (-0.16, 0.0),
        (0.16, 0.0),
        (0.16, 0.06),
        (0.07, 0.16),
        (0.05, 0.38),
        (-0.05, 0.38),
        (-0.07, 0.16),
        (-0.16, 0.06),
    ]
    # A jersey barrier: a plate with its cross-section, a unit thick, turned to lie along X. Its flanks are concave: the
    # caps are cut into convex halves.
    caps = [
        moved(merge(*plate(half, 1.0)[:2]), turn=90.0)
        for half in (outline[:3] + outline[7:], [*outline[3:7], outline[7], outline[2]])
    ]
    flanks = moved(plate(outline, 1.0)[2], turn=90.0)
    parts = [in_colour(colour, flanks, *caps)]
    if colour != "concrete":
        stripes = [moved(facing(0.9, 0.07, 0.066, 0.24), turn=turn) for turn in (0.0, 180.0)]
        parts.append(in_colour("black" if colour == "yellow" else "white", *stripes))
    return Piece(merge(*parts), BoxCollider(0.5, 0.16, 0.38))


def _barrel(colour: str) -> Piece:
    dark = {"red": "dark red", "yellow": "black", "gold": "bark", "brown": "dark", "orange": "dark red"}[colour]
    colour = "bark" if colour == "brown" else colour
    heights = (0.0, 0.1, 0.125, 0.225, 0.25, 0.34)
    bands = [lathe([(0.145, z0), (0.145, z1)], 12) for z0, z1 in pairwise(heights)]
    lid = lathe([(0.145, 0.34), (0.13, 0.34), (0.13, 0.325), (0.0, 0.325)], 12)
    return Piece(
        merge(in_colour(colour, *bands[::2], lid), in_colour(dark, *bands[1::2])), BoxCollider(0.145, 0.145, 0.34)
    )


def _tyre_stack() -> Piece:
    tyre = lathe([(0.12, 0.01), (0.17, 0.0), (0.2, 0.03), (0.2, 0.07), (0.17, 0.1), (0.12, 0.09)], 12)
    places = ((0.0, 0.0), (0.015, 0.01), (-0.012, 0.012), (0.008, -0.012))
    tyres = [moved(tyre, (x, y, 0.1 * i)) for i, (x, y) in enumerate(places)]
    hole = lathe([(0.12, 0.39), (0.12, 0.25), (0.0, 0.25)], 12)
    marks = [lathe([(0.172, 0.1 * i + 0.094), (0.172, 0.1 * i + 0.106)], 12) for i in range(1, 4)]
    return Piece(
        merge(in_colour("rubber", *tyres), in_colour("black", hole), in_colour("metal", *marks)),
        BoxCollider(0.2, 0.2, 0.4),
    )


def _hydrant() -> Piece:
    body = lathe(
        [
            (0.1, 0.0),
            (0.1, 0.03),
            (0.068, 0.04),
            (0.068, 0.19),
            (0.085, 0.195),
            (0.085, 0.215),
            (0.06, 0.25),
            (0.0, 0.27),
        ],
        10,
    )
    caps = [moved(lathe([(0.035, 0.0), (0.035, 0.05), (0.0, 0.05)], 8), (0.0, 0.06, 0.14), pitch=-90.0)]
    arms = [
        moved(moved(lathe([(0.028, 0.0), (0.028, 0.04), (0.0, 0.04)], 8), (0.0, 0.06, 0.15), pitch=-90.0), turn=turn)
        for turn in (90.0, 270.0)
    ]
    nut = box(0.03, 0.03, 0.03, base=0.265)
    return Piece(merge(in_colour("red", body), in_colour("yellow", *caps, *arms, nut)), BoxCollider(0.1, 0.1, 0.29))


def _mailbox() -> Piece:
    legs = [moved(box(0.03, 0.03, 0.09), (x, y, 0.0)) for x in (-0.1, 0.1) for y in (-0.09, 0.09)]
    # Its top is half a barrel, lying along X.
    top = [(0.12 * math.cos(math.radians(a)), 0.34 + 0.12 * math.sin(math.radians(a))) for a in range(0, 181, 30)]
    front, back, rim = (moved(part, turn=90.0) for part in plate(top, 0.26))
    mesh = merge(
        in_colour("blue", box(0.26, 0.24, 0.26, base=0.08), front, back, rim),
        in_colour("dark", *legs),
        in_colour("white", facing(0.16, 0.08, 0.122, 0.2)),
        in_colour("black", facing(0.18, 0.025, 0.122, 0.31)),
    )
    return Piece(mesh, BoxCollider(0.13, 0.12, 0.46))


def _bin(colour: str = "green") -> Piece:
    side, trim = {"green": ("dark green", "silver"), "silver": ("metal", "dark"), "black": ("dark", "silver")}[colour]
    body = lathe([(0.11, 0.0), (0.135, 0.27)], 10)
    lid = lathe([(0.15, 0.27), (0.15, 0.3), (0.1, 0.35), (0.0, 0.37)], 10)
    bars = lathe([(0.129, 0.11), (0.132, 0.16)], 10)
    mesh = merge(
        in_colour(side, body),
        in_colour(colour, lid),
        in_colour(trim, bars),
        in_colour("black", facing(0.12, 0.04, 0.146, 0.225)),
    )
    return Piece(mesh, BoxCollider(0.15, 0.15, 0.37))


def _bags() -> Piece:
    sack = merge(
        stretched(ball(0.11, 0.11, sides=8, rings=5), 1.0, 0.95, 0.85),
        lathe([(0.02, 0.175), (0.045, 0.215), (0.0, 0.2)], 6),
    )
    places = ((-0.09, 0.02, 0.0), (0.1, 0.04, 50.0), (0.01, -0.08, 20.0))
    sacks = [moved(sack, (x, y, 0.0), turn) for x, y, turn in places]
    return Piece(merge(in_colour("black", *sacks[:2]), in_colour("dark", sacks[2])), BoxCollider(0.2, 0.17, 0.2))


def _tree() -> Piece:
    trunk = lathe([(0.09, 0.0), (0.06, 0.12), (0.05, 1.1)], 7)
    crowns = [
        moved(stretched(ball(0.42, 0.0, sides=8, rings=5), 1.0, 1.0, 0.85), offset)
        for offset in ((0.0, 0.0, 1.6), (0.2, 0.16, 1.3), (-0.2, -0.1, 1.28))
    ]
    mesh = merge(in_colour("bark", trunk), in_colour("leaf light", crowns[0]), in_colour("leaf", crowns[1], crowns[2]))
    return Piece(mesh, BoxCollider(0.08, 0.08, 2.0))


def _stop_sign() -> Piece:
    corners = [(0.19 * math.cos(math.radians(a)), 1.0 + 0.19 * math.sin(math.radians(a))) for a in range(22, 382, 45)]
    front, back, rim = plate(corners, 0.02)
    mesh = merge(
        in_colour("metal", pole(0.02, 1.12), moved(merge(back, rim), (0.0, 0.035, 0.0))),
        moved(mapped(front, *STOP_FACE), (0.0, 0.035, 0.0)),
    )
    return Piece(mesh, BoxCollider(0.06, 0.06, 1.2))


def _speed_sign() -> Piece:
    front, back, rim = plate([(-0.15, 0.8), (0.15, 0.8), (0.15, 1.18), (-0.15, 1.18)], 0.02)
    mesh = merge(
        in_colour("metal", pole(0.02, 1.12), moved(merge(back, rim), (0.0, 0.035, 0.0))),
        moved(mapped(front, *SPEED_FACE), (0.0, 0.035, 0.0)),
    )
    return Piece(mesh, BoxCollider(0.06, 0.06, 1.2))


def _banner() -> Piece:
    return Piece(banner_mesh(), None)


def _shop_sign() -> Piece:
    return Piece(shop_sign_mesh(), None)


_COLOURED: dict[str, Callable[[str], Piece]] = {
    "cone": _cone,
    "dumpster": _dumpster,
    "barrier": _barrier,
    "barrel": _barrel,
    "bench": _bench,
    "bin": _bin,
    "lamp_post": _lamp_post,
    "traffic_light": _traffic_light,
    "car": roadside.car,
    "kiosk": roadside.kiosk,
    "awning": roadside.awning,
}
_PLAIN: dict[str, Callable[[], Piece]] = {
    "phone_booth": _phone_booth,
    "bench": _bench,
    "lamp_post": _lamp_post,
    "traffic_light": _traffic_light,
    "tyre_stack": _tyre_stack,
    "hydrant": _hydrant,
    "mailbox": _mailbox,
    "bin": _bin,
    "bags": _bags,
    "tree": _tree,
    "stop_sign": _stop_sign,
    "speed_sign": _speed_sign,
    "banner": _banner,
    "planter": roadside.planter,
    "zebra_crossing": roadside.zebra_crossing,
    "shop_sign": _shop_sign,
}
