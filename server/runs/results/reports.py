"""Reports of ended runs: scores, and the signature of the settings that produced them."""

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace

import numpy as np

from arramon.v1 import PROTOCOL
from arramon_server.episodes.splits import Split
from arramon_server.errors import Conflict
from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import RUNNING, EpisodeEnding, Run, RunProgress
from arramon_server.scoring.aggregate import ScoreTable, aggregate
from arramon_server.scoring.episode_scores import METRICS, EpisodeScores
from arramon_server.scoring.intervals import Floats
from arramon_server.scoring.masking import Noise, digest_without, masked_rows, two_digits
from arramon_server.scoring.signature import Signature, episodes_digest, format_argument


@dataclass(frozen=True, slots=True)
class Report:
    """Scores of a run that has ended.

    Attributes:
        run: the run.
        progress: counts of its episodes and steps.
        table: means and confidence intervals.
        signature: settings that produced the scores, in one line.
        endings: scores and cause of each episode; empty on a hidden split.
        voided: ids of its episodes that the host has voided: they are in no mean.
    """

    run: Run
    progress: RunProgress
    table: ScoreTable
    signature: str
    endings: tuple[EpisodeEnding, ...]
    voided: frozenset[str] = frozenset()


def split_as_played(run: Run, splits: Mapping[str, Split]) -> Split:
    """Return the split of a run.

    Raises:
        Conflict: if the split is gone, or its data has changed since the run was created.
    """
    split = splits.get(run.split)
    if split is None or split.data_hash != run.data_hash:
        found = "no longer exists" if split is None else f"now has the data {split.data_hash[:12]}"
        raise Conflict(
            f"run {run.run_id!r} began on split {run.split!r} with the data {run.data_hash[:12]}, which {found}"
        )
    return split


def report_of(run: Run, journal: Journal, splits: Mapping[str, Split], *, with_void: bool = False) -> Report:
    """Return the report of a run, from the endings in the journal.

    Args:
        run: the run.
        journal: its journal.
        splits: splits by name.
        with_void: whether episodes that the host has voided count.

    Raises:
        Conflict: if the run is still being played, the data of its split has changed since it was created, or all its
            episodes are void.
    """
    split = split_as_played(run, splits)
    progress = journal.progress(run.run_id)
    if run.state == RUNNING:
        done = f"{progress.ended} of {progress.episodes} episodes have ended"
        raise Conflict(f"run {run.run_id!r} is still being played: {done}")
    voided = frozenset[str]() if with_void else journal.voided(run.split)
    play_digest = journal.play_digest(run) if split.hidden else ""
    return make_report(run, progress, journal.endings(run.run_id), split, play_digest, voided)


def make_report(
    run: Run,
    progress: RunProgress,
    endings: Sequence[EpisodeEnding],
    split: Split,
    play_digest: str,
    voided: Set[str] = frozenset(),
    *,
    exact: bool = False,
) -> Report:
    """Return the report of a run with given endings. On a hidden split its scores are those of `masked_rows`.

    Args:
        run: run that has ended.
        progress: progress of the run.
        endings: endings of all its episodes.
        split: split that it was played on.
        play_digest: digest of how it was played, see `play_digest`; used on a hidden split alone.
        voided: ids of the split's episodes that are void.
        exact: whether the scores are exact on a hidden split too: for comparison with what an earlier release signed.

    Raises:
        Conflict: if all its episodes are void.
    """
    kept = without_void(run, endings, voided)
    mine = frozenset(ending.episode_id for ending in endings) & voided
    signature = Signature(
        version=run.server_version,
        protocol=PROTOCOL,
        split=run.split,
        language=run.language,
        episodes=progress.episodes - len(mine),
        steps_per_phase=run.steps_per_phase,
        clock=str(ClockSettings.of(run)),
        sensors=frozenset(run.sensors),
        images=frozenset(progress.images),
        data_hash=run.data_hash,
        arguments=frozenset(format_argument(name, value) for name, value in run.agent_arguments),
        chosen=_chosen(run, endings, split),
        void=episodes_digest(mine) if mine else "",
    )
    if split.hidden and not exact:
        name = digest_without(play_digest, mine)
        table = ScoreTable(masked_rows(score_array(kept), Noise(split.truth_hash), name), len(kept))
    else:
        table = aggregate([_scores(ending, split) for ending in kept])
    return Report(run, progress, table, str(signature), () if split.hidden else tuple(endings), mine)


def without_void(run: Run, endings: Sequence[EpisodeEnding], voided: Set[str]) -> list[EpisodeEnding]:
    """Return the endings of a run's episodes that are not void.

    Raises:
        Conflict: if all its episodes are void.
    """
    kept = [ending for ending in endings if ending.episode_id not in voided]
    if endings and not kept:
        raise Conflict(f"all {len(endings)} episodes of run {run.run_id!r} are void, so that it has no scores")
    return kept


def score_array(endings: Sequence[EpisodeEnding]) -> Floats:
    """Return the scores of both turns of each episode, (episodes, 2, METRICS), ordered by id."""
    ordered = sorted(endings, key=lambda ending: ending.episode_id)
    return np.array([[[turn[name] for name in METRICS] for turn in ending.scores] for ending in ordered])


def coarse_progress(progress: RunProgress) -> RunProgress:
    """Return a run's progress on a hidden split as others see it: steps and times to two significant digits.

    From the exact number of steps, an attacker who knows those of all other episodes could infer one episode's steps,
    and so the distance of its target.
    """
    seconds = progress.seconds_a_step
    timed = int(two_digits(progress.timed_steps))
    return replace(
        progress,
        steps=int(two_digits(progress.steps)),
        timed_steps=timed,
        thinking_seconds=0.0 if seconds is None else two_digits(two_digits(seconds) * timed),
    )


def _chosen(run: Run, endings: Sequence[EpisodeEnding], split: Split) -> str:
    """Return "" if the episodes are the first of the split in playing order, otherwise a hash of their ids."""
    played = {ending.episode_id for ending in endings}
    if played == {episode.episode_id for episode in split.in_playing_order(run.language)[: len(endings)]}:
        return ""
    return episodes_digest(played)


def _scores(ending: EpisodeEnding, split: Split) -> EpisodeScores:
    first, second = ending.scores
    return EpisodeScores(ending.episode_id, split.episodes[ending.episode_id].section, (first, second))
