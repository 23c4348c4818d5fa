"""Every door of a real server shows the same few digits of a hidden split: gRPC, pages, downloads, receipts."""

import csv
import io
import json
import re
import urllib.error
import urllib.request
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import grpc
import pytest
from google.protobuf.message import Message

from arramon.v1 import evaluation_pb2 as ev
from arramon.v1 import leaderboard_pb2 as lb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon.v1.leaderboard_pb2_grpc import LeaderboardStub
from arramon_server.board.corrector import Corrector
from arramon_server.episodes.splits import read_splits
from arramon_server.runs.results.reports import make_report, score_array
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.scoring.disclosure import rounding_step
from arramon_server.scoring.masking import Noise, masked_rows
from tests import tiny
from tests.api.player import Player, create
from tests.serving import METADATA, Server

EPISODES, PLAYED, SPLIT = 47, 48, "guarded"
"""Numbers of episodes that count, and that are played: the host voids one after all runs were published. The first is a
prime number, and so is that of the episodes in Hindi: no exact mean looks like a rounded one, but for 0 and 1."""

VOID = "1"
"""Id of the void episode."""

DECIMALS = 4
"""Of every number between -1 and 1 that a door shows."""

TIMES = re.compile("seconds|second", re.IGNORECASE)
"""Names of numbers that are no scores: times, to two digits where others see them, and their quotients."""


@dataclass(frozen=True)
class Doors:
    """A server with runs on a hidden split.

    Attributes:
        stub, board: of a caller without a token.
        web: address of the pages.
        runs: ids of the published runs; the first two differ in their seed, the next is the same agent in Hindi, the
            last one forfeited most episodes.
        stale: means of each run without the void episode, by row and metric, with the thresholds from before.
        exact: exact means as a reader would see them, with three and four decimals, before and after.
    """

    stub: EvaluationStub
    board: LeaderboardStub
    web: str
    runs: list[str]
    stale: list[dict[str, dict[str, float]]]
    exact: frozenset[str]


@pytest.fixture(scope="module")
def doors(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Doors]:
    data = tmp_path_factory.mktemp("data")
    tiny.write(data, SPLIT, PLAYED, hidden=True)
    server = Server(data, "127.0.0.1:0", "--steps", "8", "--web", "127.0.0.1:0")
    (web,) = (line.split()[-1] for line in server.said if line.startswith("pages at "))
    with grpc.insecure_channel(server.address) as channel:
        stub, board = EvaluationStub(channel), LeaderboardStub(channel)
        runs = [
            played(stub, 29, "en", "1"),
            played(stub, 23, "en", "2"),
            played(stub, 13, "hi", "1"),
            played(stub, 17, "en", "1", agent="probe"),
            played(stub, 5, "en", "1", agent="forfeits", forfeits=True),
        ]
        for run_id in runs:
            board.Publish(lb.PublishRequest(run_id=run_id), metadata=METADATA)
        void(data)
        yield Doors(stub, board, web, runs, stale_means(data, runs), exact_means(data, runs))
    assert server.stop() == 0


def played(
    stub: EvaluationStub, solved: int, language: str, seed: str, *, agent: str = "walker", forfeits: bool = False
) -> str:
    """Play a run that follows the ground truth in some episodes, and forfeits the others or stops at once."""
    argument = ev.AgentArgument(name="seed", value=seed)
    run = create(stub, split=SPLIT, language=language, agent=agent, agent_arguments=[argument])
    order: dict[str, int] = {}
    with Player(stub, run.run_id, PLAYED) as player:
        while (event := player.next()).WhichOneof("event") != "run_ended":
            if event.WhichOneof("event") != "observation":
                continue
            seen = event.observation
            at = order.setdefault(seen.episode_id, len(order))
            if at >= solved and forfeits:
                player.send([ev.Act(episode_id=seen.episode_id, forfeit=ev.Forfeit())])
            else:
                actions = tiny.ACTIONS if at < solved else (tiny.P,)
                player.act(seen.episode_id, seen.step, int(actions[seen.step % len(actions)]))
    return run.run_id


