"""The Leaderboard over gRPC: publication, listing, withdrawal, permissions, and hidden splits."""

import csv
import hashlib
import io
import json
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import grpc
import pytest
from google.protobuf.message import Message

from arramon.v1 import evaluation_pb2, types_pb2
from arramon.v1 import leaderboard_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon.v1.leaderboard_pb2_grpc import LeaderboardStub
from arramon_server.runs.accounts.callers import Role
from tests import tiny
from tests.api.people import Person, token_of
from tests.api.player import create, played
from tests.api.test_runs import refused
from tests.serving import METADATA, Server

WRONG = [types_pb2.ACTION_INTERACT] * 4
"""Takes nothing, and puts it down at once."""


def publish(board: LeaderboardStub, run_id: str, note: str = "") -> pb.Entry:
    return board.Publish(pb.PublishRequest(run_id=run_id, note=note), metadata=METADATA)


def withdraw(board: LeaderboardStub, run_id: str) -> None:
    board.Withdraw(pb.WithdrawRequest(run_id=run_id), metadata=METADATA)


def listed(board: LeaderboardStub, language: str = "en", split: str = "tiny", **fields: object) -> pb.ListResponse:
    request = pb.ListRequest(split=split, language=language, **fields)  # type: ignore[arg-type]
    return board.List(request, metadata=METADATA)


@pytest.fixture
def published(stub: EvaluationStub, board: LeaderboardStub) -> Iterator[list[str]]:
    """Runs on the leaderboard: a perfect one, one that does everything wrong, and a part of one; off it at the end."""
    runs = [
        played(stub, WRONG, agent="wrong", participant="b").run_id,
        played(stub, agent="perfect", participant="a").run_id,
        played(stub, agent="part", participant="a", episodes=2).run_id,
    ]
    for run_id in runs:
        publish(board, run_id)
    yield runs
    for run_id in runs:
        withdraw(board, run_id)


def test_entry_holds_the_runs_report_and_receipt_digest(stub: EvaluationStub, board: LeaderboardStub) -> None:
    run_id = played(stub, agent="perfect", participant="a", sensors=["rgb"]).run_id
    entry = publish(board, run_id, "with care")
    report = stub.GetReport(evaluation_pb2.GetReportRequest(run_id=run_id), metadata=METADATA)
    assert (entry.run.agent, entry.run.participant, list(entry.run.sensors)) == ("perfect", "a", ["rgb"])
    assert (entry.run.published, entry.run.episodes, dict(entry.run.causes)) == (True, 6, {"AGENT_FINISHED": 6})
    assert list(entry.rows) == list(report.rows)
    assert (entry.signature, entry.note, entry.coverage, list(entry.marks)) == (report.signature, "with care", 1.0, [])
    assert (len(entry.receipt_digest), len(entry.public_key)) == (32, 32)
    assert entry == board.GetEntry(pb.GetEntryRequest(run_id=run_id), metadata=METADATA)
    withdraw(board, run_id)


def test_complete_runs_are_ranked_and_partial_runs_listed_unranked(
    board: LeaderboardStub, published: list[str]
) -> None:
    answer = listed(board)
    lines = [(line.agent, line.rank, line.tied, list(line.marks)) for line in answer.standings]
    assert lines == [
        ("perfect", 1, False, []),
        ("wrong", 2, False, []),
        ("part", 0, False, [pb.MARK_PARTIAL]),
    ]
    assert (answer.sort, answer.total, answer.next_page_token) == ("PTC@CTC-3", 3, "")
    assert [line.coverage for line in answer.standings] == pytest.approx([1.0, 1.0, 1 / 3])
    assert [line.entries[0].run.run_id for line in answer.standings] == [published[1], published[0], published[2]]


