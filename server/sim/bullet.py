"""Collision checks and the reference camera with pybullet. The only module that imports pybullet."""

import math
import os
import tempfile
from collections import Counter
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
import numpy.typing as npt
from PIL import Image

from arramon_client.world import AGENT_RADIUS, FIELD_OF_VIEW
from arramon_server.sim.assets.collectibles import mesh_of, texture_of
from arramon_server.sim.cameras import FAR, NEAR, THOUSANDTH, Actor, Frame, Viewpoint, label_of, labels_of
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.daylight import AMBIENT, DIFFUSE, SUN, sky
from arramon_server.sim.footprints import PROBE_HEIGHT, TOUCHING, Footprint, Place
from arramon_server.sim.scene import Body, BoxCollider, Mesh, Scene, SceneDifference


@contextmanager
def _discarded_stderr() -> Iterator[None]:
    """Discard what C code writes to standard error: pybullet prints a banner on import."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


with _discarded_stderr():
    import pybullet

_REACH = AGENT_RADIUS + 0.01
"""Distance of a body from the agent's way, in units, beyond which it is not checked."""

_FARTHEST = 65535
_NUDGE = 1e-4
"""Units by which the camera is moved ahead: TinyRenderer drops triangles with a corner right beside the eye."""


class Obstacles:
    """The solid bodies of a scene in one pybullet client, for collision checks (`rules.CollisionCheck`).

    Its answers equal those of `footprints.Footprints`: pybullet differs from the exact distance only for bodies that
    the agent almost touches, and for these the exact distance is used. Use it as a context manager, or `close` it.
    It belongs to one thread.

    Args:
        scene: its bodies, meshes and textures.
        exact_within: largest difference between the agent's radius and a body's distance from its way, in units, at
            which the exact distance decides about the body. With 0 pybullet decides, for benchmarks that compare them.

    Raises:
        ValueError: for two bodies with the same name, a mesh or texture that is not in the scene, or a collider that is
            not solid at `footprints.PROBE_HEIGHT`.
    """

    def __init__(self, scene: Scene, exact_within: float = TOUCHING) -> None:
        _check(scene)
        self._exact_within = exact_within
        self._client: int | None = pybullet.connect(pybullet.DIRECT)
        self._solid: dict[int, Body] = {}
        self._footprints: dict[int, Footprint] = {}
        self._probes: dict[float, int] = {}
        self._boxes: dict[BoxCollider, int] = {}
        self._fill(scene)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Free the pybullet client. A second call has no effect."""
        if self._client is not None:
            pybullet.disconnect(self._client)
            self._client = None

    def way_is_free(
        self,
        start: Place,
        end: Place,
        removed: Container[Body] = (),
        added: Sequence[Body] = (),
    ) -> bool:
        """Return whether the agent's disc can move straight from `start` to `end` without touching a solid body.

        Args:
            start: (X, Y) on the scene's ground plane, units.
            end: the same.
            removed: bodies of the scene to ignore.
            added: bodies in addition to those of the scene, each with a collider.
        """
        near, beside = self._near(start, end, removed), _beside(start, end, added)
        unsure: list[int] = []
        for number in near:
            touched = self._exact(self._footprints[number], start, end)
            if touched:
                return False
            if touched is None:
                unsure.append(number)
        unsure_beside: list[Body] = []
        for body in beside:
            touched = self._exact(Footprint.of(body), start, end)
            if touched:
                return False
            if touched is None:
                unsure_beside.append(body)
        if not unsure and not unsure_beside:
            return True
        touches = self._probe_of(start, end)
        return not any(touches(bodyB=number) for number in unsure) and not any(
            touches(
                bodyB=-1,
                collisionShapeB=self._box(body),
                collisionShapePositionB=body.position,
                collisionShapeOrientationB=_turn(body.heading),
            )
            for body in unsure_beside
        )

    def _near(self, start: Place, end: Place, removed: Container[Body]) -> list[int]:
        """Return the ids of the bodies whose bounding boxes overlap that of a way."""
        (x0, y0), (x1, y1) = start, end
        overlapping = pybullet.getOverlappingObjects(
            (min(x0, x1) - _REACH, min(y0, y1) - _REACH, 0.0),
            (max(x0, x1) + _REACH, max(y0, y1) + _REACH, PROBE_HEIGHT + _REACH),
            physicsClientId=self._client,
        )
        found = {number for number, _ in overlapping or ()}
        return [number for number in found if number in self._solid and self._solid[number] not in removed]

    def _exact(self, footprint: Footprint, start: Place, end: Place) -> bool | None:
        """Return whether the agent touches a body on its way, by exact distance; None if pybullet can decide."""
        excess = footprint.distance(start, end) - AGENT_RADIUS
        return None if abs(excess) > self._exact_within else excess <= 0.0

    def _probe_of(self, start: Place, end: Place) -> Callable[..., object]:
        """Return a function that returns the contact points of the agent with a body on its way."""
        (x0, y0), (x1, y1) = start, end
        # A capsule's axis is its own Z: lay it down along X, then turn it about Z.
        half = math.atan2(y1 - y0, x1 - x0) / 2
        sin, cos = math.sin(half) * math.sqrt(0.5), math.cos(half) * math.sqrt(0.5)
        return partial(
            pybullet.getClosestPoints,
            bodyA=-1,
            distance=0.0,
            collisionShapeA=self._probe(math.hypot(x1 - x0, y1 - y0)),
            collisionShapePositionA=((x0 + x1) / 2, (y0 + y1) / 2, PROBE_HEIGHT),
            collisionShapeOrientationA=(-sin, cos, sin, cos),
            physicsClientId=self._client,
        )

    def _box(self, body: Body) -> int:
        """Return the collision shape of a body that is not part of the scene. Shapes are cached by size."""
        assert body.collider is not None
        if body.collider not in self._boxes:
            self._boxes[body.collider] = self._collision(body.collider)
        return self._boxes[body.collider]

    def _fill(self, scene: Scene) -> None:
        for body in scene.bodies:
            if body.collider is not None:
                self._add(body)

    def _add(self, body: Body, shape: int = -1) -> int:
        """Create a body, with a visual shape if given, and return its pybullet id."""
        number: int = pybullet.createMultiBody(
            baseMass=0.0,
            baseCollisionShapeIndex=-1 if body.collider is None else self._collision(body.collider),
            baseVisualShapeIndex=shape,
            basePosition=body.position,
            baseOrientation=_turn(body.heading),
            physicsClientId=self._client,
        )
        if body.collider is not None:
            self._solid[number] = body
            self._footprints[number] = Footprint.of(body)
        return number

    def _probe(self, length: float) -> int:
        """Return a collision capsule for a movement of `length` units. Capsules are cached by length."""
        key = round(length, 9)
        if key not in self._probes:
            self._probes[key] = pybullet.createCollisionShape(
                pybullet.GEOM_CAPSULE, radius=AGENT_RADIUS, height=key, physicsClientId=self._client
            )
        return self._probes[key]

    def _collision(self, collider: BoxCollider) -> int:
        half = collider.height / 2
        shape: int = pybullet.createCollisionShape(
            pybullet.GEOM_BOX,
            halfExtents=(collider.half_width, collider.half_length, half),
            collisionFramePosition=(0.0, 0.0, half),
            physicsClientId=self._client,
        )
        return shape


class ReferenceCamera(Obstacles):
    """A scene with collisions and visual shapes: the reference camera (`cameras.Camera`)."""

    def _fill(self, scene: Scene) -> None:
        self._scene, self._meshes, self._labels = scene, scene.meshes, labels_of(scene)
        self._places = {body: place for place, body in enumerate(scene.bodies)}
        self._label_numbers: dict[int, int] = {}
        self._bodies: dict[str, int] = {}
        self._actors: dict[tuple[ObjectType, float], list[int]] = {}
        self._added: dict[tuple[str, str, float, str], list[int]] = {}
        self._extents = _extents(scene)
        self._drawn = np.ones(len(scene.bodies), dtype=bool)
        textures = self._load(scene.textures.values())
        self._textures = dict(zip(scene.textures, textures, strict=True))
        self._shapes: dict[tuple[str, float], int] = {}
        for body in scene.bodies:
            self._bodies[body.name] = self._stand(body)
        self._static = tuple(self._bodies.values())

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of a segmentation, by number."""
        return self._labels

    def render(
        self,
        viewpoint: Viewpoint,
        actors: Sequence[Actor],
        size: int,
        *,
        segmentation: bool = False,
        into: Frame | None = None,
        difference: SceneDifference = SceneDifference(),  # noqa: B008 - it is immutable
    ) -> Frame:
        """Draw a frame of `size` x `size` pixels from `viewpoint`, with `actors` in the scene for this frame only.

        The same arguments give the same bytes, independent of earlier frames. `difference` gives the bodies to draw
        instead of the scene's own.
        """
        self._cull(viewpoint, difference.removed)
        shown = [*self._pose(actors), *self._show_added(difference.added)]
        frame = self._draw(viewpoint, shown, size, segmentation=segmentation)
        if into is None:
            return frame
        into.depth[...] = frame.depth
        if into.rgb.size:
            into.rgb[...] = frame.rgb
        if into.depth.dtype == np.float32:
            into.depth[...] *= THOUSANDTH
        if frame.segmentation is None or into.segmentation is None:
            return Frame(into.rgb, into.depth, frame.segmentation)
        into.segmentation[...] = frame.segmentation
        return into

    def _draw(self, viewpoint: Viewpoint, shown: Iterable[int], size: int, *, segmentation: bool) -> Frame:
        """Draw a frame, and hide the bodies in `shown` again."""
        _, _, rgba, depth, bodies = pybullet.getCameraImage(
            size,
            size,
            _view_matrix(viewpoint),
            _projection_matrix(size),
            lightDirection=SUN,
            lightAmbientCoeff=AMBIENT,
            lightDiffuseCoeff=DIFFUSE,
            lightSpecularCoeff=0.0,
            shadow=0,
            renderer=pybullet.ER_TINY_RENDERER,
            flags=0 if segmentation else pybullet.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
        )
        for body in shown:
            self._tint(body, 0.0)
        inverse = FAR - (FAR - NEAR) * np.asarray(depth, np.float64).reshape(size, size)
        thousandths = np.minimum(FAR * NEAR * 1000.0 / inverse + 0.5, _FARTHEST).astype(np.uint16)
        nothing = inverse < NEAR * 1.001
        thousandths[nothing] = 0
        rgb = np.asarray(rgba, np.uint8).reshape(size, size, 4)[..., :3].copy()
        np.copyto(rgb, sky(size), where=nothing[..., None])
        if not segmentation:
            return Frame(rgb, thousandths)
        table = np.zeros(max(self._label_numbers, default=0) + 1, np.uint16)
        table[list(self._label_numbers)] = list(self._label_numbers.values())
        numbers = table[np.asarray(bodies, np.int64).reshape(size, size)]
        numbers[nothing] = 0
        return Frame(rgb, thousandths, numbers)

    def showing(self, scene: Scene) -> "ReferenceCameraView":
        """Return a camera that draws the bodies of another scene, in the same pybullet client."""
        return ReferenceCameraView(self, SceneDifference.between(self._scene, scene))

    def _cull(self, viewpoint: Viewpoint, removed: Iterable[Body]) -> None:
        """Hide bodies that are removed or entirely outside the frame: even invisible triangles take time."""
        angle, half = math.radians(viewpoint.heading), math.radians(FIELD_OF_VIEW) / 2
        x, y, radius = self._extents.T
        right = (x - viewpoint.x) * math.cos(angle) - (y - viewpoint.y) * math.sin(angle)
        ahead = (x - viewpoint.x) * math.sin(angle) + (y - viewpoint.y) * math.cos(angle)
        drawn = (np.abs(right) * math.cos(half) - ahead * math.sin(half) < radius) & (ahead > -radius)
        drawn[[self._places[body] for body in removed]] = False
        for i in np.flatnonzero(drawn != self._drawn):
            self._tint(self._static[i], float(drawn[i]))
        self._drawn = drawn

    def _pose(self, actors: Sequence[Actor]) -> list[int]:
        """Place a body for each actor, and return the pybullet ids."""
        taken: Counter[tuple[ObjectType, float]] = Counter()
        shown = []
        for actor in actors:
            key = (actor.type, actor.scale)
            pool = self._actors.setdefault(key, [])
            if taken[key] == len(pool):
                pool.append(self._new_actor(actor))
            body = pool[taken[key]]
            taken[key] += 1
            pybullet.resetBasePositionAndOrientation(
                body, actor.position, _turn(actor.heading), physicsClientId=self._client
            )
            self._tint(body, 1.0)
            shown.append(body)
        return shown

    def _show_added(self, added: Iterable[Body]) -> list[int]:
        """Show bodies that are not the scene's own, without collisions, and return the pybullet ids."""
        taken: Counter[tuple[str, str, float, str]] = Counter()
        shown = []
        for body in added:
            key = (body.mesh, body.texture, body.scale, label_of(body))
            pool = self._added.setdefault(key, [])
            if taken[key] == len(pool):
                pool.append(self._stand(replace(body, collider=None)))
            number = pool[taken[key]]
            taken[key] += 1
            pybullet.resetBasePositionAndOrientation(
                number, body.position, _turn(body.heading), physicsClientId=self._client
            )
            self._tint(number, 1.0)
            shown.append(number)
        return shown

    def _stand(self, body: Body) -> int:
        """Create a body of the scene or an added one, and return its pybullet id."""
        look = (body.mesh, body.scale)
        if look not in self._shapes:
            self._shapes[look] = self._shape(self._meshes[body.mesh], body.scale)
        return self._show(body, self._shapes[look], self._textures[body.texture])

    def _new_actor(self, actor: Actor) -> int:
        pool = self._actors[actor.type, actor.scale]
        name = f"collectible/{actor.type}/{actor.scale}/{len(pool)}"
        body = Body(name, actor.type.kind, str(actor.type), actor.position, label=str(actor.type))
        (texture,) = self._load([texture_of(actor.type)])
        self._bodies[name] = self._show(body, self._shape(mesh_of(actor.type.kind), actor.scale), texture)
        return self._bodies[name]

    def _tint(self, body: int, alpha: float) -> None:
        """Set a body's alpha; TinyRenderer does not draw bodies with alpha 0."""
        pybullet.changeVisualShape(body, -1, rgbaColor=(1.0, 1.0, 1.0, alpha), physicsClientId=self._client)

    def _load(self, textures: Iterable[npt.NDArray[np.uint8]]) -> list[int]:
        """Load textures and return their pybullet ids. pybullet reads textures from files only."""
        ids = []
        with tempfile.TemporaryDirectory(prefix="arramon-") as folder:
            for i, texture in enumerate(textures):
                path = Path(folder) / f"{i}.png"
                Image.fromarray(texture).save(path, compress_level=1)
                ids.append(pybullet.loadTexture(str(path), physicsClientId=self._client))
        return ids

    def _shape(self, mesh: Mesh, scale: float) -> int:
        # TinyRenderer repeats textures by the fraction of u and v, which is wrong below 0.
        uvs = mesh.uvs - np.floor(mesh.uvs.min(axis=0))
        shape: int = pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            vertices=(mesh.vertices * scale).tolist(),
            uvs=uvs.tolist(),
            normals=mesh.normals.tolist(),
            indices=mesh.triangles.reshape(-1).tolist(),
            physicsClientId=self._client,
        )
        return shape

    def _show(self, body: Body, shape: int, texture: int) -> int:
        """Create a body with its visual shape and texture, and return its pybullet id."""
        number = self._add(body, shape)
        pybullet.changeVisualShape(number, -1, textureUniqueId=texture, physicsClientId=self._client)
        self._label_numbers[number] = self._labels.index(label_of(body))
        return number


