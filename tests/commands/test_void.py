"""The commands that correct a split: `void`, and `rescore --adopt`."""

import json
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from arramon_server.board.corrector import Corrector
from arramon_server.board.entries import Entries
from arramon_server.board.publisher import Publisher
from arramon_server.cli import main
from arramon_server.episodes.splits import read_splits, split_folder, write_split
from arramon_server.errors import StorageError
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.results.receipts import Receipts, stored_receipt
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage.corrections import Corrections
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.transfer.export import export
from arramon_server.runs.transfer.restore import import_archive
from arramon_server.sim.room import RoomPosition
from tests import tiny
from tests.played import play

RUN = "a" * 32


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A host's data folder with one published run."""
    folder = tmp_path / "data"
    tiny.write(folder)
    splits = read_splits(folder)
    with closing(Database(f"sqlite:///{folder / 'journal.db'}")) as database:
        play(database, splits["tiny"], RUN)
        receipts = Receipts(database, splits, SigningKey(folder / "signing-key.pem"))
        Publisher(Journal(database), splits, Entries(database), receipts).publish(HOST, RUN, "")
    return folder


def run(data: Path, *arguments: str) -> int:
    return main([*arguments[:1], "--data", str(data), *arguments[1:]])


def receipt(data: Path) -> dict[str, object]:
    with closing(Database(f"sqlite:///{data / 'journal.db'}")) as database:
        found = stored_receipt(database, RUN)
    assert found is not None
    content: dict[str, object] = json.loads(found.payload)
    return content


def test_episodes_are_voided_listed_and_restored(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(data, "void", "tiny", "0", "1", "--reason", "inside a wall") == 0
    assert capsys.readouterr().out == "void: 2 episodes ('0', '1') of split tiny\nnew receipts: 1\n"
    assert receipt(data)["voided"] == ["0", "1"]
    assert run(data, "void", "tiny") == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].endswith("void  2 episodes ('0', '1'): inside a wall")
    assert lines[1] == "void now: 0, 1"
    assert run(data, "void", "tiny", "1", "--restore", "--reason", "it was right") == 0
    assert receipt(data)["voided"] == ["0"]
    assert run(data, "rescore", RUN) == 0


