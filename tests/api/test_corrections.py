"""Corrections by the host while its server runs, over gRPC: what lists, entries and receipts say."""

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

from arramon.v1 import evaluation_pb2 as evaluation
from arramon.v1 import leaderboard_pb2 as pb
from arramon_server.cli import main
from tests import tiny
from tests.api.people import Person
from tests.api.player import played
from tests.serving import METADATA, Server

WRONG = [tiny.P] * 4


def published(person: Person, actions: Sequence[int], agent: str) -> str:
    run_id = played(person.stub, actions, agent=agent).run_id
    person.board.Publish(pb.PublishRequest(run_id=run_id), metadata=METADATA)
    return run_id


def test_a_void_episode_leaves_the_scores_of_a_server_that_runs(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path, "127.0.0.1:0", "--steps", "8")
    with Person(server.address) as person:
        run_id = published(person, tiny.ACTIONS, "good")
        published(person, WRONG, "poor")
        request = pb.ListRequest(split="tiny", language="en")
        before = person.board.List(request, metadata=METADATA)
        assert (len(before.standings), len(before.corrections)) == (2, 0)
        report = evaluation.GetReportRequest(run_id=run_id)
        assert "|episodes:6|" in person.stub.GetReport(report, metadata=METADATA).signature
        asked = evaluation.GetReceiptRequest(run_id=run_id)
        old = person.stub.GetReceipt(asked, metadata=METADATA)

        assert main(["void", "--data", str(tmp_path), "tiny", "0", "--reason", "inside a wall"]) == 0

        after = person.board.List(request, metadata=METADATA)
        (correction,) = after.corrections
        assert (correction.kind, correction.reason, list(correction.episodes)) == (
            pb.CORRECTION_KIND_VOID, "inside a wall", ["0"],
        )  # fmt: skip
        assert [one.entries[0].voided for one in after.standings] == [1, 1]
        assert all(one.rank for one in after.standings)
        assert "|episodes:5|" in person.stub.GetReport(report, metadata=METADATA).signature
        new = person.stub.GetReceipt(asked, metadata=METADATA)
        assert json.loads(new.payload)["voided"] == ["0"]
        entry = person.board.GetEntry(pb.GetEntryRequest(run_id=run_id), metadata=METADATA)
        assert entry.receipt_digest == hashlib.sha256(new.payload).digest()
        assert list(entry.corrections) == [correction]
        (superseded,) = entry.superseded
        assert superseded.digest == hashlib.sha256(old.payload).digest()
        asked = evaluation.GetReceiptRequest(run_id=run_id, number=superseded.number)
        assert person.stub.GetReceipt(asked, metadata=METADATA) == old
        groups = person.stub.GetBreakdown(evaluation.GetBreakdownRequest(run_id=run_id), metadata=METADATA).groups
        assert {group.turns for group in groups if group.aspect == "turn"} == {5}
    server.stop()
