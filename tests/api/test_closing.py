"""A leaderboard that closes over gRPC, and what its host says of itself."""

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as evaluation
from arramon.v1 import leaderboard_pb2 as pb
from arramon_server.runs.accounts.callers import Role
from tests import tiny
from tests.api.people import Person, token_of
from tests.api.player import LEFT, Player, create, played
from tests.api.test_runs import refused
from tests.serving import METADATA, Server

HOST = ("--host-name", "Lab of streets", "--host-contact", "mail@example.org", "--host-rules", "One run a day.")

FAR = "2100-01-01T00:00:00+00:00"


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
        run_id = played(one.stub).run_id
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


def test_published_anonymous_runs_are_shown_as_to_any_reader(data: Path) -> None:
    """Everybody has their ids, from the leaderboard, and could pass for the caller who began them."""
    token = token_of(data, "host", Role.HOST)
    closes = ("--closes", "tiny=2100-01-01", "--frozen")
    server = Server(data, "127.0.0.1:0", "--steps", "37", "--trust-proxy", "--anonymous", *closes)
    with Person(server.address) as stranger, Person(server.address, token) as host:

        def report(person: Person, run_id: str) -> evaluation.Report:
            found: evaluation.Report = person.stub.GetReport(
                evaluation.GetReportRequest(run_id=run_id), metadata=METADATA
            )
            return found

        def run(person: Person, run_id: str) -> evaluation.Run:
            found: evaluation.Run = person.stub.GetRun(evaluation.GetRunRequest(run_id=run_id), metadata=METADATA)
            return found

        def open_stream(run_id: str) -> evaluation.Run:
            with Player(stranger.stub, run_id, 1) as player:
                return player.next().opened.run

        hidden, frozen = played(stranger.stub, [LEFT], split="secret").run_id, played(stranger.stub).run_id
        exact = run(stranger, hidden).steps
        assert exact == report(stranger, hidden).run.steps > 100
        for run_id in (hidden, frozen):
            assert run(stranger, run_id).steps > 0
            assert report(stranger, run_id).rows
            host.board.Publish(pb.PublishRequest(run_id=run_id), metadata=METADATA)
        for person, steps in ((host, exact), (stranger, float(f"{exact:.1e}"))):
            assert (run(person, hidden).steps, report(person, hidden).run.steps) == (steps, steps)
        assert exact != float(f"{exact:.1e}")
        assert not run(stranger, hidden).HasField("bank_seconds_left")
        assert run(host, frozen).steps > 0
        assert report(host, frozen).rows
        for call in (
            lambda: run(stranger, frozen),
            lambda: report(stranger, frozen),
            lambda: stranger.stub.GetReceipt(evaluation.GetReceiptRequest(run_id=frozen), metadata=METADATA),
            lambda: stranger.stub.GetBreakdown(evaluation.GetBreakdownRequest(run_id=frozen), metadata=METADATA),
        ):
            assert refused(call)[0] == grpc.StatusCode.FAILED_PRECONDITION
        for run_id in (hidden, frozen):
            said = f"run {run_id!r} is complete and on the leaderboard; there is nothing to play"
            assert refused(lambda run_id=run_id: open_stream(run_id)) == (grpc.StatusCode.FAILED_PRECONDITION, said)
    assert server.stop() == 0


def test_no_runs_are_created_after_it_closed_and_those_that_were_begun_are_played(data: Path) -> None:
    server = Server(data, "127.0.0.1:0", "--steps", "8")
    with Person(server.address) as somebody:
        run_id, begun = played(somebody.stub).run_id, create(somebody.stub).run_id
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
