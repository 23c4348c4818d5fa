"""The command `arramon-client report`: scores of runs by what the turns ask for."""

import argparse
from collections.abc import Sequence
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

from arramon.v1 import evaluation_pb2 as pb
from arramon_client.commands.base import run
from arramon_client.commands.server_options import add_server, server_of
from arramon_client.errors import UsageError
from arramon_client.output import console, print_json
from arramon_client.transport.connection import call

METRICS = {
    "nDTW": ("nDTW", "navigation"),
    "CTC-3": ("CTC-3", "navigation"),
    "rPOD": ("rPOD", "assembly"),
    "PTC": ("PTC", "assembly"),
    "both": ("PTC@CTC-3", "both phases"),
}
"""Metric and its phase, by value of `--metric`."""

ASPECTS = {
    "turn": "turn",
    "length": "moves forward on the right path",
    "corners": "changes of direction on the right path",
    "object": "target's look in the training data",
    "steps": "steps in the navigation instruction",
    "landmarks": "things that it names",
    "step": "it has a step of the kind",
    "landmark": "it names a",
    "relation": "it states a relation",
    "placement": "the assembly instruction states",
}
"""Heading of a table's section, by aspect."""

NAMES = {
    "turn": {"first": "first", "second": "second"},
    "step": {
        "turn": "turn on the spot",
        "turn_at": "turn at a thing",
        "turn_before": "turn before a thing",
        "turn_after": "turn after a thing",
        "face": "face a thing",
        "ahead": "walk straight on",
        "to": "walk to a thing",
        "towards": "walk towards a thing",
        "until": "walk until it is seen",
        "beside": "walk until it is beside",
        "past": "walk past a thing",
        "between": "walk between two things",
        "along": "walk along a thing",
    },
}
"""Description of a group, by aspect and name, for names that are not clear alone."""

PLOT = 24
"""Width of the plot in characters."""

WIDTH, LABEL, CELL = 100, 48, 44
"""Widths in characters: minimum width of a table; with plots, of the first columns and of each run's columns."""


def main(argv: Sequence[str]) -> int:
    """Run `arramon-client report` and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="arramon-client report",
        allow_abbrev=False,
        description="Show what runs can and cannot do: their scores by what the turns ask for.",
    )
    parser.add_argument("runs", nargs="+", metavar="RUN", help="id of a run of your own, or of a published one")
    parser.add_argument(
        "--metric",
        choices=tuple(METRICS),
        help="show this score alone, with a plot; both: PTC where CTC-3 is 1 (default with several runs: both)",
    )
    parser.add_argument("--json", action="store_true", help="print all groups and scores as JSON")
    add_server(parser)
    return run(parser, argv, _main)


def _main(options: argparse.Namespace) -> None:
    with server_of(options) as server:
        found = [
            call(server.stub.GetBreakdown, pb.GetBreakdownRequest(run_id=run_id), server.address)
            for run_id in options.runs
        ]
    if options.json:
        print_json([as_json(one) for one in found])
        return
    splits = {one.run.split for one in found}
    if len(splits) > 1:
        raise UsageError(f"the runs are on different splits: {', '.join(sorted(splits))}; give runs on one")
    metric = options.metric or ("both" if len(found) > 1 else None)
    shown = console(max(WIDTH, LABEL + len(found) * CELL if metric else 0))
    shown.print(all_scores(found[0]) if metric is None else one_score(found, metric))
    for line in notes(found):
        shown.print(line, soft_wrap=True)


def all_scores(found: pb.Breakdown) -> Table:
    """Return the table of all of a run's scores, with intervals, by groups of turns."""
    made = _table(Text(f"{found.run.agent} on {found.run.split}, {found.run.language}"))
    for name, (_, phase) in METRICS.items():
        heading = "PTC" if name == "both" else name
        made.add_column(f"{heading}\n{phase}", justify="right", no_wrap=True)
    aspect = ""
    for group in found.groups:
        if group.aspect != aspect:
            aspect = group.aspect
            made.add_section()
            made.add_row(Text(ASPECTS.get(aspect, aspect), "bold"))
        scores = {score.metric: score for score in group.scores}
        cells = [_cell(scores.get(metric)) for metric, _ in METRICS.values()]
        made.add_row(f"  {describe_group(group)}", str(group.turns), *cells)
    return made


