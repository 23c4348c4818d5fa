"""Verification of receipts: every defect is reported in one line, with status 1."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.chain import episode_head, run_digest
from arramon_client.cli import main
from tests.client.fake import RUN, Servicer, World, serving

ACTIONS = {"e1": (0, 0, 3), "e2": (1, 2), "e3": ()}
DATA = "ab" * 32
HOST, ANOTHER = (Ed25519PrivateKey.from_private_bytes(bytes([number]) * 32) for number in (1, 2))
HOST_KEY, ANOTHER_KEY = (key.public_key().public_bytes_raw().hex() for key in (HOST, ANOTHER))
SCORES = {row: {"nDTW": {"mean": 0.25, "low": 0.125, "high": 0.5}} for row in ("turn 1", "turn 2", "total")}


def payload(**changes: Any) -> dict[str, Any]:
    heads = [(episode_id, episode_head("r7", episode_id, DATA, taken)) for episode_id, taken in ACTIONS.items()]
    return {
        "format": "arramon-receipt",
        "version": 1,
        "run": {
            "run_id": "r7", "participant": "lab", "agent": "walker", "split": "tiny", "hidden": True, "language": "en",
            "sensors": [], "images": [], "state": "COMPLETE", "created_at": "2026-01-02", "ended_at": None,
        },
        "limits": {"steps_per_phase": 8, "step_seconds": 60, "bank_seconds": 86400},
        "data_hash": DATA,
        "score_signature": "split:tiny|lang:en|episodes:3",
        "causes": {"FORFEITED": 1, "AGENT_FINISHED": 2},
        "reoffers": 4,
        "steps": 5,
        "scores": SCORES,
        "episodes": [
            {"episode_id": episode_id, "cause": "AGENT_FINISHED", "steps": len(ACTIONS[episode_id]), "head": head.hex()}
            for episode_id, head in heads
        ],
        "digest": run_digest("r7", heads).hex(),
        **changes,
    }  # fmt: skip


def signed(content: object, key: Ed25519PrivateKey = HOST) -> dict[str, Any]:
    text = content if isinstance(content, str) else json.dumps(content)
    return {
        "format": "arramon-receipt-file",
        "version": 1,
        "payload": text,
        "signature": key.sign(text.encode()).hex(),
        "public_key": key.public_key().public_bytes_raw().hex(),
    }


def results(**changes: Any) -> dict[str, Any]:
    actions = {episode_id: "".join(map(str, taken)) for episode_id, taken in ACTIONS.items()}
    return {"run": {"run_id": "r7"}, "metrics": SCORES, "actions": actions, **changes}


class Verify:
    """Callable that writes a receipt's file and verifies it."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.path = folder / "r7.receipt.json"
        self._capsys = capsys

    def __call__(self, content: object, *options: str) -> tuple[int, str, str]:
        text = content if isinstance(content, bytes) else json.dumps(content).encode()
        self.path.write_bytes(text)
        status = main(["verify", str(self.path), *options])
        said = self._capsys.readouterr()
        assert "Traceback" not in said.err + said.out
        return status, said.out, said.err

    def refused(self, content: object, *options: str) -> str:
        """What is said of one that is not right: one line."""
        status, out, err = self(content, *options)
        assert (status, out, err.count("\n")) == (1, "", 1), (status, out, err)
        return err.strip().replace(str(self.path), "FILE")


