"""Playbacks of watched episodes, replayed from the journal and cached; those still played grow with every look."""

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from threading import Lock
from typing import Protocol

from arramon_server.episodes.splits import Split
from arramon_server.playback.moments import Playback
from arramon_server.runs.play.worlds import Worlds
from arramon_server.runs.storage import causes
from arramon_server.sim.cameras import CAMERAS
from arramon_server.sim.footprints import Footprints
from arramon_server.sim.rules import Limits
from arramon_server.sim.section_world import EpisodeWorld
from arramon_server.web.watch.watched_runs import WatchedEpisode

CACHED_PLAYBACKS = 48
"""Number of cached playbacks, about 0.2 MB each."""

CACHED_SECTIONS = 8
"""Number of sections whose scenes and cameras are kept, about 12 MB each; then all are loaded anew."""


class ActionSource(Protocol):
    """Source of recorded actions, such as the journal."""

    def actions(self, run_id: str, episode_id: str, first: int = 0) -> Sequence[int]:
        """Return the actions of a run's episode from step `first` on."""
        ...


@dataclass(frozen=True, slots=True)
class OpenPlayback:
    """A playback with the world in which it takes place.

    Attributes:
        playback: the moments.
        world: draws them.
    """

    playback: Playback
    world: EpisodeWorld


class Playbacks:
    """Playbacks of watched episodes. Thread-safe.

    Args:
        source: source of the actions.
        splits: the splits served, by name.
        camera: camera of the server's runs, one of `cameras.CAMERAS`.
    """

    def __init__(self, source: ActionSource, splits: Mapping[str, Split], camera: str = CAMERAS[0]) -> None:
        self._source = source
        self._splits = splits
        self._camera = camera
        self._worlds = self._new_worlds()
        self._sections = set[tuple[str, str]]()
        self._kept = OrderedDict[tuple[str, str], tuple[OpenPlayback, bool]]()
        self._lock = Lock()

    @property
    def draws_in_threads(self) -> bool:
        """Whether several threads may draw at once."""
        return self._worlds.draws_in_threads

    def of(self, watched: WatchedEpisode, *, drawn: bool = False) -> OpenPlayback:
        """Return the playback of an episode, with all steps that are recorded by now.

        Args:
            watched: the episode.
            drawn: whether its world will be drawn, which is loaded for this.
        """
        with self._lock:
            found = self._updated(watched)
            if drawn:
                for _ in found.world.load(drawn=True):
                    pass
            return found

    def _updated(self, watched: WatchedEpisode) -> OpenPlayback:
        run, episode, ending = watched.run, watched.episode, watched.ending
        key = run.run_id, episode.episode_id
        opened, is_complete = self._kept.pop(key, (None, False))
        if opened is None:
            world = self._world(watched)
            opened = OpenPlayback(Playback(episode, world, Limits(run.steps_per_phase)), world)
        playback = opened.playback
        if not is_complete:
            if ending is None or ending.has_played:
                playback.extend(self._source.actions(run.run_id, episode.episode_id, playback.steps))
            if ending is not None and ending.cause == causes.TIME_LIMIT and not playback.is_finished:
                playback.end_at_time_limit()
        self._kept[key] = opened, not watched.is_live
        if len(self._kept) > CACHED_PLAYBACKS:
            self._kept.popitem(last=False)
        return opened

    def _world(self, watched: WatchedEpisode) -> EpisodeWorld:
        self._sections.add((watched.run.split, watched.episode.section))
        if len(self._sections) > CACHED_SECTIONS:
            self._worlds, self._sections = self._new_worlds(), {(watched.run.split, watched.episode.section)}
            self._kept.clear()
        return self._worlds.world(watched.run.split, watched.episode)

    def _new_worlds(self) -> Worlds:
        # Plane geometry answers as every other check, and holds nothing that must be closed.
        return Worlds(self._splits, self._camera, Footprints)
