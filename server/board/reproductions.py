"""Reproductions: runs that repeat another account's published run, and the differences between their scores."""

from collections.abc import Mapping
from dataclasses import dataclass

from arramon_server.board.entries import PublishedRun
from arramon_server.board.episode_table import EpisodeTable, join_languages
from arramon_server.board.standings import COLUMNS, TOTAL, Entry
from arramon_server.errors import Conflict
from arramon_server.runs.storage.records import COMPLETE, Run
from arramon_server.scoring.aggregate import Interval
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.scoring.masking import shown_deviation, shown_difference
from arramon_server.scoring.paired import difference_bounds

IGNORED_FIELDS = frozenset({"version"})
"""Fields of a signature that may differ between a run and its reproduction."""


@dataclass(frozen=True, slots=True)
class Reproduction:
    """A published reproduction of a run.

    Attributes:
        entry: the reproduction.
        differences: metric of COLUMNS -> mean over both turns minus the original's, with its 95% interval.
    """

    entry: Entry
    differences: Mapping[str, Interval]


def check_reproduction(
    run: Run, signature: str, original: PublishedRun, original_signature: str, *, is_original: bool
) -> None:
    """Check that a run repeats a published run of another account.

    Args:
        run: the reproduction, which has ended.
        signature: its signature, a line with its settings.
        original: the run that it repeats.
        original_signature: the original's signature.
        is_original: whether the reproduction itself has published reproductions.

    Raises:
        Conflict: if one of the two has no account, or both have the same one; if the run was not played to its end; if
            agent, code or settings differ, or the original names no code; or if the original is a reproduction itself,
            or the reproduction an original.
    """
    found, name = original.run, f"run {original.run.run_id!r}"
    if run.account is None or found.account is None:
        whose = f"run {run.run_id!r}" if run.account is None else name
        raise Conflict(
            f"{whose} was played without an account, so it is not known to be another participant's; "
            "a reproduction needs an account for both runs"
        )
    if run.account == found.account:
        raise Conflict(f"{name} is of the same account: a reproduction is published by another participant")
    if original.reproduces:
        raise Conflict(f"{name} reproduces run {original.reproduces!r}; name that one instead")
    if is_original:
        raise Conflict(f"run {run.run_id!r} is itself reproduced by others, and cannot become a reproduction")
    if run.state != COMPLETE:
        raise Conflict(f"run {run.run_id!r} was cancelled; a reproduction is played to its end")
    if run.agent != found.agent:
        raise Conflict(f"run {run.run_id!r} is of the agent {run.agent!r}, but {name} of {found.agent!r}")
    if not found.code:
        raise Conflict(f"{name} names no code, so it cannot be known to be of the same agent")
    if not run.code.is_same_code(found.code):
        raise Conflict(
            f"run {run.run_id!r} names {_code(run)}, but {name} {_code(found)}; expected the same commit or image or, "
            "where the original names neither, the same address"
        )
    ours, theirs = _fields(signature), _fields(original_signature)
    different = [key for key in (*theirs, *(ours.keys() - theirs.keys())) if ours.get(key) != theirs.get(key)]
    if different:
        raise Conflict(
            f"run {run.run_id!r} was not played like {name}: "
            + "; ".join(f"{key} is {ours.get(key, 'none')}, expected {theirs.get(key, 'none')}" for key in different)
        )


def score_differences(
    original: EpisodeTable, table: EpisodeTable, section_of: Mapping[str, str]
) -> dict[str, Interval]:
    """Return the mean differences of a reproduction minus its original over both turns, by metric of COLUMNS.

    Args:
        original: scores of the original.
        table: scores of the reproduction in the same episodes.
        section_of: section of every episode, by id; episodes missing here count as one section.
    """
    sections = {name: section_of.get(name, "") for name in original.ids}
    before, after = join_languages([original], sections), join_languages([table], sections)
    change = after.values[:, -1] - before.values[:, -1]
    return {metric: Interval(*difference_bounds(change[:, METRICS.index(metric)], before.strata)) for metric in COLUMNS}


def masked_score_differences(original: Entry, reproduction: Entry) -> dict[str, Interval]:
    """Return `score_differences` on a hidden split, computed from the shown means alone."""
    episodes = min(original.counted, reproduction.counted)
    noise = 2.0**0.5 * shown_deviation(episodes)
    before, after = original.rows[TOTAL], reproduction.rows[TOTAL]
    return {metric: shown_difference(after[metric].mean, before[metric].mean, episodes, noise) for metric in COLUMNS}


def _fields(signature: str) -> dict[str, str]:
    pairs = (part.partition(":") for part in signature.split("|"))
    return {key: value for key, _, value in pairs if key not in IGNORED_FIELDS}


def _code(run: Run) -> str:
    return ", ".join(f"{name} {value}" for name, value in run.code.named().items()) or "no code"
