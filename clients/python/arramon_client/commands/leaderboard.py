"""The commands `arramon-client leaderboard`, `publish` and `withdraw`."""

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from google.protobuf.json_format import MessageToDict
from rich import box
from rich.table import Table
from rich.text import Text, TextType

from arramon.v1 import evaluation_pb2, leaderboard_pb2_grpc
from arramon.v1 import leaderboard_pb2 as pb
from arramon_client.commands.base import run
from arramon_client.commands.server_options import add_server, server_of
from arramon_client.errors import ProtocolError, UsageError
from arramon_client.notices import closing_line, correction_lines, host_lines
from arramon_client.output import console, print_json
from arramon_client.results import COLUMNS, reported_cost, score_cell
from arramon_client.transport.connection import Server, call

BOTH = "both"
"""Value of `--lang` for the combined list of all languages of a split."""

TOTAL = "total"

SHOWN = {1: "better", 0: "no difference", -1: "worse"}
"""Words for the outcome of a comparison."""

SORTS = {metric.removesuffix("@CTC-3"): metric for _, metric in COLUMNS}
"""Values of `--sort`, and the metric that each one selects."""

MAX_STANDINGS = 100_000
"""Maximum number of standings that are read."""

WIDTH, WIDE = 110, 130
"""Minimum width in characters of most tables, and of the table of reproductions."""


@dataclass
class LeaderboardListing:
    """All pages of a split's leaderboard.

    Attributes:
        sort: the metric by which the runs are sorted and ranked.
        standings: the published runs.
        references: the paper's results.
        notices: lines about its closing time and the host's corrections.
    """

    sort: str = ""
    standings: list[pb.Standing] = field(default_factory=list)
    references: list[pb.Reference] = field(default_factory=list)
    notices: list[str] = field(default_factory=list)


def number_up_to(name: str, most: float) -> Callable[[str], float]:
    """Return an argparse type for numbers from 0 to `most`, such as `7e9`.

    Args:
        name: name of the number, for the error message.
        most: largest allowed number.
    """

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = -1.0
        if not 0.0 <= value <= most:
            raise argparse.ArgumentTypeError(f"{text!r} is no {name}; expected a number from 0 to {most:g}")
        return value

    return read


def show(argv: Sequence[str]) -> int:
    """Run `arramon-client leaderboard` and return its exit status."""
    parser = _parser("leaderboard", "Show the ranking of a split's published runs.")
    parser.add_argument("--split", metavar="S", help="the split's name (default: the server's only one)")
    parser.add_argument("--lang", default=BOTH, metavar="L", help="en, hi, ... or both (default: %(default)s)")
    parser.add_argument(
        "--sort", choices=tuple(SORTS), default="PTC", help="metric to sort and rank by (default: %(default)s)"
    )
    parser.add_argument(
        "--smallest-gap",
        type=number_up_to("score", 1),
        metavar="SCORE",
        help="with --lang both: list by the gap between languages, the smallest first, those with this score or more",
    )
    parser.add_argument(
        "--against", metavar="RUN", help="compare a ranked run with each of the others, by paired tests (see --lang)"
    )
    parser.add_argument(
        "--reproductions", metavar="RUN", help="compare a published run with its reproductions by other participants"
    )
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--csv", action="store_true", help="print the list as CSV")
    form.add_argument("--json", action="store_true", help="print the list with all details as JSON")
    return run(parser, argv, _show)


def publish(argv: Sequence[str]) -> int:
    """Run `arramon-client publish` and return its exit status."""
    parser = _parser("publish", "Put a finished run on the leaderboard.")
    parser.add_argument("run", metavar="RUN", help="the run's id")
    parser.add_argument(
        "--note", default="", metavar="TEXT", help="a note shown with the run, one line of at most 500 characters"
    )
    parser.add_argument(
        "--reproduces", metavar="RUN", help="id of another participant's published run that this run reproduces"
    )
    amount = number_up_to("amount", 1e18)
    declared = parser.add_argument_group("cost", "What the run cost. It is shown as declared by you.")
    declared.add_argument(
        "--parameters", type=amount, metavar="N", help="parameters of the agent's models, such as 7e9"
    )
    declared.add_argument(
        "--tokens", type=amount, metavar="N", help="tokens that language models read and wrote in all"
    )
    declared.add_argument("--price", type=amount, metavar="USD", help="price of the whole run in US dollars")
    declared.add_argument(
        "--results",
        type=Path,
        metavar="FILE",
        help="the run's results file: tokens and price that the agent reports in it are declared, unless given above",
    )
    parser.add_argument("--json", action="store_true", help="print what was published as JSON")
    return run(parser, argv, _publish)