@pytest.fixture
def verify(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Verify:
    return Verify(tmp_path, capsys)


def test_receipt_signed_by_the_host_is_verified(verify: Verify) -> None:
    status, out, err = verify(signed(payload()), "--key", HOST_KEY)
    assert (status, err) == (0, "")
    assert "walker on tiny, en, 3 episodes" in out
    assert "0.250" in out
    assert "split:tiny|lang:en|episodes:3\n" in out
    assert "run r7 of lab, complete\n" in out
    assert (
        "5 steps; 60 s per step, 86400 s in the bank; episodes ended: 2 AGENT_FINISHED, 1 FORFEITED; offered again: 4\n"
    ) in out
    assert f"signed with the key given, {HOST_KEY}\n" in out


def test_code_and_epoch_are_shown_if_the_receipt_has_them(verify: Verify) -> None:
    run = payload()["run"]
    code = {"url": "https://example.org/walker", "commit": "c" * 40}
    _, out, _ = verify(signed(payload(run={**run, "code": code}, epoch="e" * 64)), "--key", HOST_KEY)
    assert f"code: https://example.org/walker, {'c' * 40}\n" in out
    assert f"epoch with the commitment {'e' * 64}\n" in out
    assert "code" not in verify(signed(payload()), "--key", HOST_KEY)[1]


def test_without_a_key_the_output_says_the_key_was_not_checked(verify: Verify) -> None:
    status, out, _ = verify(signed(payload(), ANOTHER))
    assert status == 3
    assert f"signed with the key {ANOTHER_KEY}. It was NOT checked that this is the host's key" in out


def pem(key: Ed25519PrivateKey) -> str:
    form = serialization.PublicFormat.SubjectPublicKeyInfo
    return key.public_key().public_bytes(serialization.Encoding.PEM, form).decode()


@pytest.mark.parametrize("content", [HOST_KEY, HOST_KEY.upper() + "\n", pem(HOST)])
def test_key_is_read_from_a_file(verify: Verify, tmp_path: Path, content: str) -> None:
    (tmp_path / "key").write_text(content)
    assert verify(signed(payload()), "--key", str(tmp_path / "key"))[0] == 0
    said = verify.refused(signed(payload(), ANOTHER), "--key", str(tmp_path / "key"))
    assert said.startswith(
        f"error: the receipt is signed with the key {ANOTHER_KEY}, not with the key given, {HOST_KEY}"
    )


@pytest.mark.parametrize(
    "content", ["", "hello", HOST_KEY[:-1], "-----BEGIN PUBLIC KEY-----\nAAAA\n-----END PUBLIC KEY-----"]
)
def test_key_file_without_a_key_is_refused(verify: Verify, tmp_path: Path, content: str) -> None:
    (tmp_path / "key").write_text(content)
    said = verify.refused(signed(payload()), "--key", str(tmp_path / "key"))
    assert "contains no public key: expected 64 hexadecimal digits, or Ed25519 in PEM" in said


def test_missing_key_file_is_reported(verify: Verify) -> None:
    said = verify.refused(signed(payload()), "--key", "nowhere")
    assert said.startswith("error: nowhere is neither a hexadecimal key nor a readable file")


def test_key_is_fetched_from_the_server(verify: Verify, world: World) -> None:
    with serving(Servicer(world)) as address:
        assert "has no key and does not sign receipts" in verify.refused(signed(payload()), "--server", address)
        world.info.public_key = bytes.fromhex(HOST_KEY)
        status, out, _ = verify(signed(payload()), "--server", address)
        assert (status, f"signed with the key of {address}, {HOST_KEY}\n" in out) == (0, True)
        said = verify.refused(signed(payload(), ANOTHER), "--server", address)
    assert f"not with the key of {address}, {HOST_KEY}" in said


def without(name: str) -> dict[str, Any]:
    return {key: value for key, value in payload().items() if key != name}


WHOLE = signed(payload())
LATER = signed(payload(version=3))
EPISODES = payload()["episodes"]
ALTERED = "FILE was altered: its signature does not match its content and key"
NOT_RECEIPT = "is signed, but its content does not have the fields of a receipt"
NOT_DIGITS = "is not a results file: its actions are not strings of the digits 0 to 3"


@pytest.mark.parametrize(("content", "said"), [
    ({**WHOLE, "payload": WHOLE["payload"].replace("0.25", "0.75")}, ALTERED),
    ({**WHOLE, "payload": WHOLE["payload"] + " "}, ALTERED),
    ({**WHOLE, "payload": "\ud800"}, ALTERED),
    ({**WHOLE, "public_key": ANOTHER_KEY}, ALTERED),
    ({**WHOLE, "signature": signed(payload(), ANOTHER)["signature"]}, ALTERED),
    ({**WHOLE, "signature": "00" * 64}, ALTERED),
    ({**WHOLE, "signature": "00"}, "FILE is not a receipt: its signature is not 64 bytes in hexadecimal"),
    ({**WHOLE, "public_key": "x" * 64}, "FILE is not a receipt: its public_key is not 32 bytes in hexadecimal"),
    ({**WHOLE, "public_key": None}, "FILE is not a receipt: its public_key is not 32 bytes in hexadecimal"),
    ({**WHOLE, "payload": {}}, "FILE is not a receipt: it has no payload"),
    ({**WHOLE, "version": 7}, "FILE has arramon-receipt-file version 7, but this client reads version 1"),
    ({}, "FILE is not a receipt: it does not have the format 'arramon-receipt-file'"),
    ([], "FILE is not a receipt: it does not have the format 'arramon-receipt-file'"),
    (json.dumps(WHOLE).encode()[:-40], "FILE is not a receipt: it is not JSON, or was truncated"),
    (b"", "FILE is not a receipt: it is not JSON, or was truncated"),
    (b"[" * 200_000, "FILE is not a receipt: it is nested more than 64 levels deep"),
    (b'{"format": NaN}', "FILE is not a receipt: it has the number NaN, which JSON does not have"),
    (signed(payload(steps=2**60)), f"FILE {NOT_RECEIPT}"),
    (signed(payload(steps=True)), f"FILE {NOT_RECEIPT}"),
    (b"\xff\xfe\x00", "FILE is not a receipt: it is not JSON, or was truncated"),
    (LATER, "FILE has arramon-receipt version 3, but this client reads version 1 and 2"),
    (signed("hello"), "FILE is not a receipt: it does not have the format 'arramon-receipt'"),
    (signed("[" * 100_000), "FILE is not a receipt: it does not have the format 'arramon-receipt'"),
    (signed(without("scores")), f"FILE {NOT_RECEIPT}"),
    (signed(payload(episodes=[{"episode_id": 7}])), f"FILE {NOT_RECEIPT}"),
    (signed(payload(run={})), f"FILE {NOT_RECEIPT}"),
    (signed(payload(run={**payload()["run"], "code": "mine"})), f"FILE {NOT_RECEIPT}"),
    (signed(payload(epoch=7)), f"FILE {NOT_RECEIPT}"),
    (signed(payload(digest="00" * 32)), "FILE is inconsistent: its digest does not match its episodes"),
    (signed(payload(episodes=EPISODES[::-1])), "FILE is inconsistent: its digest does not match its episodes"),
])  # fmt: skip
def test_invalid_receipts_are_refused(verify: Verify, content: object, said: str) -> None:
    assert verify.refused(content, "--key", HOST_KEY) == f"error: {said}"


def test_missing_receipt_file_is_reported(verify: Verify, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "nowhere.receipt.json"]) == 1
    assert capsys.readouterr().err == "error: nowhere.receipt.json cannot be read: No such file or directory\n"


