"""A section of the city as a scene: streets and pavements, buildings, street furniture."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from arramon_client.world import FURNITURE
from arramon_server.sim.assets.banners import banner_texture
from arramon_server.sim.assets.facades import BAYS, STOREYS, facade
from arramon_server.sim.assets.furniture import COLOURS, piece_of
from arramon_server.sim.assets.markings import DASH, Dash, dashes
from arramon_server.sim.assets.meshes import Vector, merge, moved, quad
from arramon_server.sim.assets.palette import palette
from arramon_server.sim.assets.signs import shop_sign_texture
from arramon_server.sim.assets.textures import GROUND_SPAN, Image, texture
from arramon_server.sim.cameras import FAR
from arramon_server.sim.labels import SegmentationLabel
from arramon_server.sim.scene import Body, BoxCollider, Mesh, Scene
from arramon_server.sim.section import Building, Prop, Section

PAVEMENT = 0.8
"""Width of the pavement around a building, in units."""

CLEAR_OF_ZEBRA = 1.4
"""Minimum distance between the middles of a dash and a zebra crossing, in units."""

_KERB, _LINE = 0.07, 0.12
_TILE = 16.0
"""Side of the ground's squares, in units: a single huge square would lose precision at its edges."""

_BEYOND = 40.0
"""Width of the ground beyond the bounds and the buildings, in units."""


def city_scene(section: Section, spare: Iterable[Prop] = ()) -> Scene:
    """Build the scene of a section, without the episodes' own objects.

    Args:
        section: its geometry and furniture.
        spare: further props that scenes made from this one have (`refurnished`).

    Its bodies are named "building/0", "cone/0" and so on, numbered in the section's order, and "asphalt", "kerbs",
    "pavements", "lines", "roofs". Bodies near the eye come first, so that renderers that draw in
    order shade fewer pixels twice.

    Raises:
        ValueError: for a prop of an unknown kind, or in a colour or shape that its kind does not have.
        KeyError: for an unknown facade.
    """
    meshes: dict[str, Mesh] = {}
    textures: dict[str, Image] = {}
    bodies = _prop_bodies(section.props, meshes, textures)
    for i, building in enumerate(section.buildings):
        name = f"building/{i}"
        meshes[name] = building_mesh(building, i)
        textures[f"facade/{building.facade}"] = facade(building.facade)
        collider = BoxCollider(building.half_width, building.half_length, building.height)
        place = (building.x, building.z, 0.0)
        bodies.append(
            Body(
                name,
                name,
                f"facade/{building.facade}",
                place,
                building.heading,
                collider=collider,
                label=str(SegmentationLabel("building", look=building.facade)),
            )
        )
    for name, label, cover, mesh in _ground(section):
        meshes[name], textures[cover] = mesh, texture(cover)
        bodies.append(Body(name, name, cover, (0.0, 0.0, 0.0), label=label))
    spare_bodies = tuple(_prop_bodies(spare, meshes, textures))
    return Scene(f"section {section.id}", tuple(bodies), meshes, textures, spare_bodies)


def refurnished(scene: Scene, section: Section) -> Scene:
    """Return the scene of a section that differs from that of `scene` only in furniture other than zebra crossings.

    It equals `city_scene(section)`, but shares equal meshes, textures and bodies with `scene`.

    Raises:
        ValueError: as in `city_scene`.
    """
    meshes, textures = dict(scene.meshes), dict(scene.textures)
    kinds = frozenset(FURNITURE)
    before = {body.name: body for body in scene.bodies if body.name.partition("/")[0] in kinds}
    props = [_same(body, before.get(body.name)) for body in _prop_bodies(section.props, meshes, textures)]
    rest = [body for body in scene.bodies if body.name not in before]
    return Scene(
        scene.name,
        (*props, *rest),
        meshes if len(meshes) > len(scene.meshes) else scene.meshes,
        textures if len(textures) > len(scene.textures) else scene.textures,
        scene.spare,
    )


def _same(body: Body, before: Body | None) -> Body:
    """Return the earlier body if look and pose are equal, otherwise the new one."""
    if before is None:
        return body
    looks = [(one.mesh, one.texture, one.position, one.heading) for one in (body, before)]
    return before if looks[0] == looks[1] else body


def _prop_bodies(props: Iterable[Prop], meshes: dict[str, Mesh], textures: dict[str, Image]) -> list[Body]:
    """Return the bodies of props, numbered by kind, and add their meshes and textures to the given tables."""
    counts: dict[str, int] = {}
    bodies = []
    for prop in props:
        number = counts[prop.kind] = counts.get(prop.kind, -1) + 1
        bodies.append(_prop_body(prop, number, meshes, textures))
    return bodies


def _prop_body(prop: Prop, number: int, meshes: dict[str, Mesh], textures: dict[str, Image]) -> Body:
    """Return the body of a prop, and add its mesh and texture to the given tables."""
    piece = piece_of(prop.kind, prop.colour if prop.kind != "banner" else "")
    mesh = prop.kind if prop.kind == "banner" or not prop.colour else f"{prop.kind}/{prop.colour}"
    cover = "furniture"
    if prop.kind == "banner":
        cover = f"banner/{prop.colour}/{prop.shape}/{prop.shape_colour}"
        textures[cover] = banner_texture(prop.colour, prop.shape, prop.shape_colour)
    elif prop.kind == "shop_sign":
        cover = f"sign/{prop.shape}"
        textures[cover] = shop_sign_texture(prop.shape)
    else:
        textures[cover] = palette()
    meshes[mesh] = piece.mesh
    label = str(label_of_prop(prop))
    place = (prop.x, prop.z, 0.0)
    return Body(f"{prop.kind}/{number}", mesh, cover, place, prop.heading, collider=piece.collider, label=label)