def withdraw(argv: Sequence[str]) -> int:
    """Run `arramon-client withdraw` and return its exit status."""
    parser = _parser("withdraw", "Take a run off the leaderboard; it can be published again.")
    parser.add_argument("run", metavar="RUN", help="the run's id")
    parser.add_argument("--json", action="store_true", help="print what was withdrawn as JSON")
    return run(parser, argv, _withdraw)


def _parser(word: str, description: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=f"arramon-client {word}", allow_abbrev=False, description=description)
    add_server(parser)
    return parser


def _show(options: argparse.Namespace) -> None:
    with server_of(options) as server:
        for option in ("against", "reproductions"):
            if getattr(options, option) is not None and (options.csv or options.json):
                raise UsageError(f"--{option} prints a table, and cannot be used together with --csv or --json")
        if options.against is not None:
            _compare(server, options)
            return
        if options.reproductions is not None:
            _show_reproductions(server, options.reproductions)
            return
        split, stub = _choose_split(server, options.split), leaderboard_pb2_grpc.LeaderboardStub(server.channel)
        if options.csv or options.json:
            form = pb.ExportRequest.FORMAT_CSV if options.csv else pb.ExportRequest.FORMAT_JSON
            export = pb.ExportRequest(split=split, language=options.lang, sort=SORTS[options.sort], format=form)
            sys.stdout.write(call(stub.Export, export, server.address).content)
            return
        request = pb.ListRequest(split=split, language=options.lang, sort=SORTS[options.sort])
        listing = _collect(stub, request, server.address)
        notices = [*listing.notices, *host_lines(server.info)]
    if options.smallest_gap is not None:
        if options.lang != BOTH:
            raise UsageError(f"--smallest-gap needs all languages together, but --lang is {options.lang!r}")
        listing.standings = sorted_by_gap(listing, options.smallest_gap)
    shown = console(WIDTH)
    shown.print(table(listing, split, options.lang))
    for notice in notices:
        shown.print(notice, soft_wrap=True)
    if not listing.standings:
        hint = "; each language has a separate list, see --lang" if options.lang == BOTH else ""
        shown.print(f"no published runs yet{hint}", soft_wrap=True)


def sorted_by_gap(listing: LeaderboardListing, least: float) -> list[pb.Standing]:
    """Return the standings with a score of at least `least`, sorted by the gap between languages, smallest first."""
    means = (
        (standing, found.mean)
        for standing in listing.standings
        for row in standing.rows
        for found in row.scores
        if (row.name, found.metric) == (TOTAL, listing.sort)
    )
    return sorted(
        (standing for standing, mean in means if standing.HasField("gap") and mean >= least),
        key=lambda standing: standing.gap.mean,
    )


def _compare(server: Server, options: argparse.Namespace) -> None:
    request = pb.CompareRequest(run_id=options.against, language=options.lang, sort=SORTS[options.sort])
    stub = leaderboard_pb2_grpc.LeaderboardStub(server.channel)
    console(WIDTH).print(differences(call(stub.Compare, request, server.address), options.sort))


def _show_reproductions(server: Server, run_id: str) -> None:
    stub = leaderboard_pb2_grpc.LeaderboardStub(server.channel)
    console(WIDE).print(reproductions(call(stub.GetEntry, pb.GetEntryRequest(run_id=run_id), server.address)))


def reproductions(entry: pb.Entry) -> Table:
    """Return the table of differences between a run and its reproductions."""
    made = Table(
        title=Text(f"{entry.run.agent} by {entry.run.participant}: reproduced by {entry.reproduced_by}"),
        caption="difference: the reproduction minus the original in both turns, over the same episodes, with its 95% "
        "interval",
        box=box.SIMPLE_HEAD,
        padding=0,
        show_edge=False,
        pad_edge=False,
    )
    made.add_column("reproduction", overflow="fold", min_width=24)
    for heading, _ in COLUMNS:
        made.add_column(heading, justify="right", no_wrap=True)
    for one in entry.reproductions:
        by_metric = {score.metric: score for score in one.differences}
        cells = [_difference(by_metric.get(metric)) for _, metric in COLUMNS]
        made.add_row(Text(f"{one.run.participant}\n{one.run.run_id}"), *cells)
    return made


