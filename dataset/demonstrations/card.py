"""The dataset card of an export: a README with metadata for dataset hubs."""

import json
from collections.abc import Mapping
from typing import Any

from arramon_dataset.demonstrations.croissant import is_generated
from arramon_dataset.demonstrations.description import describe_export
from arramon_dataset.demonstrations.request import ResolvedExport


def card(export: ResolvedExport, metadata: Mapping[str, Any], columns: Mapping[str, str]) -> str:
    """Return the text of the dataset card.

    Args:
        export: what was exported.
        metadata: further entries of the card's YAML header, written as JSON.
        columns: meaning of each column.
    """
    request = export.request
    head = {
        "pretty_name": f"ArraMon {request.split}",
        "language": list(request.languages),
        **({"license": "mit"} if is_generated(export) else {}),
        "task_categories": ["robotics"],
        "tags": ["vision-and-language-navigation", "imitation-learning", "arramon"],
        **metadata,
    }
    lines = "".join(f"{json.dumps(name)}: {json.dumps(value, ensure_ascii=False)}\n" for name, value in head.items())
    rows = "".join(f"| `{name}` | {meaning} |\n" for name, meaning in columns.items())
    options = f"--split {request.split} --format {request.format}"
    return (
        f"---\n{lines}---\n\n# ArraMon {request.split}\n\n{describe_export(export)}\n\n"
        f"Made by `arramon-server export-demos {options}`; `demonstrations.json` has all settings. "
        "One row is one step: what the agent saw, and the action that was taken. Images are lossless, and equal to "
        "what an agent sees in the environments.\n\n"
        f"| column | |\n| --- | --- |\n{rows}"
    )
