"""The commands `leaderboard`, `publish` and `withdraw`, against a scripted server."""

# ruff: noqa: N802 - the methods are named by the protocol

import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import grpc
import pytest

from arramon.v1 import evaluation_pb2
from arramon.v1 import leaderboard_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import add_EvaluationServicer_to_server
from arramon.v1.leaderboard_pb2_grpc import LeaderboardServicer, add_LeaderboardServicer_to_server
from arramon_client.cli import main
from tests.client.fake import Servicer, World

METRICS = ("nDTW", "CTC-0", "CTC-3", "CTC-5", "CTC-7", "rPOD@CTC-3", "PTC@CTC-3")


def rows(*totals: float) -> list[evaluation_pb2.Row]:
    scores = [
        evaluation_pb2.Score(metric=metric, mean=value, low=value - 0.05, high=value + 0.05)
        for metric, value in zip(METRICS, totals, strict=True)
    ]
    return [evaluation_pb2.Row(name="total", scores=scores)]


BEST = pb.Standing(
    rank=1, tied=True, participant="lab", agent="[red]mine[/red]", sensors=["rgb", "depth"], coverage=1.0,
    rows=rows(0.9, 0.8, 0.7, 0.75, 0.8, 0.5, 0.4), runs_begun=7, runs_published=1,
)  # fmt: skip
OTHER = pb.Standing(rank=1, tied=True, participant="club", agent="other", coverage=1.0, rows=rows(*[0.3] * 7))
PART = pb.Standing(
    participant="lab", agent="part", sensors=["oracle"], coverage=0.25, marks=[pb.MARK_PARTIAL, pb.MARK_PRIVILEGED],
    rows=rows(*[1.0] * 7),
)  # fmt: skip
PAPER = pb.Reference(
    name="Shortest Path", short="S/P", split="val_seen", language="en", source="Table 2",
    rows=[evaluation_pb2.Row(name="total", scores=[evaluation_pb2.Score(metric="nDTW", mean=1.0, low=1.0, high=1.0)])],
)  # fmt: skip


class Board(LeaderboardServicer):
    """Leaderboard with three standings, one per page, that records its requests."""

    def __init__(self) -> None:
        self.asked: list[Any] = []
        self.lines = [BEST, OTHER, PART]
        self.first = pb.ListResponse()

    def List(self, request: pb.ListRequest, context: Any) -> pb.ListResponse:
        self.asked.append(request)
        at = int(request.page_token or 0)
        return pb.ListResponse(
            standings=self.lines[at : at + 1],
            references=[PAPER] if at == 0 else [],
            sort=request.sort,
            next_page_token=str(at + 1) if at + 1 < len(self.lines) else "",
            closes_at=self.first.closes_at,
            frozen=self.first.frozen,
            corrections=self.first.corrections if at == 0 else [],
        )

    def Compare(self, request: pb.CompareRequest, context: Any) -> pb.CompareResponse:
        self.asked.append(request)
        lines = [
            pb.Comparison(other=OTHER, difference=0.6, low=0.55, high=0.65, p=1e-9, corrected_p=1e-7, shown=1),
            pb.Comparison(other=PART, difference=-0.1, low=-0.2, high=0.01, p=0.06, corrected_p=0.12, shown=0),
        ]
        return pb.CompareResponse(standing=BEST, comparisons=lines, sort=request.sort)

    def Export(self, request: pb.ExportRequest, context: Any) -> pb.ExportResponse:
        self.asked.append(request)
        return pb.ExportResponse(content="kind,agent\r\nrun,मेरा\r\n")

    def Publish(self, request: pb.PublishRequest, context: Any) -> pb.Entry:
        self.asked.append(request)
        if request.run_id == "running":
            context.abort(grpc.StatusCode.FAILED_PRECONDITION, "run 'running' is still being played")
        run = evaluation_pb2.Run(agent="mine", participant="lab", split="val_seen", language="hi")
        return pb.Entry(run=run, coverage=0.25, marks=[pb.MARK_PARTIAL])

    def Withdraw(self, request: pb.WithdrawRequest, context: Any) -> pb.WithdrawResponse:
        self.asked.append(request)
        return pb.WithdrawResponse()

    def GetEntry(self, request: pb.GetEntryRequest, context: Any) -> pb.Entry:
        return pb.Entry()

    def GetActions(self, request: pb.GetActionsRequest, context: Any) -> pb.Actions:
        return pb.Actions()

    def ListEpochs(self, request: pb.ListEpochsRequest, context: Any) -> pb.ListEpochsResponse:
        return pb.ListEpochsResponse()

    def CompareEpochs(self, request: pb.CompareEpochsRequest, context: Any) -> pb.CompareEpochsResponse:
        return pb.CompareEpochsResponse()