class ReferenceCameraView:
    """A reference camera that draws another scene (`cameras.Camera`).

    Args:
        camera: camera of the scene with which it shares meshes and textures.
        difference: difference between that scene and the one to draw.
    """

    def __init__(self, camera: ReferenceCamera, difference: SceneDifference) -> None:
        self._camera, self._difference = camera, difference

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of a segmentation, by number."""
        return self._camera.labels

    def render(
        self,
        viewpoint: Viewpoint,
        actors: Sequence[Actor],
        size: int,
        *,
        segmentation: bool = False,
        into: Frame | None = None,
    ) -> Frame:
        """Draw a frame, as `ReferenceCamera.render` does."""
        return self._camera.render(
            viewpoint, actors, size, segmentation=segmentation, into=into, difference=self._difference
        )

    def showing(self, scene: Scene) -> "ReferenceCameraView":
        """Return a camera that draws the bodies of a third scene."""
        return self._camera.showing(scene)


def _beside(start: Place, end: Place, added: Sequence[Body]) -> list[Body]:
    """Return the bodies that are near enough to a way to be touched."""
    if not added:
        return []
    middle, reach = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2), _REACH + math.dist(start, end) / 2
    return [body for body in added if math.dist(middle, body.position[:2]) <= reach + _radius(body)]


def _radius(body: Body) -> float:
    """Return the radius of the circle around a body's axis that contains its collider, in units."""
    assert body.collider is not None
    return math.hypot(body.collider.half_width, body.collider.half_length)


