"""The worlds that runs take place in: one per section, shared by its episodes, and one room; made when first needed."""

from collections.abc import Mapping

from server.episodes.episode import Episode
from server.episodes.splits import Split
from server.sim.bullet import World
from server.sim.cameras import Frame
from server.sim.city import city_scene
from server.sim.room_scene import room_scene
from server.sim.rules import Ground, State
from server.sim.scene import Scene
from server.sim.view import view


class Worlds:
    """Scenes and pybullet worlds by split and section. To be used from one thread."""

    def __init__(self, splits: Mapping[str, Split]) -> None:
        self._splits = splits
        self._scenes: dict[tuple[str, str], Scene] = {}
        self._cities: dict[tuple[str, str], World] = {}
        self._room: World | None = None

    def scene(self, split: str, section: str) -> Scene:
        """The scene of a section."""
        key = (split, section)
        if key not in self._scenes:
            self._scenes[key] = city_scene(self._splits[split].sections[section])
        return self._scenes[key]

    def ground(self, split: str, section: str) -> Ground:
        """What answers the rules' question in a section."""
        return self._city(split, section)

    def render(self, split: str, episode: Episode, state: State, size: int) -> Frame:
        """What the agent sees in a state of an episode, `size` x `size` pixels."""
        seen = view(state, episode.layout)
        if not seen.indoors:
            return self._city(split, episode.section).render(seen.viewpoint, seen.actors, size)
        if self._room is None:
            self._room = World(room_scene())
        return self._room.render(seen.viewpoint, seen.actors, size)

    def close(self) -> None:
        """Lets all worlds go."""
        for world in (*self._cities.values(), self._room):
            if world is not None:
                world.close()
        self._cities.clear()
        self._room = None

    def _city(self, split: str, section: str) -> World:
        key = (split, section)
        if key not in self._cities:
            self._cities[key] = World(self.scene(split, section))
        return self._cities[key]
