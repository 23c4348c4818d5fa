"""Replays single episodes of open splits from the journal, and draws their paths for the pages."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from arramon_server.board.standings import Entry, ScoresVersion
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split
from arramon_server.errors import NotFound, quoted
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import EpisodeEnding, Run
from arramon_server.sim.own_furniture import furnished
from arramon_server.sim.rules import Limits
from arramon_server.sim.section import Section
from arramon_server.sim.section_world import EpisodeWorld, SectionWorld
from arramon_server.web import room_map, section_map

EXAMPLES = 8
"""Number of episodes that a run's page links to."""

_CACHE_SIZE = 256
"""Size of the cache of drawn episodes, about 5 KB each."""


@dataclass(frozen=True, slots=True)
class PlayedEpisode:
    """A played episode of a run, as drawn on its page.

    Attributes:
        episode: the episode.
        ending: how it ended.
        ground: map of its section.
        tracks: paths of both turns.
        room_maps: assembly maps of both turns.
        section: its section, including the episode's own furniture.
    """

    episode: Episode
    ending: EpisodeEnding
    ground: section_map.SectionMap
    tracks: tuple[section_map.TurnPaths, ...]
    room_maps: tuple[room_map.AssemblyMap, ...]
    section: Section


class EpisodeReplays:
    """Replays and draws the episodes of published runs. Thread-safe, except for `played` and `draw`.

    Args:
        splits: the splits served, by name.
        journal: source of the actions.
    """

    def __init__(self, splits: Mapping[str, Split], journal: Journal) -> None:
        self._splits = splits
        self._journal = journal
        self._last: SectionWorld | None = None
        self._cached_tracks = lru_cache(_CACHE_SIZE)(self._tracks)
        self._cached_endings = lru_cache(16)(self._read_endings)
        self.play_digest_of = journal.play_digest

    def close(self) -> None:
        """Free the memory of the last section's physics. `played` may still be called afterwards."""
        if self._last is not None:
            self._last.close()
            self._last = None

    def split(self, entry: Entry) -> Split | None:
        """Return the split of a run, if its episodes may be shown.

        None if the split is not served, is hidden or frozen, or its data has changed since the run.
        """
        split = self._splits.get(entry.run.split)
        if entry.frozen or split is None or split.hidden or split.data_hash != entry.run.data_hash:
            return None
        return split

    def endings(self, entry: Entry) -> list[EpisodeEnding]:
        """Return the endings of a run's episodes, in playing order."""
        return self._cached_endings(entry.version)

    def examples(self, entry: Entry) -> list[tuple[str, float]]:
        """Return up to `EXAMPLES` ids with nDTW, evenly spaced from the highest to the lowest; none if hidden."""
        if self.split(entry) is None:
            return []
        ordered = sorted(((_similarity(one), one.episode_id) for one in self.endings(entry)), reverse=True)
        last = len(ordered) - 1
        places = range(last + 1) if last < EXAMPLES else [round(last * n / (EXAMPLES - 1)) for n in range(EXAMPLES)]
        return [(ordered[place][1], ordered[place][0]) for place in places]

    def played(self, entry: Entry, episode_id: str) -> PlayedEpisode:
        """Return one episode of a run.

        Raises:
            NotFound: if the run has no episode of that id, or the split's episodes may not be shown.
        """
        split = self.split(entry)
        ending = {one.episode_id: one for one in self.endings(entry)}.get(episode_id) if split else None
        if split is None or ending is None:
            raise NotFound(f"run {entry.run.run_id!r} has no episode {quoted(episode_id)} to show")
        return self.draw(entry.run, ending)

    def draw(self, run: Run, ending: EpisodeEnding) -> PlayedEpisode:
        """Return an ended episode of a run, whose split must be served and not hidden. Only one thread may call it."""
        split, episode_id = self._splits[run.split], ending.episode_id
        episode = split.episodes[episode_id]
        section, provenance = split.sections[episode.section], split.provenance.get(episode.section)
        origins = () if provenance is None else provenance.origins(section, episode)
        furnished_section = furnished(section, episode.furniture)
        ground = section_map.draw_section(furnished_section, origins)
        tracks, room_maps = self._cached_tracks(run, episode_id, ending.cause if ending.has_played else "")
        return PlayedEpisode(episode, ending, ground, tracks, room_maps, furnished_section)

    def _read_endings(self, version: ScoresVersion) -> list[EpisodeEnding]:
        return self._journal.endings(version.run_id)

    def _tracks(
        self, run: Run, episode_id: str, cause: str
    ) -> tuple[tuple[section_map.TurnPaths, ...], tuple[room_map.AssemblyMap, ...]]:
        """Return the paths and room maps of an episode that ended by `cause`; unplayed ones if `cause` is empty."""
        split = self._splits[run.split]
        episode = split.episodes[episode_id]
        section = split.sections[episode.section]
        session = EpisodeSession(episode, self._world(section, episode), Limits(run.steps_per_phase))
        replay = room_map.AssemblyReplay(session)
        replay.replay(self._journal.actions(run.run_id, episode_id) if cause else ())
        if cause == causes.TIME_LIMIT and not session.state.finished:
            session.end_at_time_limit()
        return tuple(section_map.turn_paths(section, turn) for turn in session.record().turns), replay.maps()

    def _world(self, section: Section, episode: Episode) -> EpisodeWorld:
        """Return the world of an episode. The latest section is cached, as readers tend to stay in one."""
        if self._last is None or self._last.section is not section:
            self.close()
            self._last = SectionWorld(section)
        return self._last.in_episode(episode.furniture, episode.layout)


def _similarity(ending: EpisodeEnding) -> float:
    """Return the mean nDTW over both turns."""
    return sum(turn["nDTW"] for turn in ending.scores) / len(ending.scores)
