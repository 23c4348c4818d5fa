"""A leaderboard that closes over gRPC, and what its host says of itself."""

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as evaluation
from arramon.v1 import leaderboard_pb2 as pb
from server.runs.accounts.callers import Role
from tests import tiny
from tests.api.people import Person, token_of
from tests.api.player import Player, create
from tests.api.test_runs import refused
from tests.serving import METADATA, Server

HOST = ("--host-name", "Lab of streets", "--host-contact", "mail@example.org", "--host-rules", "One run a day.")

FAR = "2100-01-01T00:00:00+00:00"


def played(person: Person) -> str:
    run = create(person.stub)
    with Player(person.stub, run.run_id, 3) as player:
        player.play(tiny.ACTIONS)
    return run.run_id


@pytest.fixture
def data(tmp_path: Path) -> Path:
    tiny.write(tmp_path)
    tiny.write(tmp_path, "secret", 3, hidden=True)
    return tmp_path


@pytest.fixture
def frozen(data: Path) -> Iterator[Server]:
    token_of(data, "host", Role.HOST)
    server = Server(data, "127.0.0.1:0", "--steps", "8", *HOST, "--closes", "tiny=2100-01-01", "--frozen")
    yield server
    server.stop()


def test_server_information_has_the_host_and_when_splits_close(frozen: Server) -> None:
    with Person(frozen.address) as anybody:
        info = anybody.stub.GetServerInfo(evaluation.GetServerInfoRequest(), metadata=METADATA)
    assert info.host == evaluation.Host(name="Lab of streets", contact="mail@example.org", rules="One run a day.")
    assert {split.name: (split.closes_at, split.frozen) for split in info.splits} == {
        "tiny": (FAR, True), "secret": ("", False),
    }  # fmt: skip


def test_scores_are_shown_to_their_participant_alone_until_it_closes(frozen: Server, data: Path) -> None:
    ann, bob = (token_of(data, name) for name in ("ann", "bob"))
    with Person(frozen.address, ann) as one, Person(frozen.address, bob) as other:
        run_id = played(one)
        entry = one.board.Publish(pb.PublishRequest(run_id=run_id), metadata=METADATA)
        assert (entry.frozen, len(entry.rows), dict(entry.run.causes), entry.run.steps) == (True, 0, {}, 0)
        listed = other.board.List(pb.ListRequest(split="tiny", language="en"), metadata=METADATA)
        (standing,) = listed.standings
        assert (listed.frozen, listed.closes_at, len(standing.rows), standing.rank) == (True, FAR, 0, 0)
        assert len(one.stub.GetReport(evaluation.GetReportRequest(run_id=run_id), metadata=METADATA).rows) == 3
        assert one.stub.GetReceipt(evaluation.GetReceiptRequest(run_id=run_id), metadata=METADATA).payload
        for call in (
            lambda: other.stub.GetReceipt(evaluation.GetReceiptRequest(run_id=run_id), metadata=METADATA),
            lambda: other.stub.GetBreakdown(evaluation.GetBreakdownRequest(run_id=run_id), metadata=METADATA),
            lambda: other.board.Compare(pb.CompareRequest(run_id=run_id), metadata=METADATA),
            lambda: other.board.GetActions(pb.GetActionsRequest(run_id=run_id), metadata=METADATA),
        ):
            assert refused(call) == (
                grpc.StatusCode.FAILED_PRECONDITION,
                "the leaderboard of split 'tiny' is frozen: scores are shown when it closes, "
                "on 2100-01-01 at 00:00 UTC",
            )


def test_no_runs_are_created_after_it_closed_and_those_that_were_begun_are_played(data: Path) -> None:
    server = Server(data, "127.0.0.1:0", "--steps", "8")
    with Person(server.address) as somebody:
        run_id, begun = played(somebody), create(somebody.stub).run_id
    server.stop()
    past = datetime.now(UTC) - timedelta(minutes=1)
    server = Server(data, "127.0.0.1:0", "--steps", "8", "--closes", f"tiny={past.isoformat()}")
    closed = f"the leaderboard of split 'tiny' closed on {past:%Y-%m-%d at %H:%M} UTC: "
    with Person(server.address) as somebody:
        assert refused(lambda: create(somebody.stub)) == (
            grpc.StatusCode.FAILED_PRECONDITION, closed + "no runs are created on it",
        )  # fmt: skip
        with Player(somebody.stub, begun, 3) as player:
            player.play(tiny.ACTIONS)
        for over in (run_id, begun):
            request = pb.PublishRequest(run_id=over)
            assert refused(lambda request=request: somebody.board.Publish(request, metadata=METADATA)) == (
                grpc.StatusCode.FAILED_PRECONDITION, closed + "no runs on it are published",
            )  # fmt: skip
        assert create(somebody.stub, split="secret", language="en").run_id
    server.stop()


def test_times_of_unknown_splits_are_refused(data: Path) -> None:
    with pytest.raises(AssertionError, match="closes names the split 'tinny'"):
        Server(data, "127.0.0.1:0", "--closes", "tinny=2100-01-01")
