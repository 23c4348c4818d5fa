"""Variations of a scene: the same meshes and textures with other bodies."""

from dataclasses import dataclass

from arramon_server.sim.scene import Body, Scene

CACHED = 512
"""Number of variations of a scene that a camera caches, about 20 KB each."""


@dataclass(frozen=True, eq=False)
class SceneDifference:
    """The difference between a scene and a variation of it.

    Attributes:
        absent: bodies of the scene that the variation does not have.
        further: bodies of the variation that the scene does not have.
    """

    absent: frozenset[Body]
    further: tuple[Body, ...]

    @classmethod
    def between(cls, scene: Scene, variation: Scene) -> "SceneDifference":
        """Return the difference; bodies that are the same object are in both."""
        there = set(scene.bodies)
        return cls(
            frozenset(there.difference(variation.bodies)),
            tuple(body for body in variation.bodies if body not in there),
        )


SAME = SceneDifference(frozenset(), ())
"""No difference."""
