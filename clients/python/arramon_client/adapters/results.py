"""The result of an episode that an adapter has played, as plain data."""

from collections.abc import Mapping
from typing import Any

from arramon_client.receipts import Receipt
from arramon_client.runs.info import RunInfo

METRICS = ("nDTW", "CTC-3", "PTC@CTC-3")
"""Metrics that adapters show where a framework expects few numbers: of the path, of the pick-up, of the placement."""


def episode_result(
    episode_id: str,
    cause: str,
    scores: Mapping[str, Mapping[str, float]] | None,
    report: Mapping[str, Any],
    receipt: Receipt,
) -> dict[str, Any]:
    """Return the result of an episode whose run is over.

    Args:
        episode_id: id of the episode.
        cause: why it ended, as the stream said.
        scores: its scores by row and metric; None on a hidden split.
        report: the run's report as plain data.
        receipt: the run's receipt.

    Returns:
        `run_id`, `episode_id`, `cause`, `scores`, `run_scores` (means over the run's episodes, by row and metric),
        `signature` (of the scores) and `receipt` (content of the receipt's file).
    """
    causes = {each["episode_id"]: each["cause"] for each in report["episodes"]}
    return {
        "run_id": report["run"]["run_id"],
        "episode_id": episode_id,
        "cause": causes.get(episode_id, cause),
        "scores": scores,
        "run_scores": {
            row: {metric: numbers["mean"] for metric, numbers in metrics.items()}
            for row, metrics in report["metrics"].items()
        },
        "signature": report["signature"],
        "receipt": receipt.file_content(),
    }


def run_result(report: Mapping[str, Any], receipt: Receipt) -> dict[str, Any]:
    """Return the result of the last episode of a run that is over; on a hidden split its id is unknown, None."""
    if not report["episodes"]:
        return episode_result("", "", None, report, receipt) | {"episode_id": None}
    episode = report["episodes"][-1]
    first, second = episode["turns"].values()
    total = {metric: (first[metric] + second[metric]) / 2 for metric in first}
    return episode_result(episode["episode_id"], "", {**episode["turns"], "total": total}, report, receipt)


def unfinished_result(info: RunInfo, episode_id: str, cause: str) -> dict[str, Any]:
    """Return the result of an ended episode of a run that is not over, and so has no scores yet."""
    return {"run_id": info.run_id, "episode_id": episode_id, "cause": cause, "scores": None}


def headline(rows: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
    """Return METRICS of the row "total", by metric."""
    return {metric: rows["total"][metric] for metric in METRICS}
