"""Files for the Hugging Face Hub: a run's scores for a model's page, `.eval_results/*.yaml`.

The task ids are those of `deploy/huggingface/eval.yaml`, the file that makes a dataset a benchmark.
"""

from pathlib import Path
from typing import Any

from arramon_client.adapters.extras import extra
from arramon_client.adapters.results import METRICS
from arramon_client.errors import UsageError
from arramon_client.files import write_whole
from arramon_client.receipts import read_file

with extra("hub"):
    import yaml
    from huggingface_hub import EvalResultEntry, eval_result_entries_to_yaml

FOLDER = ".eval_results"
"""Folder of result files in a model's repository."""


def task_id(split: str, language: str, metric: str) -> str:
    """Return the id of a task, such as "val_seen_en_ptc"."""
    return f"{split}_{language}_{metric.partition('@')[0].replace('-', '').lower()}"


def eval_results(
    results: dict[str, Any], dataset: str, *, source: str | None = None, notes: str | None = None
) -> list[EvalResultEntry]:
    """Return the entries for a run's scores: nDTW, CTC-3 and PTC@CTC-3 of both turns, in percent.

    Args:
        results: content of a run's results file, or `Run.report()`.
        dataset: id of the benchmark's dataset on the Hub, such as "ORGANIZATION/arramon".
        source: where the run can be seen, such as its page on the leaderboard.
        notes: details of the set-up. By default the signature of the scores, and the run's id, by which its receipt is
            found on the server.

    Raises:
        UsageError: if the run was not played to its end.
    """
    run = results["run"]
    if run["state"] != "RUN_STATE_COMPLETE":
        raise UsageError(f"run {run['run_id']} is {run['state']}, expected one that was played to its end")
    return [
        EvalResultEntry(
            dataset_id=dataset,
            task_id=task_id(run["split"], run["language"], metric),
            value=round(100 * results["metrics"]["total"][metric]["mean"], 2),
            date=run["ended_at"] or None,
            source_url=source,
            source_name=None if source is None else f"ArraMon run {run['run_id']}",
            notes=notes or f"{results['signature']}; run {run['run_id']}",
        )
        for metric in METRICS
    ]


def write_eval_results(
    results: Path, folder: Path, dataset: str, *, source: str | None = None, notes: str | None = None
) -> Path:
    """Write the entries of a results file into a model's repository, and return the file's path.

    Args:
        results: a run's results file.
        folder: the model's repository.
        dataset, source, notes: see `eval_results`.

    Raises:
        UsageError: if the run was not played to its end.
        ReceiptError: if the results file cannot be read.
        OutputError: if the file cannot be written.
    """
    content = read_file(results, "results file")
    if not isinstance(content, dict) or not {"run", "metrics", "signature"} <= content.keys():
        raise UsageError(f"{results} is not a results file: it lacks run, metrics or signature")
    entries = eval_results(content, dataset, source=source, notes=notes)
    (folder / FOLDER).mkdir(parents=True, exist_ok=True)
    path = folder / FOLDER / f"arramon_{content['run']['split']}_{content['run']['language']}.yaml"
    write_whole(path, yaml.safe_dump(eval_result_entries_to_yaml(entries), sort_keys=False, allow_unicode=True))
    return path
