"""A section of the city as a scene: streets and pavements, buildings, street furniture."""

import math
from collections.abc import Sequence

import numpy as np

from server.sim.banners import banner_texture
from server.sim.cameras import FAR
from server.sim.facades import BAYS, STOREYS, facade
from server.sim.furniture import COLOURS, piece_of
from server.sim.labels import Label
from server.sim.markings import DASH, Dash, dashes
from server.sim.meshes import Vector, merge, moved, quad
from server.sim.palette import palette
from server.sim.scene import Body, BoxCollider, Mesh, Scene
from server.sim.section import Building, Prop, Section
from server.sim.textures import GROUND_SPAN, Image, texture

PAVEMENT = 0.8
"""Width of the pavement around a building, in units."""

_KERB, _LINE = 0.07, 0.12
_TILE = 16.0
"""Side of the squares that the ground is laid in, in units: one huge one would lose precision at its edges."""

_BEYOND = 40.0
"""How far the ground goes on beyond the bounds and the buildings, in units."""


def city_scene(section: Section) -> Scene:
    """The scene of a section: everything but the episodes' own objects.

    Its bodies are named "building/0", "cone/0" and so on, numbered in the section's order, and "asphalt", "kerbs",
    "pavements", "lines", "roofs". What is near the eye comes first: who draws in order shades fewer pixels twice.

    Raises:
        ValueError: for a prop of an unknown kind or in a colour or shape that it does not come in.
        KeyError: for an unknown facade.
    """
    meshes: dict[str, Mesh] = {}
    textures: dict[str, Image] = {}
    bodies: list[Body] = []
    counts: dict[str, int] = {}
    for prop in section.props:
        number = counts[prop.kind] = counts.get(prop.kind, -1) + 1
        bodies.append(_prop_body(prop, number, meshes, textures))
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
                label=str(Label("building", look=building.facade)),
            )
        )
    for name, label, cover, mesh in _ground(section):
        meshes[name], textures[cover] = mesh, texture(cover)
        bodies.append(Body(name, name, cover, (0.0, 0.0, 0.0), label=label))
    return Scene(f"section {section.id}", tuple(bodies), meshes, textures)


def _prop_body(prop: Prop, number: int, meshes: dict[str, Mesh], textures: dict[str, Image]) -> Body:
    """The body of a prop; adds its mesh and its texture."""
    piece = piece_of(prop.kind, prop.colour if prop.kind != "banner" else "")
    mesh = prop.kind if prop.kind == "banner" or not prop.colour else f"{prop.kind}/{prop.colour}"
    cover = "furniture"
    if prop.kind == "banner":
        cover = f"banner/{prop.colour}/{prop.shape}/{prop.shape_colour}"
        textures[cover] = banner_texture(prop.colour, prop.shape, prop.shape_colour)
    else:
        textures[cover] = palette()
    meshes[mesh] = piece.mesh
    label = str(label_of_prop(prop))
    place = (prop.x, prop.z, 0.0)
    return Body(f"{prop.kind}/{number}", mesh, cover, place, prop.heading, collider=piece.collider, label=label)


def label_of_prop(prop: Prop) -> Label:
    """What a prop is seen as."""
    if prop.kind == "banner":
        return Label(prop.kind, prop.colour, prop.shape)
    colours = COLOURS.get(prop.kind, ("",))
    return Label(prop.kind, prop.colour or colours[0])


def building_mesh(building: Building, number: int = 0) -> Mesh:
    """Four walls in the building's own frame: whole storeys of about a unit, whole bays of about a unit.

    Args:
        building: what to build; its x, z and heading are left to the body.
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
    """A wall in stretches of the texture: all of its storeys first, its upper storeys again for what is higher."""
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
    """(name, label, texture, mesh) of what covers the ground, the top layer first, and of the roofs."""
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
    lines = dashes(section, PAVEMENT)
    if lines:
        layers.append(("lines", "road", "line", merge(*(_line(dash) for dash in lines))))
    layers.append(("asphalt", "road", "asphalt", _asphalt(section)))
    return layers


def _slab(building: Building, margin: float, height: float) -> Mesh:
    """A rectangle `margin` units larger than the building on every side; its texture lies along the building."""
    x, y = building.half_width + margin, building.half_length + margin
    corners: list[Vector] = [(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)]
    flat = quad(corners, (0.0, 2 * x / GROUND_SPAN), (0.0, 2 * y / GROUND_SPAN))
    return moved(flat, (building.x, building.z, height), building.heading)


def _line(dash: Dash) -> Mesh:
    x, y = _LINE / 2, DASH / 2
    return moved(quad([(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)]), (dash.x, dash.z, 0.003), dash.heading)


def _asphalt(section: Section) -> Mesh:
    """Ground in all directions, in squares along the main streets."""
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