def test_runs_of_chosen_episodes_are_marked_partial(stub: EvaluationStub, board: LeaderboardStub) -> None:
    run_id = played(stub, agent="chosen", episode_ids=["4", "1"]).run_id
    entry = publish(board, run_id)
    assert list(entry.marks) == [pb.MARK_PARTIAL]
    assert entry.coverage == pytest.approx(1 / 3)
    assert [line.rank for line in listed(board).standings if line.agent == "chosen"] == [0]
    withdraw(board, run_id)


def test_runs_with_equal_scores_share_a_rank(
    stub: EvaluationStub, board: LeaderboardStub, published: list[str]
) -> None:
    again = played(stub, agent="again").run_id
    publish(board, again)
    lines = [(line.agent, line.rank, line.tied) for line in listed(board).standings]
    # With a third run, six episodes no longer show that the wrong one is worse than both.
    assert lines[:3] == [("perfect", 1, True), ("again", 1, True), ("wrong", 1, True)]
    withdraw(board, again)


def test_a_run_against_the_others(board: LeaderboardStub, published: list[str]) -> None:
    perfect, part = (
        line.entries[0].run.run_id for line in listed(board).standings if line.agent in ("perfect", "part")
    )
    found = board.Compare(pb.CompareRequest(run_id=perfect), metadata=METADATA)
    assert (found.standing.agent, found.standing.rank, found.sort) == ("perfect", 1, "PTC@CTC-3")
    (line,) = found.comparisons
    assert (line.other.agent, line.difference, line.p, line.corrected_p, line.shown) == (
        "wrong",
        1.0,
        2 / 64,
        2 / 64,
        1,
    )
    assert -1.0 <= line.low < line.difference <= line.high
    assert not line.other.rows
    with pytest.raises(grpc.RpcError) as caught:
        board.Compare(pb.CompareRequest(run_id=part), metadata=METADATA)
    assert caught.value.code() == grpc.StatusCode.FAILED_PRECONDITION


def test_standings_are_listed_in_pages(board: LeaderboardStub, published: list[str]) -> None:
    first = listed(board, page_size=2)
    second = listed(board, page_size=2, page_token=first.next_page_token)
    assert [line.agent for line in (*first.standings, *second.standings)] == ["perfect", "wrong", "part"]
    assert (first.total, second.total, second.next_page_token) == (3, 3, "")


@pytest.mark.parametrize(
    ("fields", "code", "message"),
    [
        ({"split": "moon"}, "NOT_FOUND", "there is no split 'moon'; the leaderboard has secret, tiny"),
        ({"split": ""}, "NOT_FOUND", "there is no split ''; the leaderboard has secret, tiny"),
        ({"language": "fr"}, "NOT_FOUND", "split 'tiny' has no language 'fr'; it has en, hi, both"),
        ({"sort": "fame"}, "INVALID_ARGUMENT", "cannot sort by 'fame'; expected one of nDTW, CTC-0, "),
        ({"page_size": 1001}, "INVALID_ARGUMENT", "page_size is 1001, expected 1 to 1000"),
        (
            {"page_token": "-1"},
            "INVALID_ARGUMENT",
            "page_token is '-1', expected the next_page_token of the previous page",
        ),
        ({"page_token": "9" * 5000}, "INVALID_ARGUMENT", "page_token is '99999"),
    ],
)
def test_invalid_list_requests_are_refused(
    board: LeaderboardStub, fields: dict[str, object], code: str, message: str
) -> None:
    found, said = refused(lambda: listed(board, **fields))  # type: ignore[arg-type]
    assert found == grpc.StatusCode[code]
    assert said.startswith(message)
    assert len(said) < 300


def test_combined_standings_average_both_languages(stub: EvaluationStub, board: LeaderboardStub) -> None:
    runs = [played(stub, agent="two").run_id, played(stub, WRONG, agent="two", language="hi").run_id]
    for run_id in runs:
        publish(board, run_id)
    for language in ("both", ""):
        (line,) = listed(board, language).standings
        assert (line.agent, line.rank) == ("two", 1)
        assert [entry.run.language for entry in line.entries] == ["en", "hi"]
        total = {score.metric: score.mean for score in line.rows[2].scores}
        assert total["PTC@CTC-3"] == 0.5
    for run_id in runs:
        withdraw(board, run_id)
    assert not listed(board, "both").standings


