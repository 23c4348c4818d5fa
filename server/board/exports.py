"""Export of listings as CSV and JSON files, see `docs/explanation/leaderboard.md`."""

import csv
import io
import json
import unicodedata
from dataclasses import asdict
from functools import lru_cache
from typing import Any

from arramon_server.board.board import StandingsListing
from arramon_server.board.standings import COLUMNS, TOTAL, Entry, PaperResult, Rows, Standing
from arramon_server.runs.storage.corrections import Correction
from arramon_server.scoring.aggregate import ROWS

FORMAT, VERSION = "arramon-standings", 1

_FORMULA = ("=", "+", "-", "\N{MINUS SIGN}", "@")
"""Initial characters that make a spreadsheet read a cell as a formula, also in full-width or superscript forms."""

_SKIPPED = frozenset(("Cc", "Cf", "Zs", "Zl", "Zp"))
"""Unicode categories that a spreadsheet may ignore at the start of a cell: controls, invisible characters, spaces."""

_TURNS = tuple(row for row in ROWS if row != TOTAL)

CSV_COLUMNS = (
    "kind",
    "rank",
    "tied",
    "participant",
    "agent",
    "split",
    "language",
    "sensors",
    "coverage",
    "marks",
    *(f"{metric}{end}" for metric in COLUMNS for end in ("", " low", " high")),
    *(f"{metric} {turn}" for turn in _TURNS for metric in COLUMNS),
    "published_at",
    "run_id",
    "signature",
    "note",
    "last rank",
    "runs begun",
    "runs published",
    "gap",
    "gap low",
    "gap high",
    "higher language",
    "lower language",
    "same outcome",
    "seeds",
    "seed deviation",
    "seconds a step",
    "declared parameters",
    "declared tokens",
    "declared price",
    "reproduced by",
    "reproduces",
    "void episodes",
)
"""Columns of the CSV file, in order. New columns are appended."""

_KEPT = 16
"""Maximum number of cached exports."""


@lru_cache(_KEPT)
def as_csv(listing: StandingsListing) -> str:
    """Return a listing as CSV (RFC 4180): one line per standing, then one per reference. Scores are in [0, 1]."""
    text = io.StringIO()
    writer = csv.DictWriter(text, CSV_COLUMNS, restval="")
    writer.writeheader()
    for standing in listing.standings:
        writer.writerow(_guarded(_standing_cells(standing, listing)))
    for reference in listing.references:
        writer.writerow(_guarded(_reference_cells(reference)))
    return text.getvalue()


@lru_cache(_KEPT)
def as_json(listing: StandingsListing) -> str:
    """Return a listing as JSON, with all fields of the standings and all metrics of all rows."""
    document = {
        "format": FORMAT,
        "version": VERSION,
        "split": listing.split,
        "language": listing.language,
        "sort": listing.sort,
        "standings": [_standing(standing) for standing in listing.standings],
        "references": [_reference(reference) for reference in listing.references],
        "corrections": [_correction(correction) for correction in listing.corrections],
        "frozen": listing.frozen,
    }
    return json.dumps(document, ensure_ascii=False) + "\n"


def _standing_cells(standing: Standing, listing: StandingsListing) -> dict[str, object]:
    cells: dict[str, object] = {
        "kind": "run",
        "rank": standing.rank or "",
        "tied": "yes" if standing.tied else "no",
        "participant": standing.participant,
        "agent": standing.agent,
        "split": listing.split,
        "language": listing.language,
        "sensors": " ".join(standing.sensors),
        "coverage": "" if standing.coverage is None else standing.coverage,
        "marks": " ".join(standing.marks),
        "published_at": " ".join(entry.published_at.isoformat(timespec="seconds") for entry in standing.entries),
        "run_id": " ".join(entry.run.run_id for entry in standing.entries),
        "signature": " ".join(entry.signature for entry in standing.entries),
        "note": " / ".join(entry.note for entry in standing.entries if entry.note),
        "last rank": standing.last_rank or "",
        "runs begun": standing.attempts.begun,
        "runs published": standing.attempts.published,
        "seeds": standing.seeds,
        "seed deviation": standing.spread.deviation if standing.spread else "",
        "seconds a step": "" if standing.seconds_a_step is None else standing.seconds_a_step,
        **{f"declared {name}": "" if value is None else value for name, value in asdict(standing.cost).items()},
        "reproduced by": standing.reproduced_by,
        "reproduces": " ".join(entry.reproduces for entry in standing.entries if entry.reproduces),
        "void episodes": max(entry.voided for entry in standing.entries),
    }
    if standing.gap is not None:
        gap = standing.gap
        cells |= {"gap": gap.mean, "gap low": gap.low, "gap high": gap.high, "same outcome": gap.same}
        cells |= {"higher language": gap.higher, "lower language": gap.lower}
    for metric in COLUMNS if standing.rows else ():
        total = standing.rows[TOTAL][metric]
        cells |= {metric: total.mean, f"{metric} low": total.low, f"{metric} high": total.high}
        cells |= {f"{metric} {turn}": standing.rows[turn][metric].mean for turn in _TURNS}
    return cells


