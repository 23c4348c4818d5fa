"""Receipts: content, access, and permanence."""

import hashlib
import json
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
import rfc8785
import sqlalchemy as sa
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

from arramon.v1.chain import episode_ending, episode_head, run_digest
from arramon_server.episodes.splits import Split
from arramon_server.errors import Conflict, NotFound
from arramon_server.runs.accounts.callers import ANONYMOUS, HOST, Caller, Role
from arramon_server.runs.results.receipts import Receipts
from arramon_server.runs.results.reports import report_of
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from tests import tiny
from tests.played import play

OWNER, RIVAL = Caller(Role.PARTICIPANT, "lab"), Caller(Role.PARTICIPANT, "rival")


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    with closing(Database(database_url)) as database:
        now = datetime.now(UTC)
        with database.write() as connection:
            for name in ("lab", "rival"):
                row = {"participant": name, "role": "participant", "created_at": now}
                connection.execute(tables.participants.insert(), [row])
        yield database


@pytest.fixture
def split(tmp_path: Path) -> Split:
    return tiny.write(tmp_path, count=3)


@pytest.fixture
def receipts(database: Database, split: Split, tmp_path: Path) -> Receipts:
    return Receipts(database, {"tiny": split}, SigningKey(tmp_path / "key.pem"))


def field(text: str) -> bytes:
    return len(text.encode()).to_bytes(4, "big") + text.encode()


def test_hash_chain_follows_the_documented_definition() -> None:
    head = hashlib.sha256(field("arramon.v1 episode") + field("r") + field("e") + field("ab12")).digest()
    assert episode_head("r", "e", "ab12", []) == head
    first = hashlib.sha256(head + b"\0\0\0\0" + b"\3").digest()
    assert episode_head("r", "e", "ab12", [3]) == first
    second = hashlib.sha256(first + b"\0\0\0\1" + b"\0").digest()
    assert episode_head("r", "e", "ab12", [3, 0]) == second
    digest = hashlib.sha256(field("arramon.v1 run") + field("r") + field("e") + second).digest()
    assert run_digest("r", [("e", second)]) == digest


def test_hash_chain_of_a_fixed_run_never_changes() -> None:
    head = episode_head("run", "दो", "00" * 32, [0, 1, 2, 3])
    assert head.hex() == "48de4fff39a28136b0b965eadc980972fa6c502139e9dee860fa26200d5e2377"
    assert (
        run_digest("run", [("दो", head), ("3", head)]).hex()
        == "498d9993a2d5c122ca45b24bc9bc67c9d9517d2ea6523e1686b9d3c928c5f29d"
    )


@pytest.mark.parametrize("other", [
    ("s", "e", "ab", [1, 2]), ("r", "f", "ab", [1, 2]), ("r", "e", "ac", [1, 2]), ("r", "e", "ab", [2, 1]),
    ("r", "e", "ab", [1]), ("r", "e", "ab", [1, 2, 0]), ("re", "", "ab", [1, 2]),
])  # fmt: skip
def test_any_difference_changes_the_chain_head(other: tuple[str, str, str, list[int]]) -> None:
    assert episode_head(*other) != episode_head("r", "e", "ab", [1, 2])


def test_receipt_describes_the_played_run(database: Database, split: Split, receipts: Receipts) -> None:
    play(database, split, actions={"0": tiny.ACTIONS, "1": [0, 0], "2": []}, ended={"1": "FORFEITED", "2": "FORFEITED"})
    receipt = receipts.of(HOST, "r")
    Ed25519PublicKey.from_public_bytes(receipt.public_key).verify(receipt.signature, receipt.payload)
    assert receipt.public_key == receipts.public_key
    content = json.loads(receipt.payload)
    assert rfc8785.dumps(content) == receipt.payload
    assert (content["format"], content["version"], content["protocol"]) == ("arramon-receipt", 1, 1)
    ended_at = Journal(database).run("r").ended_at
    assert ended_at is not None
    assert content["run"] == {
        "run_id": "r", "participant": "lab", "agent": "walker", "split": "tiny", "hidden": False, "language": "en",
        "sensors": ["rgb"], "images": [], "state": "COMPLETE", "created_at": "2026-01-02T03:04:05.678901+00:00",
        "ended_at": ended_at.isoformat(),
    }  # fmt: skip
    assert content["limits"] == {
        "steps_per_phase": 8, "step_seconds": 0, "bank_seconds": 0,
    }  # fmt: skip
    assert (content["data_hash"], content["server_version"]) == (split.data_hash, "0.1.0")
    assert (content["causes"], content["steps"], content["reoffers"]) == ({"AGENT_FINISHED": 1, "FORFEITED": 2}, 15, 0)
    assert content["score_signature"].startswith("split:tiny|lang:en|episodes:3|steps:8|")
    assert list(content["scores"]) == ["total", "turn 1", "turn 2"]
    assert content["scores"]["total"]["PTC"]["mean"] == 1 / 3
    heads = [
        (episode_id, episode_head("r", episode_id, split.data_hash, actions))
        for episode_id, actions in (("0", tiny.ACTIONS), ("1", [0, 0]), ("2", []))
    ]
    assert [(each["episode_id"], each["head"]) for each in content["episodes"]] == [(e, h.hex()) for e, h in heads]
    assert [(each["cause"], each["steps"]) for each in content["episodes"]] == [
        ("AGENT_FINISHED", 13), ("FORFEITED", 2), ("FORFEITED", 0),
    ]  # fmt: skip
    assert [each["scores"]["turn 1"]["PTC"] for each in content["episodes"]] == [1, 0, 0]
    assert content["digest"] == run_digest("r", heads).hex()


