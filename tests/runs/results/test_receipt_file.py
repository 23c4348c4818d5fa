"""Rescoring of a receipt's file with a run's actions, without the journal."""

import json
from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from arramon_server.board.corrector import Corrector
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadFile, Conflict, NotFound
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.play.worlds import Worlds
from arramon_server.runs.results import receipt_file
from arramon_server.runs.results.receipt_file import rescore_file
from arramon_server.runs.results.receipts import Receipts, receipt_content
from arramon_server.runs.results.reports import make_report
from arramon_server.runs.results.rescoring import RescoringResult
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from tests import tiny
from tests.played import STEPS, play

PLAYED = {"0": tiny.ACTIONS, "1": (0,) * (4 * STEPS), "2": (0, 0, 3), "3": (), "4": (0, 0), "5": ()}
CUT = {"2": "TIME_LIMIT", "3": "TIME_LIMIT", "4": "FORFEITED", "5": "SERVER_FAULT"}


class Files:
    """A receipt's file and one with the actions, both of a run with every cause."""

    def __init__(self, folder: Path, *, hidden: bool) -> None:
        self.split = tiny.write(folder, hidden=hidden)
        self.key = SigningKey(folder / "key.pem")
        self.receipt, self.actions = folder / "r.receipt.json", folder / "r.actions.json"
        with closing(Database(f"sqlite:///{folder / 'journal.db'}")) as database:
            play(database, self.split, actions=PLAYED, ended=CUT)
            receipt = Receipts(database, {"tiny": self.split}, self.key).of(HOST, "r")
            journal = Journal(database)
            taken = {name: "".join(map(str, journal.actions("r", name))) for name in PLAYED}
        self.payload = receipt.payload
        self.write(receipt.payload, taken)

    def write(self, payload: bytes, actions: dict[str, str], run_id: str = "r") -> None:
        """Write both files, with a valid signature."""
        content = {
            "format": "arramon-receipt-file",
            "version": 1,
            "payload": payload.decode(),
            "signature": self.key.sign(payload).hex(),
            "public_key": self.key.public.hex(),
        }
        self.receipt.write_text(json.dumps(content))
        self.actions.write_text(json.dumps({"run": {"run_id": run_id}, "actions": actions}))

    def taken(self) -> dict[str, str]:
        found: dict[str, str] = json.loads(self.actions.read_text())["actions"]
        return found

    def signed(self, change: Callable[[dict[str, Any]], object]) -> None:
        """Alter the receipt and sign it again, as a dishonest host."""
        content = json.loads(self.payload)
        change(content)
        self.write(json.dumps(content).encode(), self.taken())

    def rescore(self, *splits: Split) -> RescoringResult:
        return rescore_file(self.receipt, self.actions, {split.name: split for split in splits or (self.split,)})


@pytest.fixture(params=[False, True], ids=["open", "hidden"])
def files(tmp_path: Path, request: pytest.FixtureRequest) -> Files:
    return Files(tmp_path, hidden=request.param)


def test_an_unchanged_receipt_is_rescored_identically(files: Files) -> None:
    assert files.rescore() == RescoringResult("r", 6, 13 + 4 * STEPS + 3 + 2, True, (), files.key.public.hex())


def test_a_receipt_with_void_episodes_is_rescored_identically(files: Files, tmp_path: Path) -> None:
    splits = {"tiny": files.split}
    with closing(Database(f"sqlite:///{tmp_path / 'journal.db'}")) as database:
        Corrector(database, splits, files.key).void("tiny", ["0"], "a wall in the way")
        payload = Receipts(database, splits, files.key).of(HOST, "r").payload
    before, after = json.loads(files.payload), json.loads(payload)
    assert (after["version"], after["voided"]) == (before["version"], ["0"])
    files.write(payload, files.taken())
    assert files.rescore().differences == ()
    files.write(json.dumps({**after, "voided": ["1"]}).encode(), files.taken())
    assert any(line.startswith("receipt: scores: ") for line in files.rescore().differences)


def test_actions_that_came_after_an_episodes_end_do_not_count(files: Files) -> None:
    files.write(files.payload, {**files.taken(), "4": "0033"})
    assert files.rescore().differences == ()


def test_what_the_host_signed_wrongly_is_found(files: Files) -> None:
    def better(content: dict[str, Any]) -> None:
        content["scores"]["total"]["PTC"]["mean"] = 0.9

    files.signed(better)
    (line,) = files.rescore().differences
    assert line.startswith("receipt: scores: total: PTC: mean was 0.9, and is ")