@pytest.mark.parametrize("argv", [["verify"], ["verify", "x", "--key", "y", "--server", "z"]])
def test_wrong_usage_prints_the_usage(argv: Sequence[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(argv) == 2
    assert "usage: arramon-client verify" in capsys.readouterr().err


def test_results_file_beside_the_receipt_is_checked(verify: Verify) -> None:
    path = verify.path.with_name("r7.json")
    path.write_text(json.dumps(results()))
    status, out, _ = verify(signed(payload()), "--key", HOST_KEY)
    same = f"{path}: the scores match; in 3 of 3 episodes the actions match those that this client sent\n"
    assert (status, same in out) == (0, True)
    some = {"e1": "0030", "e9": "0"}  # one more was sent than was taken, and one episode is another's
    path.write_text(json.dumps(results(actions=some)))
    status, out, _ = verify(signed(payload()), "--key", HOST_KEY)
    assert (status, "in 1 of 3 episodes the actions match those that this client sent, for the others" in out) == (
        0,
        True,
    )


OTHER_SCORES = {**SCORES, "total": {"nDTW": {"mean": 0.26, "low": 0.125, "high": 0.5}}}


@pytest.mark.parametrize(("content", "said"), [
    (results(actions={"e1": "010"}), "episode e1: the receipt's actions differ from those that this client sent"),
    (results(actions={"e2": "1"}), "episode e2: the receipt has 2 steps, but this client sent 1"),
    (results(actions={"e2": "14"}), f"RESULTS {NOT_DIGITS}"),
    (results(actions={"e2": [1, 2]}), f"RESULTS {NOT_DIGITS}"),
    (results(metrics=OTHER_SCORES), "RESULTS has different scores than the receipt"),
    (results(run={"run_id": "r8"}), "RESULTS is for run r8, but the receipt is for run r7"),
    ({"run": {}}, "RESULTS is not a results file: it has no run and no metrics"),
    ("", "RESULTS is not a results file: it has no run and no metrics"),
    (results(run=[]), "RESULTS is not a results file: it has no run and no metrics"),
    (results(actions=[]), "RESULTS is not a results file: its actions are not listed by episode"),
])  # fmt: skip
def test_results_that_do_not_match_the_receipt_are_refused(
    verify: Verify, tmp_path: Path, content: object, said: str
) -> None:
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(content))
    found = verify.refused(signed(payload()), "--key", HOST_KEY, "--results", str(path))
    assert found.replace(str(path), "RESULTS") == f"error: {said}"


def test_every_differing_episode_is_named(verify: Verify, tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(results(actions={"e1": "010", "e2": "", "e3": ""}, metrics=OTHER_SCORES)))
    status, out, err = verify(signed(payload()), "--key", HOST_KEY, "--results", str(path))
    assert (status, out) == (1, "")
    assert err.splitlines() == [
        f"error: {path} has different scores than the receipt",
        "episode e1: the receipt's actions differ from those that this client sent",
        "episode e2: the receipt has 2 steps, but this client sent 0",
        f"{path}: in 1 of 3 episodes the actions match those that this client sent",
    ]
    path.write_text(json.dumps(results(actions={"e1": "010", "e2": ""})))
    *_, last = verify(signed(payload()), "--key", HOST_KEY, "--results", str(path))[2].splitlines()
    assert last == f"{path}: in 0 of 3 episodes the actions match those that this client sent, for 1 it has no actions"


@pytest.mark.parametrize(("write", "said"), [
    (lambda path: path.write_text("{"), "RESULTS is not a results file: it is not JSON, or was truncated"),
    (lambda path: None, "RESULTS cannot be read: No such file or directory"),
])  # fmt: skip
def test_unreadable_results_files_are_reported(
    verify: Verify, tmp_path: Path, write: Callable[[Path], object], said: str
) -> None:
    path = tmp_path / "mine.json"
    write(path)
    found = verify.refused(signed(payload()), "--results", str(path))
    assert found.replace(str(path), "RESULTS") == f"error: {said}"


AGENT = """
class Agent:
    sensors = ()
    def begin(self, episode): pass
    def act(self, observations): return [(int(o.episode_id[1:]) + o.step) % 4 for o in observations]
"""


class Signing(Servicer):
    """Signs what was recorded, or something else."""

    changed = False

    def GetReceipt(self, request: pb.GetReceiptRequest, context: Any) -> pb.Receipt:  # noqa: N802
        run_id, actions = request.run_id, dict(self.world.actions)
        if self.changed:
            actions["e2"] = [3, *actions["e2"][1:]]
        heads = [(episode_id, episode_head(run_id, episode_id, DATA, taken)) for episode_id, taken in actions.items()]
        episodes = [
            {"episode_id": e, "cause": "AGENT_FINISHED", "steps": len(actions[e]), "head": head.hex()}
            for e, head in heads
        ]
        scores = {
            row.name: {s.metric: {"mean": s.mean, "low": s.low, "high": s.high} for s in row.scores}
            for row in self.world.report().rows
        }
        run = {**payload()["run"], "run_id": run_id}
        digest = run_digest(run_id, heads).hex()
        text = json.dumps(payload(run=run, episodes=episodes, digest=digest, scores=scores)).encode()
        return pb.Receipt(payload=text, signature=HOST.sign(text), public_key=bytes.fromhex(HOST_KEY))


@pytest.mark.parametrize("changed", [False, True])
def test_a_runs_receipt_is_compared_with_the_actions_sent(
    world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], changed: bool
) -> None:
    (tmp_path / "verify_agent.py").write_text(AGENT)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    world.info.public_key = bytes.fromhex(HOST_KEY)
    world.cut = {7: "after"}  # the stream breaks once, and what was sent is sent again
    servicer = Signing(world)
    servicer.changed = changed
    with serving(servicer) as address:
        assert main(["--agent", "verify_agent", "--lang", "en", "--server", address]) == 0
        said = capsys.readouterr()
        assert f"receipt: arramon-results/{RUN}.receipt.json\n" in said.out
        warning = "warning: episode e2: the receipt's actions differ from those that this client sent"
        assert (warning in said.err) == changed
        status = main(["verify", f"arramon-results/{RUN}.receipt.json", "--server", address])
        assert status == int(changed)
        # ActionBatch for again, the file keeps what this client sent.
        assert main(["--agent", "verify_agent", "--server", address, "--resume", RUN]) == 0
    kept = json.loads(Path(f"arramon-results/{RUN}.json").read_text())["actions"]
    assert kept == {e: "".join(map(str, taken)) for e, taken in world.actions.items()}