def _difference(score: evaluation_pb2.Score | None) -> str:
    return "-" if score is None else f"{score.mean:+.3f}\n{score.low:+.3f}..{score.high:+.3f}"


def _ranked_table(title: TextType, caption: str) -> Table:
    """Return an empty table whose first columns are rank and agent."""
    made = Table(title=title, caption=caption, box=box.SIMPLE_HEAD, padding=0, show_edge=False, pad_edge=False)
    made.add_column("", justify="right", no_wrap=True)
    made.add_column("agent", overflow="fold", min_width=24)
    return made


def differences(found: pb.CompareResponse, metric: str) -> Table:
    """Return the table of differences between a run and each of the others."""
    made = _ranked_table(
        title=Text(f"{found.standing.agent} by {found.standing.participant}, rank {found.standing.rank}: {metric}"),
        caption="difference: this run minus the other, over the same episodes, with its 95% interval; p: of paired "
        "permutation tests, corrected for all pairs of the list; a difference is shown if it is below 0.05",
    )
    for heading in ("difference", "interval", "p"):
        made.add_column(heading, justify="right", no_wrap=True, min_width=12)
    made.add_column("  shown", no_wrap=True)
    for line in found.comparisons:
        made.add_row(
            str(line.other.rank),
            Text(f"{line.other.agent}\n{line.other.participant}"),
            f"{line.difference:+.3f}",
            f"{line.low:+.3f} to {line.high:+.3f}",
            "< 0.001" if line.corrected_p < 0.001 else f"{line.corrected_p:.3f}",
            f"  {SHOWN[line.shown]}",
        )
    return made


def _publish(options: argparse.Namespace) -> None:
    cost = _cost(options)
    with server_of(options) as server:
        stub = leaderboard_pb2_grpc.LeaderboardStub(server.channel)
        request = pb.PublishRequest(run_id=options.run, note=options.note, reproduces=options.reproduces, cost=cost)
        entry = call(stub.Publish, request, server.address)
    marks = _marks(entry.marks, entry.coverage if entry.HasField("coverage") else None)
    if options.json:
        made = MessageToDict(entry, preserving_proto_field_name=True, always_print_fields_with_no_presence=True)
        print_json({"published": made})
        return
    name = f"{entry.run.agent} by {entry.run.participant}"
    sys.stdout.write(f"published: {name} on {entry.run.split}, {entry.run.language}{f'; {marks}' if marks else ''}\n")


def _cost(options: argparse.Namespace) -> pb.Cost | None:
    """Return the declared cost; None if no option declares any.

    Raises:
        UsageError: if `--results` names a file that is not the run's.
    """
    if options.results is not None:
        tokens, price = reported_cost(options.results, options.run)
        options.tokens = tokens if options.tokens is None else options.tokens
        options.price = price if options.price is None else options.price
    if options.parameters is None and options.tokens is None and options.price is None:
        return None
    whole = {name: getattr(options, name) for name in ("parameters", "tokens")}
    numbers = {name: None if value is None else round(value) for name, value in whole.items()}
    return pb.Cost(**numbers, price=options.price)


def _withdraw(options: argparse.Namespace) -> None:
    with server_of(options) as server:
        stub = leaderboard_pb2_grpc.LeaderboardStub(server.channel)
        call(stub.Withdraw, pb.WithdrawRequest(run_id=options.run), server.address)
    if options.json:
        print_json({"withdrawn": options.run})
        return
    sys.stdout.write(f"withdrawn: {options.run}\n")


def _choose_split(server: Server, requested: str | None) -> str:
    names = [split.name for split in server.info.splits]
    if requested is not None:
        return requested
    if len(names) != 1:
        raise UsageError(f"select a split with --split: {', '.join(names)}")
    return names[0]