def _check(scene: Scene) -> None:
    seen: set[str] = set()
    for body in scene.bodies:
        if body.name in seen:
            raise ValueError(f"scene {scene.name!r} has two bodies named {body.name!r}")
        seen.add(body.name)
    for body in (*scene.bodies, *scene.spare):
        for word, known, kind in ((body.mesh, scene.meshes, "mesh"), (body.texture, scene.textures, "texture")):
            if word not in known:
                raise ValueError(f"body {body.name!r} of scene {scene.name!r} names an unknown {kind} {word!r}")


def _extents(scene: Scene) -> npt.NDArray[np.float64]:
    """Return (n, 3): for each body the circle (X, Y, radius) on the ground that contains it."""
    reach = {name: float(np.hypot(*mesh.vertices[:, :2].T).max()) for name, mesh in scene.meshes.items()}
    circles = [(body.position[0], body.position[1], reach[body.mesh] * body.scale) for body in scene.bodies]
    return np.array(circles, np.float64).reshape(-1, 3)


def _turn(heading: float) -> tuple[float, float, float, float]:
    """Return the quaternion (x, y, z, w) of a heading: headings are clockwise, angles about Z anticlockwise."""
    half = math.radians(-heading) / 2
    return (0.0, 0.0, math.sin(half), math.cos(half))


