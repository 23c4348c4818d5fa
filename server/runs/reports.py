"""The report of a run that is over: its scores, and what they were reached under."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from arramon.v1 import PROTOCOL
from server.episodes.splits import Split
from server.errors import Conflict
from server.runs.clocks import Clocks
from server.runs.journal import Journal
from server.runs.records import RUNNING, Ending, Progress, Run
from server.scoring.aggregate import ScoreTable, aggregate
from server.scoring.episode import EpisodeScores
from server.scoring.signature import Signature


@dataclass(frozen=True, slots=True)
class Report:
    """The scores of a run that is over.

    Attributes:
        table: means and intervals.
        signature: what the scores were reached under, in one line.
        endings: each episode's own scores and cause; empty on a hidden split.
    """

    run: Run
    progress: Progress
    table: ScoreTable
    signature: str
    endings: tuple[Ending, ...]


def split_of(run: Run, splits: Mapping[str, Split]) -> Split:
    """The split that a run is played on.

    Raises:
        Conflict: if its data is not what the run began with.
    """
    split = splits.get(run.split)
    if split is None or split.data_hash != run.data_hash:
        found = "is gone" if split is None else f"now has the data {split.data_hash[:12]}"
        raise Conflict(
            f"run {run.run_id!r} began on split {run.split!r} with the data {run.data_hash[:12]}, which {found}"
        )
    return split


def report_of(run: Run, journal: Journal, splits: Mapping[str, Split]) -> Report:
    """The report of a run, from what the journal holds.

    Raises:
        Conflict: while it is being played, or if its split's data is not what the run began with.
    """
    split = split_of(run, splits)
    progress = journal.progress(run.run_id)
    if run.state == RUNNING:
        done = f"{progress.ended} of {progress.episodes} episodes have ended"
        raise Conflict(f"run {run.run_id!r} is still being played: {done}")
    return make_report(run, progress, journal.endings(run.run_id), split)


def make_report(run: Run, progress: Progress, endings: Sequence[Ending], split: Split) -> Report:
    """The report of a run whose episodes ended so.

    Args:
        run: that is over.
        progress: of it.
        endings: of all its episodes.
        split: that it was played on.
    """
    signature = Signature(
        version=run.server_version,
        protocol=PROTOCOL,
        split=run.split,
        language=run.language,
        episodes=progress.episodes,
        steps_per_phase=run.steps_per_phase,
        clock=str(Clocks.of(run)),
        sensors=frozenset(run.sensors),
        images=frozenset(progress.images),
        data_hash=run.data_hash,
    )
    table = aggregate([_scores(ending, split) for ending in endings])
    return Report(run, progress, table, str(signature), () if split.hidden else tuple(endings))


def _scores(ending: Ending, split: Split) -> EpisodeScores:
    first, second = ending.scores
    return EpisodeScores(ending.episode_id, split.episodes[ending.episode_id].section, (first, second))
