"""Scenes as data: named bodies with meshes, textures and poses, from which collision checks and cameras are built.

Everything here is in the scene frame (right-handed, z up; see `geometry`): X is the world's x, Y its z, Z its y.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles with texture coordinates and flat or smooth normals.

    Attributes:
        vertices: (n, 3) float32, units, in the body's own frame: X right, Y ahead, Z up, the origin on the ground.
        uvs: (n, 2) float32; v runs upwards; the texture repeats beyond [0, 1].
        normals: (n, 3) float32, unit length, outwards.
        triangles: (m, 3) int32, counter-clockwise seen from outside.
    """

    vertices: npt.NDArray[np.float32]
    uvs: npt.NDArray[np.float32]
    normals: npt.NDArray[np.float32]
    triangles: npt.NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class BoxCollider:
    """A solid box around the body's vertical axis.

    Attributes:
        half_width: half its extent along X, in units.
        half_length: half its extent along Y, in units.
        height: height above the body's origin, in units.
    """

    half_width: float
    half_length: float
    height: float


@dataclass(frozen=True, eq=False)
class Body:
    """A named object of a scene.

    Attributes:
        name: unique in its scene, for example "building/3", "cone/0", "collectible/striped red mug/0".
        mesh: name of its mesh in `Scene.meshes`.
        texture: name of its texture in `Scene.textures`.
        position: (X, Y, Z) of the body's origin, units.
        heading: degrees clockwise seen from above; the body's own Y axis points there.
        scale: uniform scale of the mesh.
        collider: its solid part; None for bodies without collisions (ground, collectibles, banners).
        label: its kind, for segmentation: "building", "cone", "striped red mug", ...
    """

    name: str
    mesh: str
    texture: str
    position: tuple[float, float, float]
    heading: float = 0.0
    scale: float = 1.0
    collider: BoxCollider | None = None
    label: str = ""


@dataclass(frozen=True, eq=False)
class Scene:
    """Bodies with their meshes and textures.

    Attributes:
        bodies: their names are unique in the scene.
        meshes: meshes by name.
        textures: textures by name; (height, width, 3) uint8, the first row at the top (v = 1).
        spare: bodies that are not in this scene, but may be in others that share its camera (`Camera.showing`): their
            meshes, textures and labels are known. Their poses mean nothing.
    """

    name: str
    bodies: tuple[Body, ...]
    meshes: Mapping[str, Mesh] = field(repr=False)
    textures: Mapping[str, npt.NDArray[np.uint8]] = field(repr=False)
    spare: tuple[Body, ...] = ()


@dataclass(frozen=True, eq=False)
class SceneDifference:
    """The difference between two scenes that share bodies; by default none.

    Attributes:
        removed: bodies of the first scene alone.
        added: bodies of the second scene alone.
    """

    removed: frozenset[Body] = frozenset()
    added: tuple[Body, ...] = ()

    @classmethod
    def between(cls, first: Scene, second: Scene) -> "SceneDifference":
        """Return the difference; bodies that are the same object are in both."""
        there = set(first.bodies)
        return cls(
            frozenset(there.difference(second.bodies)), tuple(body for body in second.bodies if body not in there)
        )