@pytest.mark.parametrize(("arguments", "message"), [
    (["tiny", "0"], "expected a reason, which the leaderboard shows: --reason TEXT"),
    (["tiny", "--restore"], "expected ids of episodes"),
    (["tinny", "0", "--reason", "x"], "there is no split 'tinny'; there are tiny"),
    (["tiny", "zero", "--reason", "x"], "split 'tiny' has no episode 'zero'"),
])  # fmt: skip
def test_what_is_wrong_is_said(
    data: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    assert run(data, "void", *arguments) == 1
    assert message in capsys.readouterr().err


def test_the_host_of_a_hidden_split_is_told_what_a_void_episode_tells(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tiny.write(tmp_path, "secret", hidden=True)
    assert run(tmp_path, "void", "secret", "0", "--reason", "x") == 0
    assert "the difference between the scores before and after is about these episodes" in capsys.readouterr().err


@pytest.mark.parametrize("restore", [False, True])
def test_a_command_that_stopped_before_the_receipts_is_finished_by_the_same_one(
    data: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, restore: bool
) -> None:
    said, flags = ("not void", ["--restore"]) if restore else ("void already", [])
    if restore:
        assert run(data, "void", "tiny", "0", "--reason", "doubtful") == 0
    void_command = ("void", "tiny", "0", *flags, "--reason", "x")

    def stop(_self: Corrector, _split: str) -> int:
        raise StorageError("the disk is full")

    with monkeypatch.context() as patched:
        patched.setattr(Corrector, "renew_receipts", stop)
        assert run(data, *void_command) == 1
    assert receipt(data).get("voided", []) == (["0"] if restore else [])
    capsys.readouterr()
    assert run(data, "rescore", RUN) == 1
    (line,) = (line for line in capsys.readouterr().out.splitlines() if "receipt" in line and "was" in line)
    assert "the receipt is outdated: the host has corrected the split since it was signed" in line
    assert run(data, *void_command) == 0
    assert capsys.readouterr().out == (
        f"1 episode ('0') of split 'tiny' {said}, by a command that stopped before all receipts were signed\n"
        "new receipts: 1\n"
    )
    assert receipt(data).get("voided", []) == ([] if restore else ["0"])
    assert run(data, "rescore", RUN) == 0
    assert run(data, *void_command) == 1
    assert said in capsys.readouterr().err


def test_an_outdated_receipt_does_not_finish_another_correction(
    data: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patched:
        patched.setattr(Corrector, "renew_receipts", lambda _self, _split: 0)
        assert run(data, "void", "tiny", "0", "--reason", "x") == 0
    assert run(data, "void", "tiny", "0", "1", "--reason", "x") == 1
    assert "1 episode ('0') of split 'tiny' void already" in capsys.readouterr().err
    assert receipt(data).get("voided") is None


def test_an_outdated_receipt_of_corrected_data_is_named(
    data: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    adopt = ("rescore", "--adopt", "tiny", "--before", str(corrected(data)), "--reason", "the cell was wrong")
    with monkeypatch.context() as patched:
        patched.setattr(Receipts, "renew", lambda _self, _run: False)
        assert run(data, *adopt) == 0
    capsys.readouterr()
    assert run(data, "rescore", RUN) == 1
    out = capsys.readouterr().out
    assert "the receipt is outdated: the host has corrected the split since it was signed" in out
    assert "data_hash was" not in out
    assert run(data, *adopt) == 0
    assert run(data, "rescore", RUN) == 0


def test_a_run_of_void_episodes_alone_is_compared_with_its_kept_receipt(
    data: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    splits = read_splits(data)
    with closing(Database(f"sqlite:///{data / 'journal.db'}")) as database:
        play(database, splits["tiny"], "b" * 32, {"0": tiny.ACTIONS})
        Receipts(database, splits, SigningKey(data / "signing-key.pem")).of(HOST, "b" * 32)
    assert run(data, "void", "tiny", "0", "--reason", "x") == 0
    capsys.readouterr()
    assert run(data, "rescore", "b" * 32) == 0
    assert "identical" in capsys.readouterr().out


def corrected(data: Path) -> Path:
    """Correct the cell of an episode; return the folder with the data as it was."""
    old = data.parent / "old" / "tiny"
    old.parent.mkdir()
    split_folder(data, "tiny").rename(old)
    episodes = []
    for number in range(6):
        one = tiny.episode(str(number), ("en",) if number % 3 == 0 else ("en", "hi"))
        first = replace(one.turns[0], target_cell=RoomPosition(2, 1, 3))
        episodes.append(replace(one, turns=(first, one.turns[1])) if number == 0 else one)
    write_split(data, "tiny", hidden=False, source="tests", episodes=episodes, sections=[tiny.SECTION])
    return old


def test_runs_are_scored_again_after_a_correction(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old = corrected(data)
    assert run(data, "rescore", RUN) == 1
    assert "which now has the data" in capsys.readouterr().out
    adopt = ("rescore", "--adopt", "tiny", "--before", str(old), "--reason", "the cell was wrong")
    assert run(data, *adopt) == 0
    said = capsys.readouterr()
    assert said.out == f"run {RUN}: scores changed in 1 episodes\nscored again: 1 runs; new receipts: 1\n"
    assert said.err == "restart the servers to serve the corrected data\n"
    assert run(data, "rescore", RUN) == 0
    assert "identical" in capsys.readouterr().out
    assert receipt(data)["scores"]["total"]["PTC"]["mean"] == pytest.approx(11 / 12)  # type: ignore[index]


@pytest.mark.parametrize(("arguments", "message"), [
    (["--adopt", "tiny"], "--adopt SPLIT, --before FOLDER and --reason TEXT are used together"),
    (["--all", "--reason", "x"], "--adopt SPLIT, --before FOLDER and --reason TEXT are used together"),
    (["--adopt", "tiny", "--all", "--before", "x", "--reason", "x"], "expected either ids of runs"),
    (["--adopt", "tiny", "--before", "/nowhere/tiny", "--reason", "x"], "/nowhere/tiny/episodes.jsonl: cannot be read"),
])  # fmt: skip
def test_adopt_needs_the_data_as_it_was_and_a_reason(
    data: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    assert run(data, "rescore", *arguments) == 1
    assert message in capsys.readouterr().err


def test_an_export_carries_corrections_and_superseded_receipts(data: Path, database_url: str) -> None:
    assert run(data, "void", "tiny", "1", "--reason", "doubtful") == 0
    adopt = ("rescore", "--adopt", "tiny", "--before", str(corrected(data)), "--reason", "the cell was wrong")
    assert run(data, *adopt) == 0
    splits, key = read_splits(data), SigningKey(data / "signing-key.pem")
    with closing(Database(f"sqlite:///{data / 'journal.db'}")) as here, closing(Database(database_url)) as there:
        export(here, data / "all.zst")
        import_archive(there, data / "all.zst")
        one, other = Receipts(here, splits, key), Receipts(there, splits, key)
        for number in (0, 1, 2):
            assert one.of(HOST, RUN, number) == other.of(HOST, RUN, number)
        assert Corrections(there).on("tiny") == Corrections(here).on("tiny")
        assert len(Corrections(there).on("tiny")) == 2
        export(there, data / "again.zst")
    assert (data / "again.zst").read_bytes() == (data / "all.zst").read_bytes()