def test_without_a_receipt_scores_and_results_are_still_written(
    world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "verify_agent.py").write_text(AGENT)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    with serving(Servicer(world)) as address:
        assert main(["--agent", "verify_agent", "--lang", "en", "--server", address]) == 0
    said = capsys.readouterr()
    assert "no receipt: the fake server signs nothing (NOT_FOUND)" in said.err
    assert f"results: arramon-results/{RUN}.json" in said.out
    assert [path.name for path in Path("arramon-results").iterdir()] == [f"{RUN}.json"]


def test_receipt_of_a_hidden_split_is_valid_without_steps_and_causes(verify: Verify) -> None:
    """Version 2: the steps are those after which the actions have the head; a client may have sent more."""
    episodes = [
        {"episode_id": one["episode_id"], "head": one["head"], "ending": "0" * 64} for one in payload()["episodes"]
    ]
    content = {name: value for name, value in payload(version=2, episodes=episodes).items() if name != "steps"}
    more = {name: "".join(map(str, taken)) + "0" for name, taken in ACTIONS.items()}
    beside = verify.path.with_name("r7.json")
    beside.write_text(json.dumps(results(actions=more)))
    status, said, _ = verify(signed(content), "--key", HOST_KEY)
    assert (status, "the scores match" in said, "steps;" in said) == (0, True, False)
    beside.write_text(json.dumps(results(actions={name: "3" + taken for name, taken in more.items()})))
    assert "the receipt's actions differ" in verify(signed(content), "--key", HOST_KEY)[2]
    without_ending = [{name: one[name] for name in ("episode_id", "head")} for one in episodes]
    status, _, said = verify(signed({**content, "episodes": without_ending}), "--key", HOST_KEY)
    assert (status, "does not have the fields of a receipt" in said) == (1, True)