def void(data: Path) -> None:
    """Void an episode, as `arramon-server void` does beside the server."""
    with closing(Database(f"sqlite:///{data / 'journal.db'}")) as database:
        corrector = Corrector(database, read_splits(data), SigningKey(data / "signing-key.pem"))
        corrector.void(SPLIT, [VOID], "a wall in the way")


def stale_means(data: Path, runs: list[str]) -> list[dict[str, dict[str, float]]]:
    (split,) = read_splits(data).values()
    found = []
    with closing(Database(f"sqlite:///{data / 'journal.db'}")) as database:
        journal = Journal(database)
        for run_id in runs:
            kept = [ending for ending in journal.endings(run_id) if ending.episode_id != VOID]
            play = journal.play_digest(journal.run(run_id))
            rows = masked_rows(score_array(kept), Noise(split.truth_hash), play)
            found.append({row: {metric: one.mean for metric, one in rows[row].items()} for row in rows})
    return found


def exact_means(data: Path, runs: list[str]) -> frozenset[str]:
    (split,) = read_splits(data).values()
    found = set()
    with closing(Database(f"sqlite:///{data / 'journal.db'}")) as database:
        journal = Journal(database)
        for run_id in runs:
            endings = journal.endings(run_id)
            for voided in (frozenset[str](), frozenset([VOID])):
                run, progress = journal.run(run_id), journal.progress(run_id)
                report = make_report(run, progress, endings, split, "", voided, exact=True)
                found |= {value.mean for metrics in report.table.rows.values() for value in metrics.values()}
    grids = [parts / rounding_step(EPISODES) for parts in (4, 6)]  # of the means over two turns and up to three runs
    told = {mean for mean in found if f"{mean:.3f}" not in {f"{round(mean * grid) / grid:.3f}" for grid in grids}}
    assert len(told) > 5
    return frozenset(f"{mean:.{digits}f}" for mean in told for digits in (3, DECIMALS))


def check(doors: Doors, name: str, number: float) -> None:
    """Check a number that a door shows."""
    if TIMES.search(name) or abs(number) > 1.0:
        return
    assert abs(number - round(number, DECIMALS)) < 1e-12, f"{name} is {number}"
    assert f"{abs(number):.{DECIMALS}f}" not in doors.exact, f"{name} is {number}, an exact mean"


def check_message(doors: Doors, name: str, message: Message) -> None:
    for field, value in message.ListFields():
        inner = f"{name}.{field.name}"
        for one in value if field.is_repeated and not isinstance(value, Mapping) else [value]:
            if isinstance(one, Message):
                check_message(doors, inner, one)
            elif isinstance(one, float):
                check(doors, inner, one)


def check_data(doors: Doors, name: str, content: object) -> None:
    if isinstance(content, dict):
        for key, value in content.items():
            check_data(doors, f"{name}.{key}", value)
    elif isinstance(content, list):
        for value in content:
            check_data(doors, name, value)
    elif isinstance(content, float):
        check(doors, name, content)
    elif isinstance(content, str) and content.startswith("{"):
        check_data(doors, name, json.loads(content))


def requests(doors: Doors) -> dict[str, list[Any]]:
    """Return requests of every method that returns what is known of runs; empty for one that returns nothing of it."""
    runs, metrics = doors.runs, ("PTC@CTC-3", "nDTW", "CTC-3")
    lists = [lb.ListRequest(split=SPLIT, language=code, sort=sort) for code in ("en", "hi", "both") for sort in metrics]
    compared = [
        lb.CompareRequest(run_id=run_id, language=code, sort=sort)
        for run_id, code in ((runs[0], "en"), (runs[3], "en"), (runs[0], "both"))
        for sort in metrics
    ]
    exports = [
        lb.ExportRequest(split=SPLIT, language=code, format=form)
        for code in ("en", "both")
        for form in (lb.ExportRequest.FORMAT_CSV, lb.ExportRequest.FORMAT_JSON)
    ]
    return {
        "GetReport": [ev.GetReportRequest(run_id=run_id) for run_id in runs],
        "GetReceipt": [ev.GetReceiptRequest(run_id=run_id, number=number) for run_id in runs for number in (0, 1)],
        "GetBreakdown": [ev.GetBreakdownRequest(run_id=run_id) for run_id in runs],
        "GetRun": [ev.GetRunRequest(run_id=run_id) for run_id in runs],
        "ListRuns": [ev.ListRunsRequest()],
        "ListNotes": [ev.ListNotesRequest(run_id=run_id) for run_id in runs],
        "GetServerInfo": [ev.GetServerInfoRequest()],
        "GetAccount": [ev.GetAccountRequest()],
        "Publish": [lb.PublishRequest(run_id=run_id) for run_id in runs],
        "List": lists,
        "GetEntry": [lb.GetEntryRequest(run_id=run_id) for run_id in runs],
        "Compare": compared,
        "Export": exports,
        "ListEpochs": [lb.ListEpochsRequest()],
        "ListEpisodes": [],
        **{name: [] for name in ("CreateRun", "CancelRun", "Play", "Withdraw", "GetActions", "CompareEpochs")},
    }