def label_of_prop(prop: Prop) -> SegmentationLabel:
    """Return the segmentation label of a prop."""
    if prop.kind in ("banner", "shop_sign"):
        return SegmentationLabel(prop.kind, prop.colour, prop.shape)
    colours = COLOURS.get(prop.kind, ("",))
    return SegmentationLabel(prop.kind, prop.colour or colours[0])


def building_mesh(building: Building, number: int = 0) -> Mesh:
    """Build four walls in the building's own frame, in whole storeys and whole bays of about a unit.

    Args:
        building: its size; its x, z and heading are applied by the body.
        number: shifts the doors along the walls, so that neighbours differ.
    """
    x, y = building.half_width, building.half_length
    corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
    walls = []
    for side, (start, end) in enumerate(zip(corners, corners[1:] + corners[:1], strict=True)):
        bays = max(1, round(math.dist(start, end)))
        first = (number + side) % BAYS
        walls.append(_wall(start, end, building.height, (first / BAYS, (first + bays) / BAYS)))
    return merge(*walls)


def _wall(start: tuple[float, float], end: tuple[float, float], height: float, u: tuple[float, float]) -> Mesh:
    """Build a wall: the whole texture from the ground, then its upper storeys, repeated."""
    storeys = max(1, round(height))
    each = height / storeys
    (x0, y0), (x1, y1) = start, end
    stretches, done = [], 0
    while done < storeys:
        from_row = 0 if done == 0 else 1
        rows = min(storeys - done, STOREYS - from_row)
        low, high = done * each, (done + rows) * each
        corners: list[Vector] = [(x0, y0, low), (x1, y1, low), (x1, y1, high), (x0, y0, high)]
        stretches.append(quad(corners, u, (from_row / STOREYS, (from_row + rows) / STOREYS)))
        done += rows
    return merge(*stretches)


def _ground(section: Section) -> list[tuple[str, str, str, Mesh]]:
    """Return (name, label, texture, mesh) of the roofs and of the ground's layers, the top layer first."""
    layers = []
    if section.buildings:
        roofs = [_slab(b, 0.0, b.height) for b in section.buildings]
        pavements = [_slab(b, PAVEMENT, 0.012) for b in section.buildings]
        kerbs = [_slab(b, PAVEMENT + _KERB, 0.006) for b in section.buildings]
        layers = [
            ("roofs", "roof", "roof", merge(*roofs)),
            ("pavements", "pavement", "pavement", merge(*pavements)),
            ("kerbs", "pavement", "kerb", merge(*kerbs)),
        ]
    zebras = [prop for prop in section.props if prop.kind == "zebra_crossing"]
    lines = [
        dash
        for dash in dashes(section, PAVEMENT)
        if all(math.dist((dash.x, dash.z), (zebra.x, zebra.z)) > CLEAR_OF_ZEBRA for zebra in zebras)
    ]
    if lines:
        layers.append(("lines", "road", "line", merge(*(_line(dash) for dash in lines))))
    layers.append(("asphalt", "road", "asphalt", _asphalt(section)))
    return layers


def _slab(building: Building, margin: float, height: float) -> Mesh:
    """Build a rectangle `margin` units larger than the building on every side, with its texture along the building."""
    x, y = building.half_width + margin, building.half_length + margin
    corners: list[Vector] = [(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)]
    flat = quad(corners, (0.0, 2 * x / GROUND_SPAN), (0.0, 2 * y / GROUND_SPAN))
    return moved(flat, (building.x, building.z, height), building.heading)


def _line(dash: Dash) -> Mesh:
    x, y = _LINE / 2, DASH / 2
    return moved(quad([(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)]), (dash.x, dash.z, 0.003), dash.heading)


def _asphalt(section: Section) -> Mesh:
    """Build the ground in all directions, as squares aligned with the main streets."""
    x0, z0, x1, z1 = section.bounds
    middle = ((x0 + x1) / 2, (z0 + z1) / 2)
    reach = math.hypot(x1 - x0, z1 - z0) / 2
    far = [math.dist(middle, (b.x, b.z)) + math.hypot(b.half_width, b.half_length) for b in section.buildings]
    tiles = math.ceil(min(max([reach, *far]) + _BEYOND, reach + FAR) / _TILE)
    steps: Sequence[float] = (np.arange(-tiles, tiles) * _TILE).tolist()
    span = _TILE / GROUND_SPAN
    squares = []
    for x in steps:
        for y in steps:
            corners: list[Vector] = [(x, y, 0.0), (x + _TILE, y, 0.0), (x + _TILE, y + _TILE, 0.0), (x, y + _TILE, 0.0)]
            squares.append(quad(corners, (0.0, span), (0.0, span)))
    return moved(merge(*squares), (*middle, 0.0), section.heading)