def test_other_actions_are_found(files: Files) -> None:
    files.write(files.payload, {**files.taken(), "4": "01"})
    assert any("head was" in line for line in files.rescore().differences)


def spoil(name: str, content: object) -> Callable[[Files], object]:
    return lambda files: getattr(files, name).write_text(
        content if isinstance(content, str) else json.dumps({**json.loads(getattr(files, name).read_text()), **content})  # type: ignore[dict-item]
    )


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (spoil("receipt", "{"), "r.receipt.json: is not JSON, or was truncated"),
        (spoil("receipt", "[]"), "is not a JSON object"),
        (spoil("receipt", {"version": 2}), "is not a receipt: expected the format 'arramon-receipt-file', version 1"),
        (spoil("receipt", {"signature": "00" * 64}), "was altered"),
        (spoil("receipt", {"payload": 7}), "was altered"),
        (lambda files: files.receipt.unlink(), "cannot be read"),
        (lambda files: files.signed(lambda content: content.pop("limits")), "does not have the fields of a receipt"),
        (lambda files: files.signed(lambda content: content.update(version=3)), "contains no 'arramon-receipt'"),
        (
            lambda files: files.write(files.payload, {"0": "03"}),
            "lacks the actions of 3 episodes, the first one is '1'",
        ),
        (
            lambda files: files.write(files.payload, {}, "s"),
            "has the actions of run 's', but the receipt is for run 'r'",
        ),
        (lambda files: files.write(files.payload, {"0": "04"}), r"actions\.0: is no text of the digits 0 to 3"),
        (spoil("actions", {"actions": 3}), "has no actions: expected a download"),
    ],
)
def test_files_that_do_not_fit_are_refused(tmp_path: Path, change: Callable[[Files], object], problem: str) -> None:
    files = Files(tmp_path, hidden=True)
    change(files)
    with pytest.raises(BadFile, match=problem):
        files.rescore()


def test_other_data_is_refused(files: Files, tmp_path: Path) -> None:
    with pytest.raises(Conflict, match="which now has the data"):
        files.rescore(tiny.write(tmp_path / "other", count=5))
    with pytest.raises(Conflict, match="no longer exists"):
        files.rescore(tiny.write(tmp_path / "other", "another"))


def test_a_hidden_receipt_of_an_earlier_release_is_compared_with_exact_scores(tmp_path: Path) -> None:
    files = Files(tmp_path, hidden=True)
    with closing(Database(f"sqlite:///{tmp_path / 'journal.db'}")) as database:
        journal = Journal(database)
        run, endings = journal.run("r"), journal.endings("r")
        report = make_report(run, journal.progress("r"), endings, files.split, "", exact=True)
        old = receipt_content(journal.actions, report, endings, hidden=True, masked=False)
    assert (old["version"], "scores" in old["episodes"][0], "steps" in old["episodes"][0]) == (1, False, True)
    files.write(json.dumps(old).encode(), files.taken())
    assert files.rescore().differences == ()
    assert old["scores"] != json.loads(files.payload)["scores"]


def values_of(content: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """The paths of everything in a receipt."""
    yield from [path] if path else []
    for key, value in content.items() if isinstance(content, dict) else enumerate(content[:1]):
        yield from values_of(value, (*path, key)) if isinstance(value, dict | list) else [(*path, key)]


def replaced(content: Any, path: tuple[str | int, ...], value: object) -> None:
    for key in path[:-1]:
        content = content[key]
    content[path[-1]] = value


@pytest.mark.parametrize("value", [None, 7, -1, 1e300, 1 << 60, "\ud800", "\x1b[2J", [], {}, [[]], {"a": 1}, True])
def test_a_receipt_that_a_stranger_signed_is_refused_or_differs_whatever_it_has(
    tmp_path: Path, value: object, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    files = Files(tmp_path, hidden=False)
    worlds = Worlds({files.split.name: files.split})  # built once: the split stays the same
    request.addfinalizer(worlds.close)
    monkeypatch.setattr(receipt_file, "Worlds", lambda _splits: SimpleNamespace(world=worlds.world, close=int))
    content = json.loads(files.payload)
    paths = [path for path in values_of(content) if path[0] not in ("format", "version")]
    assert len(paths) > 40
    for path in paths:
        files.signed(partial(replaced, path=path, value=value))
        try:
            found = files.rescore().differences
        except (BadFile, Conflict, NotFound):
            continue
        written = json.loads(files.payload)
        assert found or path[0] == "attempts" or written == content, path
        assert all(isinstance(line, str) for line in found)