def test_no_call_shows_more_digits_than_the_split_allows(doors: Doors) -> None:
    requests_by_door = requests(doors)
    services = [ev.DESCRIPTOR.services_by_name["Evaluation"], lb.DESCRIPTOR.services_by_name["Leaderboard"]]
    assert set(requests_by_door) == {
        name for service in services for name in service.methods_by_name
    }  # a new one belongs here
    shown = 0
    for service, stub in zip(services, (doors.stub, doors.board), strict=True):
        for name in service.methods_by_name:
            for request in requests_by_door[name]:
                answer = getattr(stub, name)(request, metadata=METADATA)
                check_message(doors, name, answer)
                shown += answer.ByteSize()
                if name == "GetReceipt":
                    check_data(doors, name, json.loads(answer.payload))
                elif name == "Export" and request.format == lb.ExportRequest.FORMAT_JSON:
                    check_data(doors, name, json.loads(answer.content))
                elif name == "Export":
                    for line in csv.DictReader(io.StringIO(answer.content, newline="")):
                        for column, cell in line.items():
                            if re.fullmatch(r"-?\d+\.\d+", cell):
                                check(doors, column, float(cell))
    assert shown > 10_000


def test_no_page_or_download_shows_more_digits_than_the_split_allows(doors: Doors) -> None:
    """All pages that are linked from the standings, in both languages of the pages."""
    waiting = [f"/{code}/?split={SPLIT}&language={spoken}" for code in ("en", "hi") for spoken in ("en", "hi", "both")]
    seen = set(waiting)
    kinds = set()
    while waiting:
        path = waiting.pop()
        try:
            with urllib.request.urlopen(doors.web + path, timeout=120) as answer:
                text, kind = answer.read().decode(), answer.headers.get_content_type()
        except urllib.error.HTTPError as error:
            if error.code != 404:
                raise
            continue
        kinds.add(kind)
        if kind == "application/json":
            check_data(doors, path, json.loads(text))
        elif kind == "text/html":
            # Seconds per step are measured: by chance, one may have the digits of an exact mean.
            untimed = re.sub(r'(?s)<caption id="costs">.*?</table>|\d\.\d+ (?:s|सेकंड)(?!\w)', "", text)
            assert [number for number in re.findall(r"\d\.\d{3,}", untimed) if number in doors.exact] == [], path
            assert re.findall(r"(?<![\d.])[01]\.[1-9]\d{4,}", text) == [], path  # times of a step are less
            for link in re.findall(r'href="(/[^"#]*)', text):
                there = link.replace("&amp;", "&")
                if there not in seen and len(seen) < 400 and not there.startswith("/static"):
                    seen.add(there)
                    waiting.append(there)
    assert {"text/html", "application/json", "text/csv"} <= kinds
    assert any("/against" in path for path in seen)
    assert sum(path.endswith("receipt.json") for path in seen) == len(doors.runs)


