"""Receipts over gRPC, and the host's commands around them, on a real server."""

import json
import stat
import subprocess
from collections.abc import Sequence
from pathlib import Path

import grpc
import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.chain import episode_head
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_client.cli import main
from arramon_server.runs.results.signing import SigningKey
from tests import forked, tiny
from tests.api.player import Player, create, played
from tests.serving import METADATA, Server


def run(*arguments: object) -> "subprocess.CompletedProcess[str]":
    done = forked.run(*arguments)
    assert "Traceback" not in done.stderr
    return done


def receipt_of(stub: EvaluationStub, run_id: str) -> pb.Receipt:
    return stub.GetReceipt(pb.GetReceiptRequest(run_id=run_id), metadata=METADATA)


def test_receipt_is_signed_by_the_host_and_matches_the_report(server: Server, stub: EvaluationStub) -> None:
    made = played(stub, episodes=2, sensors=["rgb"])
    receipt = receipt_of(stub, made.run_id)
    key = stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA).public_key
    assert receipt.public_key == key == SigningKey(server.data / "signing-key.pem").public
    assert stat.S_IMODE((server.data / "signing-key.pem").stat().st_mode) == 0o600
    Ed25519PublicKey.from_public_bytes(key).verify(receipt.signature, receipt.payload)
    content = json.loads(receipt.payload)
    report = stub.GetReport(pb.GetReportRequest(run_id=made.run_id), metadata=METADATA)
    assert content["score_signature"] == report.signature
    assert content["scores"]["turn 2"] == {
        score.metric: {"mean": score.mean, "low": score.low, "high": score.high} for score in report.rows[1].scores
    }
    assert content["run"]["images"] == ["lossless-224"]
    assert (content["causes"], content["steps"]) == ({"AGENT_FINISHED": 2}, 26)
    assert content["limits"]["steps_per_phase"] == 8
    assert content["limits"]["step_seconds"] == made.limits.step_seconds
    for episode in content["episodes"]:
        assert episode["head"] == episode_head(made.run_id, episode["episode_id"], made.data_hash, tiny.ACTIONS).hex()
    assert receipt_of(stub, made.run_id) == receipt


def test_hidden_split_receipts_hold_no_episode_scores(stub: EvaluationStub) -> None:
    content = json.loads(receipt_of(stub, played(stub, split="secret").run_id).payload)
    assert {name for episode in content["episodes"] for name in episode} == {"episode_id", "head", "ending"}


def test_cancelled_run_has_a_receipt(stub: EvaluationStub) -> None:
    made = create(stub, episodes=3)
    stub.CancelRun(pb.CancelRunRequest(run_id=made.run_id), metadata=METADATA)
    content = json.loads(receipt_of(stub, made.run_id).payload)
    assert (content["run"]["state"], content["causes"]) == ("CANCELLED", {"FORFEITED": 3})


def test_client_stores_the_receipt_and_verifies_it_with_the_hosts_key(
    server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)

    def client(*arguments: str) -> tuple[int, str]:
        status = main(arguments)
        return status, capsys.readouterr().out

    options = ("--server", server.address, "--split", "tiny", "--sensors", "none", "--episodes", "4", "--output", "out")
    status, said = client("--agent", "agents.random_walk", "--lang", "en", *options)
    (receipt,) = Path("out").glob("*.receipt.json")
    assert (status, f"receipt: {receipt}\n" in said) == (0, True)
    key = run("key", "--data", server.data).stdout.strip()
    Path("key.pem").write_text(run("key", "--data", server.data, "--pem").stdout)
    for given in (("--key", key), ("--key", "key.pem"), ("--server", server.address)):
        status, said = client("verify", str(receipt), *given)
        assert (status, key in said) == (0, True)
        assert "the scores match; in 4 of 4 episodes the actions match those that this client sent" in said
    content = json.loads(receipt.read_text())
    receipt.write_text(json.dumps({**content, "payload": content["payload"].replace('"steps":', '"steps":1')}))
    assert client("verify", str(receipt), "--key", key) == (1, "")


def check_rescored(done: "subprocess.CompletedProcess[str]", status: int, said: Sequence[str]) -> None:
    assert (done.returncode, done.stderr) == (status, "")
    lines = done.stdout.splitlines()
    assert len(lines) == len(said)
    for line, expected in zip(lines, said, strict=True):
        assert line.startswith(expected)


