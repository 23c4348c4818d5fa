"""The command `export-demos`: export of demonstrations in formats for training code."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from arramon_client.world import DEFAULT_SENSORS
from arramon_dataset.demonstrations.request import (
    DEFAULT_SIZE,
    EXPORTED_SENSORS,
    FORMATS,
    LARGEST,
    REWARDS,
    SMALLEST,
    STRIDE,
    ExportRequest,
    make_request,
)
from arramon_server.commands import Commands
from arramon_server.commands.journal import open_journal
from arramon_server.errors import BadInput

if TYPE_CHECKING:
    from arramon_dataset.demonstrations.sources import EpisodeSelection
    from arramon_server.episodes.splits import Split

DEFAULT_SPLIT = "train"

OUTPUT = "demonstrations"
"""Default parent folder of exports."""


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command."""
    export = commands.add_parser(
        "export-demos",
        parents=[common],
        help="export ground truth or a recorded run with frames, for training",
        description="Export ground truth or a recorded run, rendered as agents see it. Run the same command again to "
        "resume a killed export.",
    )
    export.add_argument("--split", metavar="S", help=f"open split (default: that of the run, or {DEFAULT_SPLIT})")
    export.add_argument("--format", required=True, metavar="F", help=f"one of {', '.join(FORMATS)}")
    export.add_argument("--lang", nargs="+", default=(), metavar="L", help="languages (default: all in the split)")
    export.add_argument(
        "--sensors",
        nargs="+",
        metavar="SENSOR",
        help=f"some of {', '.join(EXPORTED_SENSORS)} (default: {' '.join(DEFAULT_SENSORS)})",
    )
    export.add_argument(
        "--size",
        type=int,
        metavar="PIXELS",
        help=f"side length of images: a multiple of {STRIDE} from {SMALLEST} to {LARGEST}, or 84 (default: "
        f"{DEFAULT_SIZE})",
    )
    export.add_argument(
        "--reward", default="sparse", metavar="R", help=f"one of {', '.join(REWARDS)} (default: %(default)s)"
    )
    export.add_argument(
        "--single-dataset",
        action="store_true",
        help="with --format minari, one dataset for all languages (default: one for each)",
    )
    export.add_argument("--run", metavar="RUN", help="id of a finished run, to export instead of ground truth")
    export.add_argument("--episodes", type=int, metavar="N", help="export only N episodes, a fair sample of the split")
    export.add_argument("--output", type=Path, metavar="FOLDER", help=f"folder (default: {OUTPUT}/SPLIT-FORMAT)")
    export.add_argument("--jobs", type=int, default=0, help="number of processes (default: one for each core)")
    export.set_defaults(command=_export)


def _export(arguments: argparse.Namespace) -> None:
    # Imported only here: the simulator takes half a second to load.
    from arramon_dataset.demonstrations.export import ExportProgress, export_demonstrations
    from arramon_dataset.demonstrations.formats import load_format

    request = _request(arguments, arguments.split or DEFAULT_SPLIT, arguments.lang)
    load_format(request.format)
    request, split, sources = _of_run(arguments) if arguments.run else _of_split(request)
    for episode_id, reason in sources.left_out.items():
        print(f"left out: episode {episode_id}: {reason}", file=sys.stderr)

    def on_progress(progress: ExportProgress) -> None:
        print(progress, file=sys.stderr, flush=True)

    output = arguments.output or Path(OUTPUT) / f"{arguments.run or split.name}-{request.format}"
    export = export_demonstrations(request, split, sources, output, jobs=arguments.jobs, on_progress=on_progress)
    print(f"{output}: {export.episodes} episodes with {export.steps} steps in {', '.join(request.languages)}")


def _request(arguments: argparse.Namespace, split: str, languages: Sequence[str]) -> ExportRequest:
    return make_request(
        arguments.data,
        split,
        arguments.format,
        languages=languages,
        sensors=arguments.sensors,
        size=arguments.size,
        reward=arguments.reward,
        run_id=arguments.run,
        episodes=arguments.episodes,
        single_dataset=arguments.single_dataset,
    )


def _of_split(request: ExportRequest) -> "tuple[ExportRequest, Split, EpisodeSelection]":
    from arramon_dataset.demonstrations.export import complete_request
    from arramon_dataset.demonstrations.sources import ground_truth
    from arramon_server.episodes.splits import read_named_split

    split = read_named_split(request.data, request.split)
    request = complete_request(request, split)
    return request, split, ground_truth(split, request)


def _of_run(arguments: argparse.Namespace) -> "tuple[ExportRequest, Split, EpisodeSelection]":
    from arramon_dataset.demonstrations.export import complete_request
    from arramon_dataset.demonstrations.sources import recorded_run
    from arramon_server.episodes.splits import read_named_split
    from arramon_server.runs.storage.journal import Journal

    with open_journal(arguments.settings, read_only=True) as database:
        journal = Journal(database)
        run = journal.run(arguments.run)
        if arguments.split not in (None, run.split):
            raise BadInput(
                f"run {run.run_id!r} was played on {run.split!r}, not on {arguments.split!r}; leave --split out"
            )
        split = read_named_split(arguments.data, run.split)
        request = complete_request(_request(arguments, run.split, arguments.lang or (run.language,)), split)
        return request, split, recorded_run(journal, run, split, request)
