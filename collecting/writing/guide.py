"""The guide that only writers see: the blue line with its balls and the arrow above the target, as bodies of a scene.

The bodies have no collider. The paper's writers had both (appendix "Interface"). Agents never see them: they are in no
scene but the writers'.
"""

import math
from dataclasses import replace
from functools import cache
from itertools import pairwise
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from arramon_client.world import bearing
from arramon_server.episodes.episode import Turn
from arramon_server.sim.assets.meshes import ball, box, lathe, merge
from arramon_server.sim.cameras import NOTHING
from arramon_server.sim.scene import Body, Mesh, Scene

BALL_RADIUS, BALL_HEIGHT = 0.07, 0.12
"""Radius of the line's balls, and height of their centres, in units: below the writer's eyes, above the road."""

LINE_WIDTH = 0.05

ARROW_TIP, ARROW_LENGTH = 0.75, 0.7
"""Height of the arrow's tip, above every object in the street, and its length, in units."""

BLUE, RED = (20, 90, 255), (230, 40, 30)

_BALL, _LINE, _ARROW = "guide/ball", "guide/line", "guide/arrow"


def with_guide(scene: Scene) -> Scene:
    """Return the scene with the guide's looks, of which no body stands there yet: a camera of it can show the guide."""
    spare = tuple(_body(name, name, (0.0, 0.0, 0.0)) for name in (_BALL, _LINE, _ARROW))
    return replace(
        scene,
        meshes=MappingProxyType({**scene.meshes, **_meshes()}),
        textures=MappingProxyType({**scene.textures, **_textures()}),
        spare=(*scene.spare, *spare),
    )


def guide_of(turn: Turn) -> tuple[Body, ...]:
    """Return the guide of a turn: its line, and the arrow above its target."""
    balls = [_body(f"{_BALL}/{i}", _BALL, (x, z, 0.0)) for i, (x, z) in enumerate(turn.path)]
    pieces = [
        _body(
            f"{_LINE}/{i}",
            _LINE,
            ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2, 0.0),
            heading=bearing(start, end),
            scale=math.dist(start, end),
        )
        for i, (start, end) in enumerate(pairwise(turn.path))
    ]
    goal = turn.target.position
    return (*balls, *pieces, _body(_ARROW, _ARROW, (goal.x, goal.z, 0.0)))


def _body(
    name: str, look: str, position: tuple[float, float, float], *, heading: float = 0.0, scale: float = 1.0
) -> Body:
    return Body(name, look, look, position, heading, scale, label=NOTHING)


@cache
def _meshes() -> dict[str, Mesh]:
    middle = ARROW_TIP + 0.55 * ARROW_LENGTH
    head = lathe([(0.0, ARROW_TIP), (0.22, middle), (0.0, middle)], sides=12)
    shaft = lathe([(0.0, middle), (0.08, middle), (0.08, ARROW_TIP + ARROW_LENGTH), (0.0, ARROW_TIP + ARROW_LENGTH)], 8)
    return {
        _BALL: ball(BALL_RADIUS, BALL_HEIGHT, sides=10, rings=6),
        _LINE: box(LINE_WIDTH, 1.0, 0.02, base=BALL_HEIGHT - 0.01),
        _ARROW: merge(head, shaft),
    }


@cache
def _textures() -> dict[str, npt.NDArray[np.uint8]]:
    colours = {_BALL: BLUE, _LINE: BLUE, _ARROW: RED}
    return {name: np.tile(np.array(colour, np.uint8), (4, 4, 1)) for name, colour in colours.items()}