def one_score(runs: Sequence[pb.Breakdown], metric: str) -> Table:
    """Return the table of one score by groups of turns, with a column and a plot from 0 to 1 for each run."""
    wanted, phase = METRICS[metric]
    heading = "PTC" if metric == "both" else metric
    made = _table(Text(f"{heading}, {phase}: {runs[0].run.split}; | from 0 to 1 |, o the mean, - its 95% interval"))
    for number, one in enumerate(runs):
        made.add_column(Text(f"{chr(ord('a') + number % 26)}: {one.run.agent}, {one.run.language}"), justify="right")
        made.add_column("", no_wrap=True)
    by_key = [{_key(group): group for group in one.groups} for one in runs]
    aspect = ""
    for key in dict.fromkeys(key for groups in by_key for key in groups):
        if key[0] != aspect:
            aspect = key[0]
            made.add_section()
            made.add_row(Text(ASPECTS.get(aspect, aspect), "bold"))
        group = next(groups[key] for groups in by_key if key in groups)
        cells: list[str] = []
        for groups in by_key:
            score = next((s for s in groups[key].scores if s.metric == wanted), None) if key in groups else None
            cells += ["-", ""] if score is None else [_cell(score), plot(score)]
        made.add_row(f"  {describe_group(group)}", str(group.turns), *cells)
    return made


def plot(score: pb.Score) -> str:
    """Return a text plot of a score's interval and mean on a line from 0 to 1."""
    last = PLOT - 1
    low, mean, high = (round(min(max(value, 0), 1) * last) for value in (score.low, score.mean, score.high))
    line = ["-" if low <= place <= high else " " for place in range(PLOT)]
    line[mean] = "o"
    return f"|{''.join(line)}|"


def describe_group(group: pb.TurnGroup) -> str:
    """Return the description of a group: what its turns have in common."""
    if group.name:
        return NAMES.get(group.aspect, {}).get(group.name, group.name.replace("_", " "))
    if not group.HasField("high"):
        return f"{group.low} or more"
    return str(group.low) if group.low == group.high else f"{group.low} to {group.high}"


def notes(found: Sequence[pb.Breakdown]) -> list[str]:
    """Return lines that explain rounding and missing groups."""
    lines = []
    withheld = max(one.withheld for one in found)
    if any(one.rounded for one in found):
        lines.append("hidden split: scores are rounded, and no combination of groups is about fewer than 20 episodes")
    if withheld:
        lines.append(f"{withheld} groups are left out, as they would reveal scores of single episodes")
    if not all(one.reads for one in found):
        lines.append("groups by what the instructions ask for are missing; a host can run `arramon-server demands`")
    return lines


def as_json(found: pb.Breakdown) -> dict[str, Any]:
    """Return a run's breakdown as plain data."""
    return {
        "run_id": found.run.run_id,
        "agent": found.run.agent,
        "split": found.run.split,
        "language": found.run.language,
        "signature": found.signature,
        "rounded": found.rounded,
        "withheld": found.withheld,
        "reads": found.reads,
        "groups": [
            {
                "aspect": group.aspect,
                "name": group.name or None,
                "low": None if group.name else group.low,
                "high": group.high if group.HasField("high") else None,
                "turns": group.turns,
                "episodes": group.episodes,
                "scores": {s.metric: {"mean": s.mean, "low": s.low, "high": s.high} for s in group.scores},
            }
            for group in found.groups
        ],
    }


def _table(title: Text) -> Table:
    made = Table(title=title, box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), show_edge=False, pad_edge=False)
    made.add_column("turns with", no_wrap=True)
    made.add_column("number", justify="right", no_wrap=True)
    return made


def _key(group: pb.TurnGroup) -> tuple[str, str, int]:
    return group.aspect, group.name, group.low


def _cell(score: pb.Score | None) -> str:
    if score is None:
        return "-"
    low, high = (f"{value:.2f}".removeprefix("0") for value in (score.low, score.high))
    return f"{score.mean:.3f} {low}-{high}"
