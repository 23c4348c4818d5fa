"""Receipts that the host has superseded, as `arramon-client verify` tells."""

import hashlib
import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import grpc
import pytest

from arramon.v1 import leaderboard_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import add_EvaluationServicer_to_server
from arramon.v1.leaderboard_pb2_grpc import LeaderboardServicer, add_LeaderboardServicer_to_server
from arramon_client.cli import main
from tests.client.fake import Servicer, World
from tests.client.test_verify import HOST_KEY, SCORES, payload, results, signed

REVISION = {"number": 1, "made_at": "2030-01-02", "supersedes": "c" * 64}
CORRECTIONS = [{"kind": "void", "made_at": "2030-01-01", "reason": "a wall", "episodes": ["e1"]}]


class Board(LeaderboardServicer):
    """Leaderboard with one entry, or none."""

    def __init__(self, entry: pb.Entry | None) -> None:
        self.entry = entry

    def GetEntry(self, request: pb.GetEntryRequest, context: Any) -> pb.Entry:  # noqa: N802 - named by the protocol
        assert request.run_id == "r7"
        if self.entry is None:
            context.abort(grpc.StatusCode.NOT_FOUND, "there is no such run")
        return self.entry or pb.Entry()


@contextmanager
def serving(world: World, entry: pb.Entry | None) -> Iterator[str]:
    world.info.public_key = bytes.fromhex(HOST_KEY)
    with ThreadPoolExecutor(2) as pool:
        server = grpc.server(pool)
        add_EvaluationServicer_to_server(Servicer(world), server)
        add_LeaderboardServicer_to_server(Board(entry), server)  # type: ignore[abstract]  # it serves nothing else
        port = server.add_insecure_port("127.0.0.1:0")
        server.start()
        yield f"127.0.0.1:{port}"
        server.stop(None).wait()


def digest(content: dict[str, Any]) -> bytes:
    return hashlib.sha256(str(content["payload"]).encode()).digest()


def verify(folder: Path, content: dict[str, Any], address: str) -> int:
    path = folder / "r7.receipt.json"
    path.write_text(json.dumps(content))
    return main(["verify", str(path), "--server", address])


def test_a_superseded_receipt_is_told(world: World, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old, new = signed(payload()), signed(payload(revision=REVISION, corrections=CORRECTIONS))
    void = pb.Correction(kind=pb.CORRECTION_KIND_VOID, made_at="2030-01-01", reason="a wall", episodes=["e1"])
    entry = pb.Entry(
        receipt_digest=digest(new),
        superseded=[pb.SupersededReceipt(number=1, superseded_at="2030-01-02", digest=digest(old))],
        corrections=[void],
    )
    with serving(world, entry) as address:
        assert verify(tmp_path, old, address) == 4
        said = (
            "SUPERSEDED at 2030-01-02: the host has signed another receipt for this run "
            "(corrected at 2030-01-01: void: 1 episode (e1): a wall)"
        )
        assert said in capsys.readouterr().out.splitlines()
        assert verify(tmp_path, new, address) == 0
        out = capsys.readouterr().out
        assert "corrected at 2030-01-01: void: 1 episode (e1): a wall\n" in out
        assert f"supersedes the receipt with the digest {'c' * 64} since 2030-01-02\n" in out
        assert verify(tmp_path, signed(payload(steps=6)), address) == 4
        assert "does not list this one among those that it superseded" in capsys.readouterr().out


def test_receipts_of_unpublished_runs_are_not_compared(world: World, tmp_path: Path) -> None:
    with serving(world, None) as address:
        assert verify(tmp_path, signed(payload()), address) == 0


def test_results_from_before_a_correction_are_no_forgery(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "r7.receipt.json"
    other = {row: {"nDTW": {"mean": 0.5, "low": 0.25, "high": 0.75}} for row in SCORES}
    (tmp_path / "r7.json").write_text(json.dumps(results()))
    path.write_text(json.dumps(signed(payload(scores=other))))
    assert main(["verify", str(path), "--key", HOST_KEY]) == 1
    path.write_text(json.dumps(signed(payload(scores=other, revision=REVISION, corrections=CORRECTIONS))))
    capsys.readouterr()
    assert main(["verify", str(path), "--key", HOST_KEY]) == 0
    assert "the scores are those before the host's corrections" in capsys.readouterr().out


@pytest.mark.parametrize("further", [
    {"corrections": "all"}, {"corrections": ["void"]}, {"corrections": [{"kind": "void"}]}, {"revision": 1},
    {"revision": {"number": "1"}},
])  # fmt: skip
def test_malformed_corrections_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], further: dict[str, Any]
) -> None:
    path = tmp_path / "r7.receipt.json"
    path.write_text(json.dumps(signed(payload(**further))))
    assert main(["verify", str(path), "--key", HOST_KEY]) == 1
    assert "its content does not have the fields of a receipt" in capsys.readouterr().err