def test_seeds_are_one_standing_and_costs_are_declared(stub: EvaluationStub, board: LeaderboardStub) -> None:
    runs = []
    for seed, actions in (("1", tiny.ACTIONS), ("2", WRONG)):
        arguments = [evaluation_pb2.AgentArgument(name="seed", value=seed)]
        runs.append(played(stub, actions, agent="seeded", agent_arguments=arguments).run_id)
        request = pb.PublishRequest(run_id=runs[-1], cost=pb.Cost(parameters=30_000_000, price=1.5))
        entry = board.Publish(request, metadata=METADATA)
        assert (entry.cost.parameters, entry.cost.price, entry.cost.HasField("tokens")) == (30_000_000, 1.5, False)
        assert entry.run.timed_steps == entry.run.steps > 0
        assert entry.run.thinking_seconds > 0.0
    (line,) = [one for one in listed(board).standings if one.agent == "seeded"]
    assert [one.run.run_id for one in line.entries] == runs
    assert (line.spread.runs, line.spread.high) == (2, 1.0)
    total = {score.metric: score.mean for score in line.rows[2].scores}
    assert total["PTC@CTC-3"] == 0.5
    too_much = pb.PublishRequest(run_id=runs[0], cost=pb.Cost(price=-1.0))
    assert refused(lambda: board.Publish(too_much, metadata=METADATA)) == (
        grpc.StatusCode.INVALID_ARGUMENT,
        "the declared price is -1.0; expected a number from 0 to 1e+18",
    )
    for run_id in runs:
        withdraw(board, run_id)


def test_withdrawn_runs_disappear_and_can_be_republished(stub: EvaluationStub, board: LeaderboardStub) -> None:
    run_id = played(stub, agent="shy").run_id
    publish(board, run_id)
    withdraw(board, run_id)
    assert not listed(board).standings
    gone = refused(lambda: board.GetEntry(pb.GetEntryRequest(run_id=run_id), metadata=METADATA))
    assert gone == (grpc.StatusCode.NOT_FOUND, f"there is no run '{run_id}' on the leaderboard")
    assert refused(lambda: withdraw(board, run_id)) == (
        grpc.StatusCode.NOT_FOUND, f"run '{run_id}' is not on the leaderboard",
    )  # fmt: skip
    publish(board, run_id)
    assert [line.agent for line in listed(board).standings] == ["shy"]
    withdraw(board, run_id)


def test_invalid_publications_are_refused(stub: EvaluationStub, board: LeaderboardStub) -> None:
    running = create(stub).run_id
    for run_id, code, message in (
        ("x", "NOT_FOUND", "there is no run 'x'"),
        (running, "FAILED_PRECONDITION", f"run '{running}' is still being played: 0 of 6 episodes have ended"),
    ):
        assert refused(lambda run_id=run_id: publish(board, run_id)) == (grpc.StatusCode[code], message)
    assert refused(lambda: publish(board, running, "x" * 501)) == (
        grpc.StatusCode.INVALID_ARGUMENT, "the note has 501 characters; at most 500 are allowed",
    )  # fmt: skip


