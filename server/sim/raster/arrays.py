"""The rasteriser's arrays: scene geometry, textures, frame constants and scratch buffers."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Bodies = npt.NDArray[np.float64]
"""(n, 10): X, Y, Z, cosine and sine of the heading, scale; the indices of the mesh, the texture and the label, and the
number of the body's first polygon in the frame."""

Floats = npt.NDArray[np.float32]
Doubles = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int32]


class Geometry(NamedTuple):
    """Concatenated meshes. A mesh is a range of clusters, a cluster a range of points and of polygons.

    Attributes:
        points: (n, 3) positions, in the mesh's own frame; clusters do not share points.
        corners: corners of all polygons, as indices of points within the cluster.
        shapes: (polygons, 3): first corner, number of corners, and whether the normal varies.
        planes: (polygons, 25): normal (3) and distance from the origin; u and v as functions of the position (4 each,
            three factors and a constant; v runs downwards, both are at least 0); texture area per unit of area;
            normal (3 x 4).
        clusters: (clusters, 4): first point, first polygon, end of the points, end of the polygons.
        spheres: (clusters, 4): centre and radius of the bounding sphere.
        meshes: (meshes, 2): first cluster and end of the clusters.
    """

    points: Floats
    corners: Integers
    shapes: Integers
    planes: Floats
    clusters: Integers
    spheres: Floats
    meshes: Integers


class Textures(NamedTuple):
    """Textures with their mipmaps, one below the other: all levels have the row width of the largest, partly unused.

    Attributes:
        texels: texels of all textures, as 0xBBGGRR.
        places: (textures, 5): first texel, width, height, R, and number of levels. R is a power of 2, and
            level i begins at row R - (R >> i).
    """

    texels: Integers
    places: Integers


class FrameConstants(NamedTuple):
    """Constants of all frames of one size.

    Attributes:
        size: side of the frame in pixels.
        levels: number of mipmap levels used.
        focal: focal length, in pixels.
        near: distance of the near plane, in units.
        far: distance of the far plane, in units.
        ambient: brightness of every surface.
        diffuse: additional brightness of a surface that faces the sun.
        sun: direction to the sun, of unit length.
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
    """Scratch buffers for one frame size.

    Attributes:
        keys: (size * size,): high 32 bits: the bits of 1/depth of the nearest polygon; low: its number in this frame,
            0 for none.
        order: (clusters, 3): clusters in view: whether of an actor, index of the body, index of the cluster.
        distances: (clusters,): lower bound of each cluster's distance ahead of the eye.
        points: (n, 5): points of a cluster: right, up and ahead of the eye; column and row.
        pixels: (n, 2): for each point the first column and row whose pixel centres are not before it.
        outline: corners of a clipped polygon, as indices of points.
        spans: (size, 2): first and end column of a polygon in each row.
        functions: (polygons, 14): coefficients in image space, of column, row and 1: u (3) and its value at the eye,
            the same for v, the same for the sun's cosine; texels per pixel at distance 1; 1/depth per column.
        marks: (polygons, 6): kind (1 patterned, 2 curved, 3 both), texture, label, brightness, colour, 1 for an actor.
        indices: (size + 8,): texel indices of a row.
        colours: (size,): unlit colours of a row, 0xBBGGRR.
        shades: (size + 8,): brightness of a row.
        lit: (4 * size + 3,): lit colours of four rows, 0xBBGGRR.
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


def new_scratch(size: int, polygons: int, clusters: int, points: int, corners: int) -> Scratch:
    """Allocate buffers for frames of `size` x `size` pixels.

    Args:
        size: side of the frame, in pixels.
        polygons: maximum number of polygons in a frame.
        clusters: maximum number of clusters in a frame.
        points: maximum number of points in a cluster.
        corners: maximum number of corners of a polygon.
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
        lit=np.zeros(4 * size + 3, np.int32),
    )
