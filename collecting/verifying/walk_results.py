"""Results of verifications: the scores of their runs, with ways and cells, which are replayed from the journal."""

from collections.abc import Mapping
from dataclasses import dataclass
from threading import Lock

from arramon_collecting.rules.agreement import Path, PlacedCell, simplified
from arramon_server.episodes.splits import Split
from arramon_server.errors import Conflict
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.worlds import Worlds
from arramon_server.runs.results.reports import split_as_played
from arramon_server.runs.storage.causes import SERVER_FAULT, TIME_LIMIT
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import Run
from arramon_server.sim.footprints import Footprints
from arramon_server.sim.rules import Limits


@dataclass(frozen=True, slots=True)
class WalkResult:
    """The result of one verification.

    Attributes:
        ndtw, ptc: scores of turn 1 and turn 2, as recorded when the episode ended.
        paths: ways of turn 1 and turn 2, in units; an empty one was not begun.
        cells: cells in which the objects were placed.
        cause: cause of the episode's end, one of `runs.storage.causes`.
        seconds: time from the creation of the run to the end of its episode.
    """

    ndtw: tuple[float, ...]
    ptc: tuple[float, ...]
    paths: tuple[Path, Path]
    cells: tuple[PlacedCell, PlacedCell]
    cause: str
    seconds: float

    @property
    def is_void(self) -> bool:
        """Whether a fault of the server ended the episode."""
        return self.cause == SERVER_FAULT


class WalkResults:
    """Reads the results of runs on texts. Thread-safe.

    Args:
        splits: all splits by name, those of texts included.
        journal: journal of the runs.
    """

    def __init__(self, splits: Mapping[str, Split], journal: Journal) -> None:
        self._splits = splits
        self._journal = journal
        # Plane geometry answers as every other check, and holds nothing that must be closed.
        self._worlds = Worlds(splits, physics=Footprints)
        self._lock = Lock()

    def of(self, run: Run) -> WalkResult:
        """Return the result of a run of one episode.

        Raises:
            Conflict: if the episode has not ended, or its text has changed since.
        """
        split = split_as_played(run, self._splits)
        endings = self._journal.endings(run.run_id)
        if run.ended_at is None or len(endings) != 1:
            raise Conflict("the episode has not ended yet")
        (ending,) = endings
        episode = split.episodes[ending.episode_id]
        with self._lock:
            session = EpisodeSession(episode, self._worlds.world(split.name, episode), Limits(run.steps_per_phase))
            for _ in session.replay(self._journal.actions(run.run_id, ending.episode_id) if ending.has_played else ()):
                pass
        if ending.cause == TIME_LIMIT and not session.state.finished:
            session.end_at_time_limit()
        first, second = session.record().turns
        return WalkResult(
            tuple(turn["nDTW"] for turn in ending.scores),
            tuple(turn["PTC"] for turn in ending.scores),
            (simplified(first.path), simplified(second.path)),
            (first.placed_cell, second.placed_cell),
            ending.cause,
            (run.ended_at - run.created_at).total_seconds(),
        )