def test_hidden_split_entries_reveal_no_single_episodes(stub: EvaluationStub, board: LeaderboardStub) -> None:
    run_id = played(stub, split="secret", agent="perfect").run_id
    entry = publish(board, run_id)
    other = played(stub, WRONG, split="secret", agent="wrong").run_id
    publish(board, other)
    answer = listed(board, split="secret")
    against = board.Compare(pb.CompareRequest(run_id=run_id), metadata=METADATA)
    assert len(against.comparisons) == 1
    exports = [
        board.Export(pb.ExportRequest(split="secret", language="en", format=form), metadata=METADATA)
        for form in (pb.ExportRequest.FORMAT_CSV, pb.ExportRequest.FORMAT_JSON)
    ]
    kinds = {kind for message in (entry, answer, against, *exports) for kind in inside(message)}
    assert kinds == {
        "Comparison",
        "CompareResponse",
        "Entry",
        "ExportResponse",
        "Limits",
        "ListResponse",
        "Row",
        "Run",
        "Score",
        "Standing",
    }
    assert {row.name for row in entry.rows} == {"turn 1", "turn 2", "total"}
    document = json.loads(exports[1].content)
    assert set(document["standings"][0]["rows"]) == {"turn 1", "turn 2", "total"}
    assert b"episode_id" not in b"".join(message.SerializeToString() for message in (entry, answer, against, *exports))
    withdraw(board, run_id)
    withdraw(board, other)


def inside(message: Message) -> Iterator[str]:
    """The names of all messages in a message, its own too."""
    yield message.DESCRIPTOR.name
    for field, value in message.ListFields():
        if field.message_type is not None and not field.message_type.GetOptions().map_entry:
            for one in value if field.is_repeated else [value]:
                yield from inside(one)


def test_standings_are_exported_as_csv_and_json(board: LeaderboardStub, published: list[str]) -> None:
    def export(form: pb.ExportRequest.Format.ValueType) -> str:
        request = pb.ExportRequest(split="tiny", language="en", format=form)
        return board.Export(request, metadata=METADATA).content

    lines = list(csv.DictReader(io.StringIO(export(pb.ExportRequest.FORMAT_CSV), newline="")))
    document = json.loads(export(pb.ExportRequest.FORMAT_JSON))
    assert [line["agent"] for line in lines] == ["perfect", "wrong", "part"]
    assert [line["agent"] for line in document["standings"]] == ["perfect", "wrong", "part"]
    assert refused(lambda: export(pb.ExportRequest.FORMAT_UNSPECIFIED)) == (
        grpc.StatusCode.INVALID_ARGUMENT,
        "the export has no format; expected FORMAT_CSV or FORMAT_JSON",
    )


def test_runs_and_reports_show_whether_they_are_published(stub: EvaluationStub, board: LeaderboardStub) -> None:
    run_id = played(stub).run_id

    def states() -> list[bool]:
        run = stub.GetRun(evaluation_pb2.GetRunRequest(run_id=run_id), metadata=METADATA)
        runs = stub.ListRuns(evaluation_pb2.ListRunsRequest(page_size=1), metadata=METADATA).runs
        report = stub.GetReport(evaluation_pb2.GetReportRequest(run_id=run_id), metadata=METADATA)
        return [run.published, runs[0].published, report.run.published]

    assert states() == [False] * 3
    publish(board, run_id)
    assert states() == [True] * 3
    withdraw(board, run_id)
    assert states() == [False] * 3


