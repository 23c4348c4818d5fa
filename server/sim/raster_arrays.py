"""The arrays that the rasteriser works on, grouped: what a scene becomes, and the room that a picture is made in."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Bodies = npt.NDArray[np.float64]
"""(n, 10): X, Y, Z, cosine and sine of the heading, scale; the numbers of the mesh, the texture, the label, and of the
body's first polygon in the frame."""

Floats = npt.NDArray[np.float32]
Doubles = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int32]


class Geometry(NamedTuple):
    """Meshes, one after the other. A mesh is a range of clusters, a cluster a range of points and of polygons.

    Attributes:
        points: (n, 3) positions, in the mesh's own frame; a cluster's points are its own.
        corners: of all polygons, by number of the point within the cluster.
        shapes: (polygons, 3): the first corner, how many there are, and whether the normal varies.
        planes: (polygons, 25): normal (3) and distance from the origin; u and v as functions of the position (4 each,
            three factors and a constant; v runs downwards, both are at least 0); texture area per area; normal (3 x 4).
        clusters: (clusters, 4): first point, first polygon, and the end of each.
        spheres: (clusters, 4): centre and radius.
        meshes: (meshes, 2): first cluster and end.
    """

    points: Floats
    corners: Integers
    shapes: Integers
    planes: Floats
    clusters: Integers
    spheres: Floats
    meshes: Integers


class Textures(NamedTuple):
    """Textures with their mipmaps, one below the other: all levels have the rows of the largest, partly unused.

    Attributes:
        texels: all, as 0xBBGGRR.
        places: (textures, 5): the first texel, width, height, R, and how many levels there are. R is a power of 2, and
            level i begins at row R - (R >> i).
    """

    texels: Integers
    places: Integers


class Setting(NamedTuple):
    """What is the same in all frames of a size.

    Attributes:
        size: side of the picture in pixels.
        levels: of mipmaps that may be used.
        focal: pixels that one unit has at one unit's distance.
        near: where drawing begins, in units ahead of the eye.
        far: where it ends.
        ambient: share of its colour that every surface has.
        diffuse: more, for a surface that faces the sun.
        sun: direction to it, unit length.
    """

    size: int
    levels: int
    focal: float
    near: float
    far: float
    ambient: float
    diffuse: float
    sun: tuple[float, float, float]


class Scratch(NamedTuple):
    """Room to work in, for one size of picture.

    Attributes:
        keys: (size * size,): the bits of 1/depth of the nearest polygon, above its number in this frame; 0 is none.
        order: (clusters, 3): what is in the picture: whether of an actor, the number of the body, the cluster.
        distances: (clusters,): how far ahead of the eye each begins.
        points: (n, 5): of a cluster: to the right, up, ahead of the eye; column and row.
        pixels: (n, 2): the first column and row of pixels whose centres are not before each point.
        outline: of a polygon that was cut, by number of the point.
        spans: (size, 2): from and to which column it covers each row.
        functions: (polygons, 14): on the picture, of column, row and 1: u (3) and its value at the eye, the same for v,
            the same for the sun's cosine; texels in a pixel at distance 1; 1/depth a column.
        marks: (polygons, 6): kind (1 patterned, 2 curved, 3 both), texture, label, brightness, colour, actor or not.
        indices: (size + 8,): texels of a row.
        colours: (size,): of a row, 0xBBGGRR, unlit.
        shades: (size + 8,): brightness of a row.
        lit: (size * size + 3,): the picture, 0xBBGGRR.
    """

    keys: npt.NDArray[np.int64]
    order: Integers
    distances: Doubles
    points: Doubles
    pixels: Integers
    outline: Integers
    spans: Integers
    functions: Floats
    marks: Integers
    indices: Integers
    colours: Integers
    shades: Integers
    lit: Integers


def scratch(size: int, polygons: int, clusters: int, points: int, corners: int) -> Scratch:
    """For pictures of `size` x `size` pixels.

    Args:
        size: in pixels.
        polygons: the most that a frame may hold.
        clusters: the most that a frame may hold.
        points: the most of a cluster.
        corners: the most of a polygon.
    """
    return Scratch(
        keys=np.zeros(size * size, np.int64),
        order=np.zeros((clusters, 3), np.int32),
        distances=np.zeros(clusters, np.float64),
        points=np.zeros((points + corners, 5), np.float64),
        pixels=np.zeros((points + corners, 2), np.int32),
        outline=np.zeros(corners + 2, np.int32),
        spans=np.zeros((size, 2), np.int32),
        functions=np.zeros((polygons + 1, 14), np.float32),
        marks=np.zeros((polygons + 1, 6), np.int32),
        indices=np.zeros(size + 8, np.int32),
        colours=np.zeros(size, np.int32),
        shades=np.zeros(size + 8, np.int32),
        lit=np.zeros(size * size + 3, np.int32),
    )