def _view_matrix(viewpoint: Viewpoint) -> list[float]:
    """Return the matrix from scene to eye coordinates (X right, Y up, looking along -Z), column-major as in OpenGL."""
    angle = math.radians(viewpoint.heading)
    sin, cos = math.sin(angle), math.cos(angle)
    x, y, z = viewpoint.x + _NUDGE * sin, viewpoint.y + _NUDGE * cos, viewpoint.z
    return [
        cos, 0.0, -sin, 0.0,
        -sin, 0.0, -cos, 0.0,
        0.0, 1.0, 0.0, 0.0,
        -cos * x + sin * y, -z, sin * x + cos * y, 1.0,
    ]  # fmt: skip


@cache
def _projection_matrix(size: int) -> list[float]:
    """Return the matrix from eye to clip coordinates.

    It is shifted by half a pixel, as TinyRenderer samples a pixel at its lower left corner.
    """
    focal, shift = 1.0 / math.tan(math.radians(FIELD_OF_VIEW) / 2), 1.0 / size
    return [
        focal, 0.0, 0.0, 0.0,
        0.0, focal, 0.0, 0.0,
        shift, shift, -(FAR + NEAR) / (FAR - NEAR), -1.0,
        0.0, 0.0, -2.0 * FAR * NEAR / (FAR - NEAR), 0.0,
    ]  # fmt: skip