def test_no_episode_can_be_watched(doors: Doors) -> None:
    """Neither on the machine of the server, where runs without an account are listed, nor by guessing addresses."""
    for run_id in doors.runs:
        here = f"runs/{run_id}/episodes/3"
        for path in (
            f"/en/{here}", f"/hi/{here}?step=0", f"/en/{here}/moments.json", f"/en/{here}/moments.json?from=1",
            f"/{here}/frames/0.jpg", f"/{here}/frames/1.jpg?kind=depth", f"/{here}/frames/1.jpg?kind=segmentation",
            f"/en/runs/{run_id}/failures",
        ):  # fmt: skip
            with pytest.raises(urllib.error.HTTPError) as refused:
                urllib.request.urlopen(doors.web + path, timeout=120)
            with refused.value as answer:
                assert (answer.code, b"There is no such page" in answer.read() or path.startswith("/hi")) == (404, True)
    with urllib.request.urlopen(f"{doors.web}/en/watch", timeout=120) as answer:
        listed = answer.read().decode()
    assert not [run_id for run_id in doors.runs if run_id in listed]


def test_all_doors_show_the_same_figures(doors: Doors) -> None:
    for run_id in doors.runs:
        report = doors.stub.GetReport(ev.GetReportRequest(run_id=run_id), metadata=METADATA)
        entry = doors.board.GetEntry(lb.GetEntryRequest(run_id=run_id), metadata=METADATA)
        assert list(report.rows) == list(entry.rows)
        receipt = json.loads(doors.stub.GetReceipt(ev.GetReceiptRequest(run_id=run_id), metadata=METADATA).payload)
        shown = {
            row.name: {one.metric: {"mean": one.mean, "low": one.low, "high": one.high} for one in row.scores}
            for row in report.rows
        }
        assert receipt["scores"] == shown
        groups = doors.stub.GetBreakdown(ev.GetBreakdownRequest(run_id=run_id), metadata=METADATA).groups
        turns = {group.name: group for group in groups if group.aspect == "turn"}
        for name, row in (("first", "turn 1"), ("second", "turn 2")):
            for score in turns[name].scores:
                found = shown[row][score.metric]
                assert (score.mean, score.low, score.high) == (found["mean"], found["low"], found["high"])


def test_void_episode_is_in_no_figure_and_its_thresholds_are_fresh(doors: Doors) -> None:
    for run_id, stale in zip(doors.runs, doors.stale, strict=True):
        receipt = json.loads(doors.stub.GetReceipt(ev.GetReceiptRequest(run_id=run_id), metadata=METADATA).payload)
        entry = doors.board.GetEntry(lb.GetEntryRequest(run_id=run_id), metadata=METADATA)
        assert (entry.voided, [list(one.episodes) for one in entry.corrections]) == (1, [[VOID]])
        assert len(entry.superseded) == 1
        assert (receipt["version"], receipt["voided"], receipt["revision"]["number"]) == (2, [VOID], 1)
        assert all(set(one) == {"episode_id", "head", "ending"} for one in receipt["episodes"])
        assert {row.name: {one.metric: one.mean for one in row.scores} for row in entry.rows} != stale


def test_others_see_steps_and_times_to_two_digits(doors: Doors) -> None:
    own = doors.stub.GetRun(ev.GetRunRequest(run_id=doors.runs[0]), metadata=METADATA)
    entry = doors.board.GetEntry(lb.GetEntryRequest(run_id=doors.runs[0]), metadata=METADATA)
    breakdown = doors.stub.GetBreakdown(ev.GetBreakdownRequest(run_id=doors.runs[0]), metadata=METADATA)
    assert own.steps > 100
    for run in (entry.run, breakdown.run):
        assert run.steps == int(float(f"{own.steps:.1e}")) != own.steps
        assert run.thinking_seconds == float(f"{run.thinking_seconds:.1e}")


def test_run_that_mostly_forfeited_is_ranked_nowhere(doors: Doors) -> None:
    entry = doors.board.GetEntry(lb.GetEntryRequest(run_id=doors.runs[-1]), metadata=METADATA)
    assert list(entry.marks) == [lb.MARK_FORFEITED]
    for code in ("en", "both"):
        listed = doors.board.List(lb.ListRequest(split=SPLIT, language=code), metadata=METADATA).standings
        assert [line.rank for line in listed if line.agent == "forfeits"] == [0] * (code == "en")