def test_only_owner_and_host_publish_and_withdraw_with_accounts(closed: Server) -> None:
    tokens = {"ann": token_of(closed.data, "ann"), "bob": token_of(closed.data, "bob"), "nobody": ""}
    tokens["chair"] = token_of(closed.data, "chair", Role.HOST)
    with ExitStack() as stack:
        people = {name: stack.enter_context(Person(closed.address, token)) for name, token in tokens.items()}
        boards = {name: person.board for name, person in people.items()}
        run_id = played(people["ann"].stub, agent="walker").run_id

        def answer(name: str, call: Callable[[LeaderboardStub, str], object]) -> str:
            try:
                call(boards[name], run_id)
            except grpc.RpcError as error:
                return error.code().name
            return "fine"

        def lists() -> list[list[str]]:
            """What everybody sees, in the order of names."""
            return [[line.agent for line in listed(boards[name]).standings] for name in sorted(boards)]

        for name, call, said, shown in (
            ("nobody", publish, "UNAUTHENTICATED", []),
            ("bob", publish, "NOT_FOUND", []),
            ("ann", publish, "fine", ["walker"]),
            ("nobody", withdraw, "UNAUTHENTICATED", ["walker"]),
            ("bob", withdraw, "NOT_FOUND", ["walker"]),
            ("ann", withdraw, "fine", []),
            ("chair", publish, "fine", ["walker"]),
            ("chair", withdraw, "fine", []),
            ("ann", publish, "PERMISSION_DENIED", []),
            ("chair", publish, "fine", ["walker"]),
        ):
            assert (name, answer(name, call), lists()) == (name, said, [shown] * 4)
        entry = boards["nobody"].GetEntry(pb.GetEntryRequest(run_id=run_id), metadata=METADATA)
        assert (entry.run.participant, entry.run.agent) == ("ann", "walker")
        report = evaluation_pb2.GetReportRequest(run_id=run_id)
        for name, code in (("nobody", "UNAUTHENTICATED"), ("bob", "NOT_FOUND")):
            assert refused(lambda name=name: people[name].stub.GetReport(report, metadata=METADATA))[0].name == code
        receipt = people["bob"].stub.GetReceipt(evaluation_pb2.GetReceiptRequest(run_id=run_id), metadata=METADATA)
        assert hashlib.sha256(receipt.payload).digest() == entry.receipt_digest
        assert receipt.public_key == entry.public_key


def test_anonymous_callers_cannot_publish_on_a_public_server(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path, "127.0.0.1:0", "--steps", "8", "--anonymous", "--trust-proxy")
    with grpc.insecure_channel(server.address) as channel:
        run_id = played(EvaluationStub(channel)).run_id
        board = LeaderboardStub(channel)
        for call in (publish, withdraw):
            assert refused(lambda call=call: call(board, run_id)) == (
                grpc.StatusCode.PERMISSION_DENIED,
                "authentication required: publishing and withdrawing need a token on this server; ask its host for one",
            )
    assert server.stop() == 0


@contextmanager
def served(data: Path, step_seconds: int) -> Iterator[grpc.Channel]:
    server = Server(data, "127.0.0.1:0", "--steps", "8", "--step-seconds", str(step_seconds))
    with grpc.insecure_channel(server.address) as channel:
        yield channel
    assert server.stop() == 0


def standings(board: LeaderboardStub) -> list[tuple[str, int, list[int], str]]:
    """Agent, rank, marks, and the marks in the file to download."""
    form = pb.ExportRequest.FORMAT_CSV
    text = board.Export(pb.ExportRequest(split="tiny", language="en", format=form), metadata=METADATA).content
    lines = zip(listed(board).standings, csv.DictReader(io.StringIO(text, newline="")), strict=True)
    return [(line.agent, line.rank, list(line.marks), cells["marks"]) for line, cells in lines]


def test_other_clocks_mix_no_runs_and_a_local_board_ranks_those_that_share_theirs(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    with served(tmp_path, 60) as channel:
        board = LeaderboardStub(channel)
        publish(board, played(EvaluationStub(channel), agent="before").run_id)
        assert standings(board) == [("before", 1, [], "")]
    with served(tmp_path, 0) as channel:
        board = LeaderboardStub(channel)
        publish(board, played(EvaluationStub(channel), agent="after").run_id)
        assert standings(board) == [("after", 1, [], ""), ("before", 0, [pb.MARK_OTHER_CLOCKS], "other-clocks")]
    with served(tmp_path, 60) as channel:
        board = LeaderboardStub(channel)
        assert standings(board) == [("after", 1, [], ""), ("before", 0, [pb.MARK_OTHER_CLOCKS], "other-clocks")]
        publish(board, played(EvaluationStub(channel), WRONG, agent="again").run_id)
        other = ("after", 0, [pb.MARK_OTHER_CLOCKS], "other-clocks")
        assert standings(board) == [("before", 1, [], ""), ("again", 2, [], ""), other]