def test_hidden_split_receipt_has_no_episode_scores(database: Database, tmp_path: Path) -> None:
    split = tiny.write(tmp_path, "secret", 2, hidden=True)
    receipts = Receipts(database, {"secret": split}, SigningKey(tmp_path / "key.pem"))
    play(database, split)
    content = json.loads(receipts.of(HOST, "r").payload)
    assert content["run"]["hidden"] is True
    assert [set(each) for each in content["episodes"]] == [{"episode_id", "head", "ending"}] * 2
    assert "steps" not in content
    for one in content["episodes"]:
        ending = episode_ending("r", one["episode_id"], "AGENT_FINISHED", tiny.ACTIONS)
        assert one["ending"] == ending.hex()
    report = report_of(Journal(database).run("r"), Journal(database), {"secret": split})
    for row, scores in report.table.rows.items():
        for metric, shown in scores.items():
            assert content["scores"][row][metric] == {"mean": shown.mean, "low": shown.low, "high": shown.high}
    assert (content["scores"]["total"]["nDTW"]["low"], content["scores"]["total"]["nDTW"]["high"]) == (0, 1)
    assert (content["intervals"], content["attempts"]) == ("from-masked-means", {"number": 1, "begun": 1})


def test_receipt_never_changes_once_created(
    database: Database, split: Split, receipts: Receipts, tmp_path: Path
) -> None:
    play(database, split)
    first = receipts.of(HOST, "r")
    other = Receipts(database, {}, SigningKey(tmp_path / "new key.pem"))  # another key, and no data
    assert receipts.of(HOST, "r") == other.of(HOST, "r") == first


def test_concurrent_creation_keeps_one_receipt(database: Database, split: Split, tmp_path: Path) -> None:
    play(database, split)
    makers = [Receipts(database, {"tiny": split}, SigningKey(tmp_path / f"{number}.pem")) for number in range(4)]
    with ThreadPoolExecutor(4) as pool:
        made = set(pool.map(lambda maker: maker.of(HOST, "r"), makers))
    assert len(made) == 1
    assert len(database.read(sa.select(tables.receipts))) == 1


def test_joining_an_ended_run_does_not_change_its_images(database: Database, split: Split) -> None:
    journal = Journal(database)
    play(database, split, actions={"0": tiny.ACTIONS}, over=False)
    journal.record_image_format("r", "lossless-224")
    journal.set_state("r", "COMPLETE")
    journal.record_image_format("r", "jpeg50-128")
    assert journal.progress("r").images == ("lossless-224",)


def test_unfinished_and_unknown_runs_have_no_receipt(database: Database, split: Split, receipts: Receipts) -> None:
    play(database, split, actions={"0": tiny.ACTIONS, "1": [0]}, over=False)
    with pytest.raises(Conflict, match="run 'r' is still being played: 1 of 2 episodes have ended"):
        receipts.of(HOST, "r")
    with pytest.raises(NotFound, match="there is no run 'x'"):
        receipts.of(HOST, "x")
    assert database.read(sa.select(tables.receipts)) == []


def test_missing_runs_and_those_of_others_cause_the_same_queries(
    database: Database, split: Split, receipts: Receipts, monkeypatch: pytest.MonkeyPatch
) -> None:
    play(database, split, account="lab")
    read, queries = database.read, list[str]()

    def noted(query: sa.Select[Any]) -> Sequence[sa.Row[Any]]:
        queries.append(str(query))
        return read(query)

    monkeypatch.setattr(database, "read", noted)
    looked_up = []
    for run_id in ("r", "x"):
        queries.clear()
        with pytest.raises(NotFound, match=f"there is no run '{run_id}'"):
            receipts.of(RIVAL, run_id)
        looked_up.append(list(queries))
    assert looked_up[0] == looked_up[1] != []


def test_no_new_receipt_once_the_data_has_changed(database: Database, split: Split, tmp_path: Path) -> None:
    play(database, split)
    changed = {"tiny": tiny.write(tmp_path, count=2)}
    with pytest.raises(Conflict, match="run 'r' began on split 'tiny' with the data"):
        Receipts(database, changed, SigningKey(tmp_path / "key.pem")).of(HOST, "r")


def test_others_get_a_receipt_only_while_its_run_is_published(
    database: Database, split: Split, receipts: Receipts
) -> None:
    play(database, split, account="lab")
    made = receipts.of(OWNER, "r")
    assert receipts.of(HOST, "r") == made

    def refused() -> None:
        for caller in (RIVAL, ANONYMOUS):
            with pytest.raises(NotFound, match="there is no run 'r'"):
                receipts.of(caller, "r")

    refused()
    entries, now = tables.entries, datetime.now(UTC)
    with database.write() as connection:
        connection.execute(entries.insert(), [{"run_id": "r", "published_at": now, "scores": {}}])
    assert receipts.of(RIVAL, "r") == receipts.of(ANONYMOUS, "r") == made
    with database.write() as connection:
        connection.execute(entries.update().values(withdrawn_at=now))
    refused()