def test_rescoring_works_while_the_server_runs_and_after_it_stopped(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path, "127.0.0.1:0", "--steps", "8")
    try:
        with grpc.insecure_channel(server.address) as channel:
            stub = EvaluationStub(channel)
            made = [played(stub, episodes=2).run_id for _ in range(2)]
            going = create(stub).run_id
            receipt_of(stub, made[0])
        again = [
            f"run {made[0]}: 2 episodes, 26 steps: identical",
            f"run {made[1]}: 2 episodes, 26 steps: identical; it has no receipt yet",
        ]
        check_rescored(run("rescore", "--data", tmp_path, *made), 0, again)
        check_rescored(run("rescore", "--data", tmp_path, going), 1, [f"run '{going}' is still being played"])
    finally:
        assert server.stop() == 0
    check_rescored(run("rescore", "--data", tmp_path, "--all"), 0, again)
    tiny.write(tmp_path, count=5)
    check_rescored(run("rescore", "--data", tmp_path, made[0]), 1, [f"run '{made[0]}' began on split 'tiny' with"])


@pytest.mark.parametrize(("arguments", "said"), [
    (["rescore"], "expected either ids of runs, or --all, or --receipt FILE, or --adopt SPLIT"),
    (["rescore", "--all", "r"], "expected either ids of runs, or --all, or --receipt FILE, or --adopt SPLIT"),
    (["rescore", "r"], "there is no journal FOLDER/journal.db yet; `arramon-server serve` creates it"),
    (["export", "file"], "there is no journal FOLDER/journal.db yet; `arramon-server serve` creates it"),
    (["key", "--all"], "there is no journal FOLDER/journal.db yet; `arramon-server serve` creates it"),
    (["import", "nowhere"], "nowhere: cannot be read: No such file or directory"),
])  # fmt: skip
def test_invalid_host_commands_are_refused(tmp_path: Path, arguments: list[str], said: str) -> None:
    tiny.write(tmp_path)
    done = run(arguments[0], "--data", tmp_path, *arguments[1:])
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == f"arramon-server: {said}\n".replace("FOLDER", str(tmp_path))
    if arguments[0] != "import":
        assert not (tmp_path / "journal.db").exists()


def test_host_with_another_key_starts_only_after_adopting_it(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    assert Server(tmp_path).stop() == 0
    first = run("key", "--data", tmp_path).stdout.strip()
    other = ("--signing-key", tmp_path / "other.pem")
    refusal = run("serve", "--data", tmp_path, "--listen", "127.0.0.1:0", *other)
    second = run("key", "--data", tmp_path, *other).stdout.strip()
    assert refusal.returncode == 1
    assert f"this host's signing key is {second}, but the receipts of this journal are signed with {first}" in (
        refusal.stderr
    )
    adopted = run("key", "--adopt", "--data", tmp_path, *other)
    assert (adopted.returncode, adopted.stdout) == (0, f"{second}\n")
    server = Server(tmp_path, "127.0.0.1:0", *map(str, other))
    assert server.stop() == 0
    known = run("key", "--all", "--data", tmp_path).stdout.splitlines()
    assert [line.split()[0] for line in known] == [first, second]


def test_half_played_run_continues_on_another_host_with_equal_scores(tmp_path: Path) -> None:
    data, host = tmp_path / "data", tmp_path / "host"
    for folder in (data, host):
        tiny.write(folder)
    walk = [int(digit) for digit in "0100301003000311021003"]  # neither perfect nor nothing
    server = Server(data, "127.0.0.1:0", "--steps", "8")
    try:
        with grpc.insecure_channel(server.address) as channel:
            stub = EvaluationStub(channel)
            undisturbed, half = create(stub).run_id, create(stub).run_id
            with Player(stub, undisturbed, 3) as player:
                player.play(walk)
            with Player(stub, half, 2) as player:
                for _ in range(30):
                    seen = player.observation()
                    player.act(seen.episode_id, seen.step, walk[seen.step % len(walk)])
                player.observation()  # what was answered is recorded
        exported = run("export", "--data", data, tmp_path / "file")
        assert (exported.returncode, exported.stderr) == (0, "")
    finally:
        server.stop()
    assert run("import", "--data", host, tmp_path / "file").stdout.endswith(" rows added, 0 already present\n")
    (data / "signing-key.pem").replace(host / "signing-key.pem")
    server = Server(host, "127.0.0.1:0", "--steps", "8")
    try:
        with grpc.insecure_channel(server.address) as channel:
            stub = EvaluationStub(channel)
            with Player(stub, half, 3, adopt=True) as player:
                player.play(walk)
            reports = [
                stub.GetReport(pb.GetReportRequest(run_id=run_id), metadata=METADATA) for run_id in (undisturbed, half)
            ]
    finally:
        assert server.stop() == 0
    assert list(reports[0].rows) == list(reports[1].rows)
    assert list(reports[0].episodes) == list(reports[1].episodes)
    assert 0 < reports[1].rows[2].scores[0].mean < 1
    assert run("rescore", "--data", host, "--all").returncode == 0