def _reference_cells(reference: PaperResult) -> dict[str, object]:
    cells: dict[str, object] = {
        "kind": "paper",
        "agent": reference.name,
        "split": reference.split,
        "language": reference.language,
        "note": f"{reference.source}. {reference.note}".strip(),
    }
    cells |= reference.rows[TOTAL]
    for turn in _TURNS:
        cells |= {f"{metric} {turn}": value for metric, value in reference.rows.get(turn, {}).items()}
    return cells


def _guarded(cells: dict[str, object]) -> dict[str, object]:
    """Return the cells, with an apostrophe before each text that a spreadsheet would read as a formula."""
    return {name: f"'{cell}" if isinstance(cell, str) and _is_formula(cell) else cell for name, cell in cells.items()}


def _is_formula(cell: str) -> bool:
    if cell.startswith(("\t", "\r", "\n")):
        return True
    letters = unicodedata.normalize("NFKC", cell)
    first = next((letter for letter in letters if unicodedata.category(letter) not in _SKIPPED), "")
    return first in _FORMULA


def _standing(standing: Standing) -> dict[str, Any]:
    return {
        "rank": standing.rank or None,
        "tied": standing.tied,
        "participant": standing.participant,
        "agent": standing.agent,
        "languages": standing.languages,
        "sensors": standing.sensors,
        "coverage": standing.coverage,
        "marks": standing.marks,
        "rows": _rows(standing.rows),
        "entries": [_entry(entry) for entry in standing.entries],
        "last_rank": standing.last_rank or None,
        "runs_begun": standing.attempts.begun,
        "runs_published": standing.attempts.published,
        "gap": asdict(standing.gap) if standing.gap else None,
        "seeds": asdict(standing.spread) if standing.spread else None,
        "seconds_a_step": standing.seconds_a_step,
        "declared_cost": asdict(standing.cost),
        "reproduced_by": standing.reproduced_by,
    }


def _entry(entry: Entry) -> dict[str, Any]:
    run = entry.run
    return {
        "run_id": run.run_id,
        "language": run.language,
        "state": run.state,
        "created_at": run.created_at.isoformat(timespec="seconds"),
        "ended_at": run.ended_at.isoformat(timespec="seconds") if run.ended_at else None,
        "published_at": entry.published_at.isoformat(timespec="seconds"),
        "note": entry.note,
        "signature": entry.signature,
        "episodes": entry.progress.episodes,
        "steps": entry.progress.steps,
        "causes": dict(entry.causes),
        "reoffers": entry.progress.reoffers,
        "images": entry.progress.images,
        "step_seconds": run.step_seconds,
        "bank_seconds": run.bank_seconds,
        "agent_arguments": dict(run.agent_arguments),
        "coverage": entry.coverage,
        "marks": entry.marks,
        "thinking_seconds": entry.progress.thinking_seconds,
        "timed_steps": entry.progress.timed_steps,
        "declared_cost": asdict(entry.cost),
        "code": run.code.named(),
        "reproduces": entry.reproduces,
        "reproduced_by": len(entry.reproducers),
        "void_episodes": entry.voided,
    }


def _correction(correction: Correction) -> dict[str, Any]:
    return {
        "kind": correction.kind.value,
        "made_at": correction.made_at.isoformat(timespec="seconds"),
        "reason": correction.reason,
        "episodes": correction.episodes,
        "data_before": correction.data_before,
        "data_after": correction.data_after,
    }


def _rows(rows: Rows) -> dict[str, Any]:
    return {
        row: {metric: {"mean": i.mean, "low": i.low, "high": i.high} for metric, i in metrics.items()}
        for row, metrics in rows.items()
    }


def _reference(reference: PaperResult) -> dict[str, Any]:
    return {name: getattr(reference, name) for name in PaperResult.__slots__}
