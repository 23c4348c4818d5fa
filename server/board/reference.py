"""Results reported in the paper, read from `paper.toml`."""

import tomllib
from importlib import resources

from arramon_server.board.standings import PaperResult

_NOT_REPORTED = "-"


def read_references() -> tuple[PaperResult, ...]:
    """Return all lines of the paper's tables, in the order of the paper."""
    data = tomllib.loads(resources.files("arramon_server.board").joinpath("paper.toml").read_text(encoding="utf-8"))
    return tuple(
        PaperResult(
            name=line["name"],
            short=line["short"],
            split=line["split"],
            language=data["language"],
            rows={
                row: {
                    metric: float(value)
                    for metric, value in zip(data["columns"], values, strict=True)
                    if value != _NOT_REPORTED
                }
                for row, values in line["rows"].items()
            },
            source=line["source"],
            note=line.get("note", ""),
        )
        for line in data["line"]
    )