@contextmanager
def serving(world: World, board: Board) -> Iterator[str]:
    with ThreadPoolExecutor(2) as pool:
        server = grpc.server(pool)
        add_EvaluationServicer_to_server(Servicer(world), server)
        add_LeaderboardServicer_to_server(board, server)
        port = server.add_insecure_port("127.0.0.1:0")
        server.start()
        yield f"127.0.0.1:{port}"
        server.stop(None).wait()


@pytest.fixture
def board() -> Board:
    return Board()


@pytest.fixture
def address(world: World, board: Board) -> Iterator[str]:
    with serving(world, board) as served:
        yield served


def test_leaderboard_table_shows_ranks_scores_and_marks(
    board: Board, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["leaderboard", "--server", address, "--lang", "en"]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    best = next(n for n, line in enumerate(lines) if line[:1] == ["1="])
    assert lines[best] == ["1=", "[red]mine[/red]", "0.900", "0.800", "0.700", "0.750", "0.800", "0.500", "0.400"]
    assert lines[best + 1][:3] == ["lab:", "rgb", "depth"]
    assert lines[best + 1][3:6] == [".850-.950", ".750-.850", ".650-.750"]
    assert lines[best + 2] == ["1", "of", "7", "runs", "published"]
    assert ["1=", "other", *["0.300"] * 7] in lines
    assert ["-", "part", *["1.000"] * 7] in lines
    assert ["partial", "(25%),", "privileged"] in lines
    assert ["S/P", "Shortest", "Path", "1.000", *["-"] * 6] in lines
    assert ["paper,", "Table", "2:", "other", "data"] in lines
    assert [request.page_token for request in board.asked] == ["", "1", "2"]
    assert {(request.split, request.language, request.sort) for request in board.asked} == {
        ("val_seen", "en", "PTC@CTC-3"),
    }  # fmt: skip


def test_the_column_sorted_by_is_marked(board: Board, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["leaderboard", "--server", address, "--sort", "rPOD", "--split", "val_unseen"]) == 0
    assert {(request.split, request.language, request.sort) for request in board.asked} == {
        ("val_unseen", "both", "rPOD@CTC-3"),
    }  # fmt: skip
    shown = capsys.readouterr().out
    assert "rPOD *" in shown
    assert "val_unseen, all languages together" in shown


def test_a_run_against_the_others(board: Board, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["leaderboard", "--server", address, "--against", "r1", "--lang", "hi", "--sort", "nDTW"]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["1", "other", "+0.600", "+0.550", "to", "+0.650", "<", "0.001", "better"] in lines
    assert ["0", "part", "-0.100", "-0.200", "to", "+0.010", "0.120", "no", "difference"] in lines
    (request,) = board.asked
    assert (request.run_id, request.language, request.sort) == ("r1", "hi", "nDTW")
    assert main(["leaderboard", "--server", address, "--against", "r1", "--csv"]) == 2


def test_costs_and_seeds_are_shown(board: Board, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    runs = [evaluation_pb2.Run(thinking_seconds=3.0, timed_steps=10), evaluation_pb2.Run()]
    entries = [pb.Entry(run=run, cost=pb.Cost(parameters=7_000_000_000, price=0.0)) for run in runs]
    spread = pb.SeedSpread(runs=2, deviation=0.0125, low=0.25, high=0.75)
    board.lines = [pb.Standing(agent="mine", participant="lab", entries=entries, spread=spread, rows=rows(*[0.5] * 7))]
    assert main(["leaderboard", "--server", address, "--lang", "en"]) == 0
    lines = [line.strip() for line in capsys.readouterr().out.splitlines()]
    assert "2 seeds, deviation 0.013 (0.250-0.750)" in " ".join(lines)
    assert "0.3 s an answer" in lines
    assert "declared: 7e+09 parameters, 0 price" in " ".join(lines)


@pytest.mark.parametrize("typed", ["-1", "much", "nan", "1e19"])
def test_amounts_are_numbers(address: str, capsys: pytest.CaptureFixture[str], typed: str) -> None:
    assert main(["publish", "r1", "--server", address, f"--price={typed}"]) == 2
    assert f"'{typed}' is no amount; expected a number from 0 to 1e+18" in capsys.readouterr().err


def test_declared_cost_is_sent(board: Board, address: str) -> None:
    assert main(["publish", "r1", "--server", address, "--parameters", "7e9", "--price", "0.5"]) == 0
    assert board.asked == [pb.PublishRequest(run_id="r1", cost=pb.Cost(parameters=7_000_000_000, price=0.5))]


def test_the_cost_that_the_agent_reported_is_sent(board: Board, address: str, tmp_path: Path) -> None:
    """What is given by hand takes precedence."""
    results = tmp_path / "r1.json"
    content = {"measured": {"tokens": {"total": 1234}}, "declared": {"price_usd": 0.25}}
    results.write_text(json.dumps({"run": {"run_id": "r1"}, "agent_report": content}))
    assert main(["publish", "r1", "--server", address, "--results", str(results)]) == 0
    assert main(["publish", "r1", "--server", address, "--results", str(results), "--price", "0.5"]) == 0
    assert [asked.cost for asked in board.asked] == [pb.Cost(tokens=1234, price=0.25), pb.Cost(tokens=1234, price=0.5)]
    assert main(["publish", "r2", "--server", address, "--results", str(results)]) == 2


def test_the_smallest_gap(board: Board, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    def line(agent: str, total: float, gap: float) -> pb.Standing:
        found = pb.LanguageGap(higher="en", lower="hi", mean=gap, low=gap - 0.1, high=gap + 0.1, same=0.75)
        return pb.Standing(agent=agent, participant="lab", rows=rows(*[total] * 7), gap=found)

    board.lines = [line("wide", 0.9, 0.3), line("idle", 0.0, 0.0), line("narrow", 0.5, 0.05), OTHER]
    assert main(["leaderboard", "--server", address, "--smallest-gap", "0.3"]) == 0
    shown = capsys.readouterr().out
    assert shown.index("narrow") < shown.index("wide")
    assert ("idle" in shown, "club" in shown) == (False, False)
    assert "en over hi: +0.050 (-0.050 to +0.150)" in shown
    assert "same outcome: 75%" in shown
    assert main(["leaderboard", "--server", address, "--smallest-gap", "0.3", "--lang", "en"]) == 2
    assert main(["leaderboard", "--server", address, "--smallest-gap", "2"]) == 2


def test_empty_leaderboard_is_explained(board: Board, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    board.lines = []
    assert main(["leaderboard", "--server", address]) == 0
    assert "no published runs yet; each language has a separate list, see --lang" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("option", "form"), [("--csv", pb.ExportRequest.FORMAT_CSV), ("--json", pb.ExportRequest.FORMAT_JSON)]
)
def test_exports_are_printed_unchanged(
    board: Board, address: str, capsys: pytest.CaptureFixture[str], option: str, form: int
) -> None:
    assert main(["leaderboard", "--server", address, "--lang", "hi", option]) == 0
    assert capsys.readouterr().out == "kind,agent\r\nrun,मेरा\r\n"
    assert board.asked == [pb.ExportRequest(split="val_seen", language="hi", sort="PTC@CTC-3", format=form)]  # type: ignore[arg-type]


def test_publish_command_publishes_a_run_with_its_note(
    board: Board, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["publish", "r7", "--note", "code: example.org", "--server", address]) == 0
    assert board.asked == [pb.PublishRequest(run_id="r7", note="code: example.org")]
    assert capsys.readouterr().out == "published: mine by lab on val_seen, hi; partial (25%)\n"


def test_refused_publication_is_shown(address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["publish", "running", "--server", address]) == 1
    assert capsys.readouterr().err == "error: run 'running' is still being played (FAILED_PRECONDITION)\n"


def test_withdraw_command_withdraws_a_run(board: Board, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["withdraw", "r7", "--server", address]) == 0
    assert board.asked == [pb.WithdrawRequest(run_id="r7")]
    assert capsys.readouterr().out == "withdrawn: r7\n"


def test_a_split_must_be_selected_if_there_are_several(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    world.info.splits.add(name="val_unseen")
    assert main(["leaderboard", "--server", address]) == 2
    assert capsys.readouterr().err == "error: select a split with --split: val_seen, val_unseen\n"


def test_server_and_data_options_exclude_each_other(address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["leaderboard", "--server", address, "--data", "here"]) == 2
    assert "--data applies to runs on this machine" in capsys.readouterr().err


def test_the_host_what_it_corrected_and_when_it_closes_are_said(
    board: Board, world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    world.info.host.CopyFrom(evaluation_pb2.Host(name="[b]Lab[/b]", contact="mail@example.org"))
    board.first = pb.ListResponse(
        closes_at="2100-01-01T00:00:00+00:00",
        corrections=[
            pb.Correction(
                kind=pb.CORRECTION_KIND_VOID, made_at="2030-01-01", reason="a wall", episodes=[str(n) for n in range(6)]
            ),
            pb.Correction(
                kind=pb.CORRECTION_KIND_RESCORE, made_at="2030-01-02", reason="a cell", episodes=["7"],
                data_before="a" * 64, data_after="b" * 64,
            ),
        ],
    )  # fmt: skip
    board.lines = [pb.Standing(agent="mine", participant="lab", entries=[pb.Entry(voided=2)], rows=rows(*[0.5] * 7))]
    assert main(["leaderboard", "--server", address, "--lang", "en"]) == 0
    lines = [line.strip() for line in capsys.readouterr().out.splitlines()]
    for said in (
        "closes at 2100-01-01T00:00:00+00:00: from then on no runs are created or published",
        "corrected at 2030-01-01: void: 6 episodes (0, 1, 2, 3, 4, ...): a wall",
        "corrected at 2030-01-02: data corrected in 1 episode (7), from aaaaaaaaaaaa to bbbbbbbbbbbb, "
        "and all runs scored again: a cell",
        "host: [b]Lab[/b]",
        "contact: mail@example.org",
        "without 2 void episodes",
    ):
        assert said in lines, said


def test_a_frozen_leaderboard_is_listed_without_scores(
    board: Board, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    board.first = pb.ListResponse(closes_at="2100-01-01T00:00:00+00:00", frozen=True)
    board.lines = [pb.Standing(agent="mine", participant="lab")]
    assert main(["leaderboard", "--server", address, "--lang", "en"]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["-", "mine", *["-"] * 7] in lines
    assert [
        "frozen:",
        "scores",
        "and",
        "ranks",
        "are",
        "shown",
        "when",
        "it",
        "closes,",
        "at",
        "2100-01-01T00:00:00+00:00",
    ] in lines
