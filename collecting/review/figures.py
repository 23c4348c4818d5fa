"""Figures of a collection and of its workers, computed from its rows. Pure."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from statistics import fmean, median

from arramon_collecting.rules.agreement import Agreement, Walk, agreement_of, agreement_with_others
from arramon_collecting.rules.keeping import Outcome, succeeded
from arramon_collecting.settings import Settings
from arramon_collecting.storage.payments.records import LedgerEntry
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import REVIEW_KIND
from arramon_collecting.storage.texts.records import DISCARDED, KEPT, REJECTED, Text, Verification
from arramon_collecting.storage.work.records import RETURNED, SUBMITTED, Task


@dataclass(frozen=True, slots=True)
class Overview:
    """Figures of a collection; None where there is nothing to compute them of.

    Attributes:
        texts: number of texts by state.
        tasks: number of tasks by stage and state.
        by_day: number of submitted tasks by day, oldest first.
        median_seconds: median active time of submitted tasks, by stage.
        kept_ndtw: mean nDTW of the verifications of kept texts, both turns (the paper's is 0.66).
        success: share of verifications that followed their text.
        gold_success: the same of golds.
        agreement: mean agreement of the verifiers of a text.
        paid: amounts owed by kind, in the currency's smallest unit.
    """

    texts: Mapping[str, int]
    tasks: Mapping[tuple[str, str], int]
    by_day: Mapping[date, int]
    median_seconds: Mapping[str, float]
    kept_ndtw: float | None
    success: float | None
    gold_success: float | None
    agreement: Agreement
    paid: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class WorkerFigures:
    """Figures of one worker; None where there is nothing to compute them of.

    Attributes:
        worker: the worker.
        texts: number of the worker's texts by state.
        verifications: number of verifications of texts.
        uncounted: number of those that do not count.
        success: share of the counted ones that followed the text.
        golds, golds_passed: number of known episodes, and of those that were followed.
        agreement: agreement with the other verifiers of the same texts.
        flag_rate: share of verifications with a flag.
        median_seconds: median active time of submitted tasks, by stage.
        returned: number of tasks that the worker gave back.
        pasted: number of texts with signs of pasted or generated text.
        earned: amount owed, in the currency's smallest unit.
    """

    worker: Worker
    texts: Mapping[str, int]
    verifications: int
    uncounted: int
    success: float | None
    golds: int
    golds_passed: int
    agreement: Agreement
    flag_rate: float | None
    median_seconds: Mapping[str, float]
    returned: int
    pasted: int
    earned: int


def decided_episodes(texts: Iterable[Text], kind: str) -> set[str]:
    """Return the ids of the episodes about which a collection has decided.

    Verifiers have followed their texts, which were kept or discarded. A rejected text decides only in a review of
    generated texts; otherwise its episode is written for again.

    Args:
        texts: texts of the collection.
        kind: kind of the collection.
    """
    final = (KEPT, REJECTED) if kind == REVIEW_KIND else (KEPT, DISCARDED)
    return {text.episode_id for text in texts if text.state in final}


def outcome_of(verification: Verification) -> Outcome:
    """Return what a verification says of its text."""
    return Outcome(verification.ndtw, verification.ptc, bool(verification.flags))


def walk_of(verification: Verification) -> Walk:
    """Return the walk of a verification, which must be there."""
    (path_1, path_2), (cell_1, cell_2) = verification.path, verification.placed_cells
    return Walk(verification.worker_id, (path_1, path_2), (cell_1, cell_2), frozenset(verification.flags))


def walks_by_text(verifications: Iterable[Verification], golds: frozenset[str]) -> dict[str, list[Walk]]:
    """Return the walks of each text, without those of golds and those that were deleted.

    Args:
        verifications: verifications in any order.
        golds: ids of the tasks that are golds.
    """
    found = dict[str, list[Walk]]()
    for verification in verifications:
        is_of_text = verification.text_id is not None and verification.task_id not in golds
        if verification.counts and is_of_text and verification.has_walk:
            found.setdefault(str(verification.text_id), []).append(walk_of(verification))
    return found


def overview_of(
    tasks: Sequence[Task],
    texts: Sequence[Text],
    verifications: Sequence[Verification],
    ledger: Sequence[LedgerEntry],
    settings: Settings,
) -> Overview:
    """Return the figures of a collection."""
    golds = gold_tasks(tasks)
    counted = [one for one in verifications if one.counts and one.task_id not in golds]
    known = [one for one in verifications if one.task_id in golds]
    kept = {text.text_id for text in texts if text.state == KEPT}
    agreements = [agreement_of(walks) for walks in walks_by_text(verifications, golds).values() if len(walks) > 1]
    days = Counter(task.ended_at.date() for task in tasks if task.state == SUBMITTED and task.ended_at is not None)
    paid = Counter[str]()
    for entry in ledger:
        paid[entry.kind] += entry.amount_minor
    return Overview(
        Counter(text.state for text in texts),
        Counter((task.stage, task.state) for task in tasks),
        dict(sorted(days.items())),
        _median_seconds(tasks),
        _mean(value for one in counted if one.text_id in kept for value in one.ndtw),
        _mean(float(succeeded(outcome_of(one), settings)) for one in counted),
        _mean(float(succeeded(outcome_of(one), settings)) for one in known),
        Agreement(
            _mean(one.path for one in agreements if one.path is not None),
            _mean(one.cell for one in agreements if one.cell is not None),
        ),
        paid,
    )


def figures_of_workers(
    workers: Sequence[Worker],
    tasks: Sequence[Task],
    texts: Sequence[Text],
    verifications: Sequence[Verification],
    ledger: Sequence[LedgerEntry],
    settings: Settings,
) -> list[WorkerFigures]:
    """Return the figures of each worker, in the given order."""
    golds = gold_tasks(tasks)
    walks = walks_by_text(verifications, golds)
    return [_figures_of(worker, tasks, texts, verifications, ledger, settings, golds, walks) for worker in workers]


def gold_tasks(tasks: Iterable[Task]) -> frozenset[str]:
    """Return the ids of the tasks that are golds."""
    return frozenset(task.task_id for task in tasks if task.is_gold)


def _figures_of(
    worker: Worker,
    tasks: Sequence[Task],
    texts: Sequence[Text],
    verifications: Sequence[Verification],
    ledger: Sequence[LedgerEntry],
    settings: Settings,
    golds: frozenset[str],
    walks: Mapping[str, Sequence[Walk]],
) -> WorkerFigures:
    mine = worker.worker_id
    done = [one for one in verifications if one.worker_id == mine]
    of_texts = [one for one in done if one.task_id not in golds]
    of_golds = [one for one in done if one.task_id in golds]
    written = [text for text in texts if text.worker_id == mine]
    own_tasks = [task for task in tasks if task.worker_id == mine]
    return WorkerFigures(
        worker,
        Counter(text.state for text in written),
        len(of_texts),
        sum(not one.counts for one in of_texts),
        _mean(float(succeeded(outcome_of(one), settings)) for one in of_texts if one.counts),
        len(of_golds),
        sum(succeeded(outcome_of(one), settings) for one in of_golds),
        agreement_with_others(mine, walks),
        _mean(float(bool(one.flags)) for one in of_texts),
        _median_seconds(own_tasks),
        sum(task.state == RETURNED for task in own_tasks),
        sum(bool(text.evidence) for text in written),
        sum(entry.amount_minor for entry in ledger if entry.worker_id == mine),
    )


def _median_seconds(tasks: Iterable[Task]) -> dict[str, float]:
    times = dict[str, list[float]]()
    for task in tasks:
        if task.state == SUBMITTED and task.measured_seconds is not None:
            times.setdefault(task.stage, []).append(task.measured_seconds)
    return {stage: median(values) for stage, values in times.items()}


def _mean(values: Iterable[float]) -> float | None:
    found = list(values)
    return fmean(found) if found else None
