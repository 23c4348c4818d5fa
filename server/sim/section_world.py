"""A section of the city loaded for play, and the section in one episode: what stands there, is in the way, is drawn."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import cached_property

from arramon_server.sim.cameras import CAMERAS, Camera, Frame
from arramon_server.sim.city import city_scene, refurnished
from arramon_server.sim.loaded_scene import LoadedScene
from arramon_server.sim.own_furniture import OwnFurniture, furnished
from arramon_server.sim.physics import Physics, physics_of
from arramon_server.sim.room_scene import room_scene
from arramon_server.sim.rules import EpisodeLayout, State
from arramon_server.sim.scene import Scene, SceneDifference
from arramon_server.sim.section import Prop, Section
from arramon_server.sim.view import view


class SectionWorld(LoadedScene):
    """A section as its episodes share it.

    Args:
        section: its geometry and furniture.
        room: the assembly room; None to load it again.
        spare: returns the props that its episodes add; their looks alone matter.
        camera, physics: as of `LoadedScene`.
    """

    def __init__(
        self,
        section: Section,
        room: LoadedScene | None = None,
        spare: Callable[[], Iterable[Prop]] = tuple,
        camera: str = CAMERAS[0],
        physics: Callable[[Scene], Physics] = physics_of,
    ) -> None:
        super().__init__(lambda: city_scene(section, spare()), camera, physics)
        self.section = section
        self.room = room or LoadedScene(room_scene, camera, physics)

    def in_episode(self, furniture: OwnFurniture, layout: EpisodeLayout) -> "EpisodeWorld":
        """Return the section as it is in an episode with this furniture and layout."""
        return EpisodeWorld(self, furniture, layout)


class EpisodeWorld:
    """A section in one episode: its scene, collision check (`rules.CollisionCheck`) and frames.

    It shares everything with its section but the bodies of the episode's own furniture.

    Args:
        section: the section.
        furniture: the episode's differences from the section's furniture.
        layout: the episode's start and objects.
    """

    def __init__(self, section: SectionWorld, furniture: OwnFurniture, layout: EpisodeLayout) -> None:
        self._section, self._room, self._layout = section, section.room, layout
        self.scene = section.scene
        difference = SceneDifference()
        if not furniture.is_empty:
            self.scene = refurnished(section.scene, furnished(section.section, furniture))
            difference = SceneDifference.between(section.scene, self.scene)
        self._removed = difference.removed
        self._added = tuple(body for body in difference.added if body.collider is not None)

    def load(self, *, drawn: bool) -> Iterator[object]:
        """Build and yield the remaining parts one by one, so that the caller can do other work in between.

        Args:
            drawn: whether frames will be rendered. After the last part, `render` only draws, and several threads may
                call it at once if the camera is thread-safe.
        """
        yield self._section.physics
        if drawn:
            yield self._section.camera
            yield self._section.label_numbers, self._street
            yield self._room.label_numbers

    def way_is_free(self, start: tuple[float, float], end: tuple[float, float]) -> bool:
        """Return whether the agent can move straight from one (x, z) to another."""
        return self._section.physics.way_is_free(start, end, self._removed, self._added)

    def render(self, state: State, size: int, *, segmentation: bool = False, into: Frame | None = None) -> Frame:
        """Draw the agent's view in a state of the episode.

        Args:
            state: the state.
            size: side length of the images, in pixels.
            segmentation: whether to label each pixel with its index in `arramon_server.sim.labels.LABELS`.
            into: arrays to draw into, as for `cameras.Camera.render`, but for the segmentation, which is always new.
        """
        seen = view(state, self._layout)
        camera, place = (self._room.camera, self._room) if seen.indoors else (self._street, self._section)
        frame = camera.render(seen.viewpoint, seen.actors, size, segmentation=segmentation, into=into)
        if frame.segmentation is None:
            return frame
        return replace(frame, segmentation=place.label_numbers[frame.segmentation])

    @cached_property
    def _street(self) -> Camera:
        """The camera of the streets."""
        return self._section.camera if self.scene is self._section.scene else self._section.camera.showing(self.scene)