def test_several_receipts_are_verified(verify: Verify, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One that is not valid does not hide the others."""
    good, bad = tmp_path / "good.receipt.json", tmp_path / "bad.receipt.json"
    good.write_text(json.dumps(signed(payload())))
    bad.write_text(json.dumps({**WHOLE, "signature": "00" * 64}))
    assert main(["verify", str(good), str(good), "--key", HOST_KEY]) == 0
    assert capsys.readouterr().out.count("signed with the key given") == 2
    assert main(["verify", str(good), str(good)]) == 3
    capsys.readouterr()
    assert main(["verify", str(bad), str(good), "--key", HOST_KEY]) == 1
    shown = capsys.readouterr()
    assert (shown.out.count("signed with the key given"), shown.err.count("error: ")) == (1, 1)
    assert f"{good}:\n" in shown.out
    assert main(["verify", str(good), str(good), "--results", "x"]) == 2
    assert "--results is the file of one run" in capsys.readouterr().err


def test_what_was_verified_is_printed_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good, bad = tmp_path / "good.receipt.json", tmp_path / "bad.receipt.json"
    good.write_text(json.dumps(signed(payload())))
    bad.write_text("[" * 200_000)
    assert main(["verify", str(good), "--key", HOST_KEY, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["valid"], found["key_checked"], found["receipt"]["run"]["agent"]) == (True, True, "walker")
    assert main(["verify", str(good), str(bad), "--json"]) == 1
    first, second = json.loads(capsys.readouterr().out)
    assert (first["valid"], second["valid"], "nested" in second["error"]) == (True, False, True)


def test_a_receipts_texts_are_printed_without_control_characters(verify: Verify) -> None:
    """Anyone can sign a receipt."""
    run = {**payload()["run"], "agent": "\x1b[2J[/bold]", "participant": "a\u202eb\nforged", "code": {"url": "\x9b31m"}}
    status, out, err = verify(signed(payload(run=run, score_signature="\x07")))
    assert (status, err) == (3, "")
    assert not any(letter in out for letter in "\x1b\x07\x9b\u202e")
    assert "[/bold]" in out
