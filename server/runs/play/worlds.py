"""The worlds of episodes. Sections are loaded once, and shared by their episodes."""

from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping

from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split
from arramon_server.sim.cameras import CAMERAS
from arramon_server.sim.loaded_scene import LoadedScene
from arramon_server.sim.physics import Physics, physics_of
from arramon_server.sim.room_scene import room_scene
from arramon_server.sim.scene import Scene
from arramon_server.sim.section import Prop, Section
from arramon_server.sim.section_world import EpisodeWorld, SectionWorld

CACHED = 512
"""Number of cached worlds of episodes with furniture of their own, about 20 KB each."""

Key = tuple[str, str]
"""Split and section id of a section; equal sections share the first key."""


class Worlds:
    """Loads the worlds of episodes; equal sections are loaded once, also if they are in several splits.

    Not thread-safe; for threads that render a loaded world see `EpisodeWorld.load` and `draws_in_threads`.

    Args:
        splits: splits by name.
        camera: one of `cameras.CAMERAS`; the one that needs pybullet checks collisions, too.
        physics: makes the collision checks of a scene. All kinds give equal answers (`rules.CollisionCheck`).
    """

    def __init__(
        self,
        splits: Mapping[str, Split],
        camera: str = CAMERAS[0],
        physics: Callable[[Scene], Physics] = physics_of,
    ) -> None:
        self._splits = splits
        self._camera = camera
        self._physics = physics
        self._first: dict[Section, Key] = {}
        """By section, the first split and section that is equal to it."""
        self._shared_keys = {
            (split.name, id_): self._first.setdefault(section, (split.name, id_))
            for split in splits.values()
            for id_, section in split.sections.items()
        }
        """By split and section, the first split and section that is equal to it."""
        self._room = LoadedScene(room_scene, camera, physics)
        self._sections: dict[Key, SectionWorld] = {}
        self._recent: OrderedDict[tuple[str, str], tuple[Episode, EpisodeWorld]] = OrderedDict()
        """The latest worlds with furniture of their own, by split and episode id, each with its episode."""

    @property
    def draws_in_threads(self) -> bool:
        """Whether several threads may draw at once."""
        return self._camera == "raster"

    def world(self, split: str, episode: Episode) -> EpisodeWorld:
        """Return the world of an episode. Its parts that are not loaded yet are built on first use.

        Worlds with furniture of their own are cached; the others consist of parts of their section.
        """
        section = self._section(split, episode.section)
        if episode.furniture.is_empty:
            return section.in_episode(episode.furniture, episode.layout)
        key = split, episode.episode_id
        found = self._recent.get(key)
        if found is not None and found[0] is episode:
            return found[1]
        world = section.in_episode(episode.furniture, episode.layout)
        self._recent[key] = episode, world
        if len(self._recent) > CACHED:
            self._recent.popitem(last=False)
        return world

    def load(self, split: str, episode: Episode, *, drawn: bool) -> Iterator[object]:
        """Load what an episode needs part by part, and yield each, so that the caller can do other work in between.

        Args:
            split: name of the episode's split.
            episode: the episode.
            drawn: whether frames will be rendered. Then `EpisodeWorld.render` only draws afterwards.
        """
        yield self._section(split, episode.section).scene
        yield from self.world(split, episode).load(drawn=drawn)

    def close(self) -> None:
        """Free all worlds."""
        for loaded in (self._room, *self._sections.values()):
            loaded.close()
        self._sections.clear()
        self._recent.clear()

    def _section(self, split: str, section: str) -> SectionWorld:
        key = self._shared_key(split, section)
        if key not in self._sections:
            self._sections[key] = SectionWorld(
                self._splits[key[0]].sections[key[1]],
                self._room,
                lambda: self._furniture_looks(key),
                self._camera,
                self._physics,
            )
        return self._sections[key]

    def _shared_key(self, split: str, section: str) -> Key:
        """Return the key of a section. One of a split that is not listed shares that of an equal section, if any."""
        key = self._shared_keys.get((split, section))
        if key is None:
            equal = self._splits[split].sections[section]
            key = self._shared_keys[split, section] = self._first.setdefault(equal, (split, section))
        return key

    def _furniture_looks(self, key: Key) -> list[Prop]:
        """Return one prop for each look of the episodes' own furniture in a section, over all splits that have it."""
        looks: dict[tuple[str, str, str, str], Prop] = {}
        for split in self._splits.values():
            for episode in split.episodes.values():
                if episode.furniture.added and self._shared_keys[split.name, episode.section] == key:
                    for prop in episode.furniture.added:
                        looks.setdefault((prop.kind, prop.colour, prop.shape, prop.shape_colour), prop)
        return [looks[look] for look in sorted(looks)]
