"""The paths of single episodes, for the pages of open splits alone: played again from the journal."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from server.board.standings import Entry
from server.episodes.episode import Episode
from server.episodes.splits import Split
from server.errors import NotFound
from server.runs import causes
from server.runs.journal import Journal
from server.runs.records import Ending, Run
from server.runs.session import Session
from server.sim.bullet import Obstacles
from server.sim.city import city_scene
from server.sim.rules import Limits
from server.sim.section import Section
from server.web import mapping

EXAMPLES = 8
"""Episodes that a run's page links to."""

_KEPT = 256
"""Drawn episodes that are kept in memory, about 5 KB each."""


@dataclass(frozen=True, slots=True)
class Played:
    """One episode of a run, as its page shows it.

    Attributes:
        tracks: of both turns.
    """

    episode: Episode
    ending: Ending
    ground: mapping.Ground
    tracks: tuple[mapping.Track, ...]


class Paths:
    """Draws the episodes of published runs. Safe to use from several threads, but for `played`, which belongs to one.

    Args:
        splits: what is served, by name.
        journal: has the actions.
    """

    def __init__(self, splits: Mapping[str, Split], journal: Journal) -> None:
        self._splits = splits
        self._journal = journal
        self._last: tuple[Section, Obstacles] | None = None
        self._drawn = lru_cache(_KEPT)(self._draw)
        self.endings = lru_cache(16)(self._endings)

    def close(self) -> None:
        """Gives memory back; what is drawn after that takes it again."""
        if self._last is not None:
            self._last[1].close()
            self._last = None

    def split(self, entry: Entry) -> Split | None:
        """The split of a run whose episodes may be shown; None where it is hidden, or its data is not what it was."""
        split = self._splits.get(entry.run.split)
        if split is None or split.hidden or split.data_hash != entry.run.data_hash:
            return None
        return split

    def examples(self, entry: Entry) -> list[tuple[str, float]]:
        """A few episodes of a run and their nDTW, evenly from the highest to the lowest; none of a hidden split."""
        if self.split(entry) is None:
            return []
        ordered = sorted(((_similarity(one), one.episode_id) for one in self.endings(entry.run.run_id)), reverse=True)
        last = len(ordered) - 1
        places = range(last + 1) if last < EXAMPLES else [round(last * n / (EXAMPLES - 1)) for n in range(EXAMPLES)]
        return [(ordered[place][1], ordered[place][0]) for place in places]

    def played(self, entry: Entry, episode_id: str) -> Played:
        """One episode of a run.

        Raises:
            NotFound: if the run has none of that id, or the split's episodes are not to be shown.
        """
        split = self.split(entry)
        ending = {one.episode_id: one for one in self.endings(entry.run.run_id)}.get(episode_id) if split else None
        if split is None or ending is None:
            raise NotFound(f"run {entry.run.run_id!r} has no episode {episode_id!r} to show")
        episode = split.episodes[episode_id]
        ground = mapping.ground(split.sections[episode.section])
        tracks = self._drawn(entry.run, episode_id, ending.cause if ending.has_played else "")
        return Played(episode, ending, ground, tracks)

    def _endings(self, run_id: str) -> list[Ending]:
        return self._journal.endings(run_id)

    def _draw(self, run: Run, episode_id: str, cause: str) -> tuple[mapping.Track, ...]:
        """The tracks of what was played and ended by a cause; an empty one where nothing of it counts."""
        split = self._splits[run.split]
        episode = split.episodes[episode_id]
        section = split.sections[episode.section]
        session = Session(episode, self._ground(section), Limits(run.steps_per_phase))
        for _ in session.replay(self._journal.actions(run.run_id, episode_id) if cause else ()):
            pass
        if cause == causes.TIME_LIMIT and not session.state.finished:
            session.run_out()
        return tuple(mapping.track(section, turn) for turn in session.record().turns)

    def _ground(self, section: Section) -> Obstacles:
        """What stands in the way in a section; kept until another is asked for, as readers go on in the same one."""
        if self._last is None or self._last[0] is not section:
            self.close()
            self._last = section, Obstacles(city_scene(section))
        return self._last[1]


def _similarity(ending: Ending) -> float:
    """The mean of both turns' nDTW."""
    return sum(turn["nDTW"] for turn in ending.scores) / len(ending.scores)
