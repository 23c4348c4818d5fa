"""Results of a run: the score table, laid out like the paper's, and the results file."""

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from google.protobuf.json_format import MessageToDict
from rich import box
from rich.table import Table

from arramon.strict_json import NotJsonError, read_json
from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client.errors import OutputError, UsageError
from arramon_client.files import write_whole
from arramon_client.output import episodes_text
from arramon_client.printable import to_json
from arramon_client.session import AgentFailure
from arramon_client.transport.incoming import check_run_id

COLUMNS = (
    ("nDTW", "nDTW"),
    ("CTC\nk=0", "CTC-0"),
    ("CTC\nk=3", "CTC-3"),
    ("CTC\nk=5", "CTC-5"),
    ("CTC\nk=7", "CTC-7"),
    ("rPOD", "rPOD@CTC-3"),
    ("PTC", "PTC@CTC-3"),
)
"""Heading and metric of each column of the paper's table 2; its assembly columns are gated by CTC-3."""

TABLE_WIDTH = 100
"""Minimum width of the score table in characters: on a narrower terminal its lines wrap instead of being cut off."""

FORMAT = 1
"""Version of the results file's format."""


def score_table(report: evaluation_pb2.Report) -> Table:
    """Return the score table: rows for turn 1, turn 2 and the total, with each score's 95% interval below it."""
    run = report.run
    table = table_of_metrics(
        f"{run.agent} on {run.split}, {run.language}, {episodes_text(run.episodes)}",
        "below each score: its 95% interval; rPOD and PTC count where CTC-3 is 1",
    )
    for row in report.rows:
        scores = {score.metric: score for score in row.scores}
        table.add_row(row.name, *(score_cell(scores.get(metric)) for _, metric in COLUMNS))
    return table


def table_of_metrics(title: str, caption: str) -> Table:
    """Return an empty table with a column for row names, and one for each of COLUMNS."""
    table = Table(title=title, caption=caption, box=box.SIMPLE_HEAD, padding=0, show_edge=False, pad_edge=False)
    table.add_column("", no_wrap=True)
    for heading, _ in COLUMNS:
        table.add_column(heading, justify="right", no_wrap=True)
    return table


def check_output(folder: Path, what: str = "results") -> None:
    """Check that files can be written to a folder, creating it if necessary.

    Args:
        folder: the folder.
        what: what will be written, for the message.

    Raises:
        OutputError: if the folder cannot be created or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OutputError(f"{what} cannot be written to {folder}: {error.strerror or error}") from error


def write_results(
    report: evaluation_pb2.Report,
    failures: Sequence[AgentFailure],
    folder: Path,
    actions: Mapping[str, Sequence[int]] = MappingProxyType({}),
    agent_report: Mapping[str, Any] = MappingProxyType({}),
) -> Path:
    """Write `<folder>/<run id>.json` atomically. Actions and the agent's report in an existing file are kept.

    Args:
        report: the report of a complete run.
        failures: the agent's failures in this client.
        folder: the folder for results.
        actions: actions sent by this client, by episode id.
        agent_report: what the agent reports of the run; empty to keep an earlier report.

    Returns:
        The path of the file.

    Raises:
        OutputError: if it cannot be written.
    """
    path = folder / f"{check_run_id(report.run.run_id)}.json"
    sent = {episode_id: "".join(map(str, taken)) for episode_id, taken in actions.items()}
    own = agent_report or _earlier(path, "agent_report")
    content = {**results(report, failures, own), "actions": {**_earlier(path, "actions"), **sent}}
    write_whole(path, to_json(content))
    return path


def _earlier(path: Path, key: str) -> dict[str, Any]:
    """Return an object in an existing results file; empty if there is none."""
    try:
        content = read_json(path.read_bytes())
    except (OSError, NotJsonError):
        return {}
    found = content.get(key) if isinstance(content, dict) else None
    return found if isinstance(found, dict) else {}


def results(
    report: evaluation_pb2.Report,
    failures: Sequence[AgentFailure],
    agent_report: Mapping[str, Any] = MappingProxyType({}),
) -> dict[str, Any]:
    """Return the content of the results file as plain data, without the actions."""
    run = MessageToDict(report.run, preserving_proto_field_name=True, always_print_fields_with_no_presence=True)
    run["steps"] = report.run.steps  # The protocol's own JSON writes 64-bit numbers as text.
    metrics = {row.name: {score.metric: _numbers(score) for score in row.scores} for row in report.rows}
    return {
        "format": FORMAT,
        "signature": report.signature,
        "run": run,
        "table": [
            {"row": name, **{metric: scores[metric]["mean"] for _, metric in COLUMNS if metric in scores}}
            for name, scores in metrics.items()
        ],
        "metrics": metrics,
        "episodes": [_episode(episode) for episode in report.episodes],
        "agent_failures": [
            {"episodes": list(failure.episode_ids), "message": failure.message, "details": failure.details}
            for failure in failures
        ],
        **({"agent_report": dict(agent_report)} if agent_report else {}),
    }


def _episode(episode: evaluation_pb2.EpisodeScores) -> dict[str, Any]:
    return {
        "episode_id": episode.episode_id,
        "cause": types_pb2.Cause.Name(episode.cause).removeprefix("CAUSE_"),
        "steps": episode.steps,
        "turns": {row.name: {score.metric: score.mean for score in row.scores} for row in episode.turns},
    }


def _numbers(score: evaluation_pb2.Score) -> dict[str, float]:
    return {"mean": score.mean, "low": score.low, "high": score.high}


def reported_cost(path: Path, run_id: str) -> tuple[int | None, float | None]:
    """Return tokens and price in US dollars of a run, as its agent reports them in a results file; None if unknown.

    Args:
        path: the results file.
        run_id: the run that it must be of.

    Raises:
        UsageError: if it cannot be read, is no results file, or is of another run.
    """
    try:
        content = read_json(path.read_bytes())
    except OSError as error:
        raise UsageError(f"--results {path} cannot be read: {error.strerror or error}") from error
    except NotJsonError as error:
        raise UsageError(f"--results {path} {error}") from error
    if _inside(content, "run", "run_id") != run_id:
        raise UsageError(f"--results {path} is not the results file of run {run_id}")
    tokens = _inside(content, "agent_report", "measured", "tokens", "total")
    price = _inside(content, "agent_report", "declared", "price_usd")
    return (tokens if _is_amount(tokens) else None), (float(price) if _is_amount(price) else None)


def _inside(content: Any, *keys: str) -> Any:
    """Return what is under nested keys; None if there is nothing."""
    for key in keys:
        content = content.get(key) if isinstance(content, dict) else None
    return content


def _is_amount(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and value >= 0


def score_cell(score: evaluation_pb2.Score | None) -> str:
    """Format the mean, with the interval on the next line, without leading zeros so that the table fits 80 columns."""
    if score is None:
        return "-"
    low, high = (f"{value:.3f}".removeprefix("0") for value in (score.low, score.high))
    return f"{score.mean:.3f}\n{low}-{high}"