def _collect(stub: leaderboard_pb2_grpc.LeaderboardStub, request: pb.ListRequest, address: str) -> LeaderboardListing:
    """Request all pages of a list."""
    listing = LeaderboardListing()
    while True:
        page = call(stub.List, request, address)
        listing.sort = page.sort
        listing.standings += page.standings
        listing.references += page.references
        if not request.page_token:
            closing = closing_line(page.closes_at, frozen=page.frozen)
            listing.notices = [*([closing] if closing else []), *correction_lines(page.corrections)]
        if not page.next_page_token:
            return listing
        is_repeated = page.next_page_token == request.page_token
        if not page.standings or is_repeated or len(listing.standings) > MAX_STANDINGS:
            raise ProtocolError(f"the server has pages without end, or more than {MAX_STANDINGS} standings")
        request.page_token = page.next_page_token


def table(listing: LeaderboardListing, split: str, language: str) -> Table:
    """Return the table of published runs and, below a line, the paper's results: totals with 95% intervals."""
    languages = "all languages together" if language == BOTH else language
    made = _ranked_table(
        title=f"{split}, {languages}",
        caption="ranked by the column with *: a rank is one more than the number of runs shown to be better by paired "
        "tests; = shares a rank; under each score its 95% interval; rPOD and PTC count where CTC-3 is 1",
    )
    for heading, metric in COLUMNS:
        made.add_column(f"{heading} *" if metric == listing.sort else heading, justify="right", no_wrap=True)
    for standing in listing.standings:
        rank = f"{standing.rank}{'=' if standing.tied else ''}" if standing.rank else "-"
        made.add_row(rank, _system(standing), *_cells(standing.rows))
    if listing.references:
        made.add_section()
    for reference in listing.references:
        who = Text(f"{reference.short} {reference.name}\npaper, {reference.source}: other data")
        made.add_row("", who, *(cell.partition("\n")[0] for cell in _cells(reference.rows)))
    return made


def _system(standing: pb.Standing) -> Text:
    lines = [standing.agent, f"{standing.participant}: {' '.join(standing.sensors) or 'no sensors'}"]
    marks = _marks(standing.marks, standing.coverage if standing.HasField("coverage") else None)
    if standing.HasField("gap"):
        gap = standing.gap
        lines.append(f"{gap.higher} over {gap.lower}: {gap.mean:+.3f} ({gap.low:+.3f} to {gap.high:+.3f})")
        lines.append(f"same outcome: {gap.same:.0%}")
    if standing.HasField("spread"):
        spread = standing.spread
        lines.append(f"{spread.runs} seeds, deviation {spread.deviation:.3f} ({spread.low:.3f}-{spread.high:.3f})")
    lines += _costs(standing.entries)
    if standing.runs_begun:
        lines.append(f"{standing.runs_published} of {standing.runs_begun} runs published")
    if standing.reproduced_by:
        lines.append(f"reproduced by {standing.reproduced_by}")
    if voided := max((entry.voided for entry in standing.entries), default=0):
        lines.append(f"without {voided} void episodes")
    return Text("\n".join([*lines, marks] if marks else lines))


def _costs(entries: Sequence[pb.Entry]) -> list[str]:
    """Return lines with the measured time per answer, and the cost declared for the first run."""
    steps = sum(entry.run.timed_steps for entry in entries)
    lines = [f"{sum(entry.run.thinking_seconds for entry in entries) / steps:.3g} s an answer"] if steps else []
    cost = entries[0].cost if entries else pb.Cost()
    declared = [f"{value:.3g} {field.name}" for field, value in cost.ListFields()]
    return [*lines, f"declared: {', '.join(declared)}"] if declared else lines


def _marks(marks: Iterable[pb.Mark.ValueType], coverage: float | None) -> str:
    def words() -> Iterator[str]:
        for mark in marks:
            word = pb.Mark.Name(mark).removeprefix("MARK_").lower().replace("_", " ")
            partly = mark == pb.MARK_PARTIAL and coverage is not None
            yield f"{word} ({coverage:.0%})" if partly else word

    return ", ".join(words())


def _cells(rows: Iterable[evaluation_pb2.Row]) -> list[str]:
    total = {score.metric: score for row in rows if row.name == TOTAL for score in row.scores}
    return [score_cell(total.get(metric)) for _, metric in COLUMNS]
