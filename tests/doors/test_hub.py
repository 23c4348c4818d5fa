"""Files for the Hugging Face Hub, read back by the Hub's own library."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from huggingface_hub import parse_eval_result_entries

from arramon_client.adapters.hub import eval_results, task_id, write_eval_results
from arramon_client.adapters.results import METRICS
from arramon_client.errors import UsageError
from arramon_client.printable import to_json
from tests import ROOT

MEANS = {"nDTW": 0.51239, "CTC-3": 0.25, "PTC@CTC-3": 0.125}

RESULTS: dict[str, Any] = {
    "signature": "split:val_seen|lang:hi",
    "run": {
        "run_id": "0" * 32,
        "state": "RUN_STATE_COMPLETE",
        "split": "val_seen",
        "language": "hi",
        "ended_at": "2026-01-02T03:04:05Z",
    },
    "metrics": {"total": {name: {"mean": mean, "low": 0.0, "high": 1.0} for name, mean in MEANS.items()}},
}


def test_a_results_file_becomes_entries_of_the_benchmarks_tasks(tmp_path: Path) -> None:
    results = tmp_path / "run.json"
    results.write_text(to_json(RESULTS))
    path = write_eval_results(results, tmp_path / "model", "someone/arramon", source="https://example.org/run")
    assert path == tmp_path / "model" / ".eval_results" / "arramon_val_seen_hi.yaml"
    entries = parse_eval_result_entries(yaml.safe_load(path.read_text()))
    assert [(entry.dataset_id, entry.task_id, entry.value) for entry in entries] == [
        ("someone/arramon", "val_seen_hi_ndtw", 51.24),
        ("someone/arramon", "val_seen_hi_ctc3", 25.0),
        ("someone/arramon", "val_seen_hi_ptc", 12.5),
    ]
    (entry, *_) = entries
    assert (entry.date, entry.source_url) == ("2026-01-02T03:04:05Z", "https://example.org/run")
    assert entry.notes == f"split:val_seen|lang:hi; run {'0' * 32}"
    tasks = {task["id"] for task in benchmark()["tasks"]}
    assert {entry.task_id for entry in entries} <= tasks


def test_a_cancelled_run_has_no_entries() -> None:
    cancelled = {**RESULTS, "run": {**RESULTS["run"], "state": "RUN_STATE_CANCELLED"}}
    with pytest.raises(UsageError, match="is RUN_STATE_CANCELLED, expected one that was played to its end"):
        eval_results(cancelled, "someone/arramon")


def test_other_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "other.json").write_text("[]")
    with pytest.raises(UsageError, match="is not a results file"):
        write_eval_results(tmp_path / "other.json", tmp_path, "someone/arramon")


def test_the_benchmark_has_a_task_for_each_split_language_and_metric() -> None:
    content = benchmark()
    assert {"name", "description", "evaluation_framework", "tasks"} == content.keys()
    assert [task["id"] for task in content["tasks"]] == [
        task_id(split, language, metric)
        for split in ("val_seen", "val_unseen")
        for language in ("en", "hi")
        for metric in METRICS
    ]


def benchmark() -> dict[str, Any]:
    content: dict[str, Any] = yaml.safe_load((ROOT / "deploy" / "huggingface" / "eval.yaml").read_text())
    return content
