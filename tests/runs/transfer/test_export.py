"""Export and import between databases: complete and unchanged, or not at all."""

import hashlib
import json
import stat
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa
import zstandard

from arramon_server.episodes.splits import Split
from arramon_server.errors import BadFile, Conflict, StorageError
from arramon_server.runs.accounts.accounts import Accounts
from arramon_server.runs.accounts.callers import HOST, Role
from arramon_server.runs.results.receipts import Receipts
from arramon_server.runs.results.rescoring import Rescorer
from arramon_server.runs.results.signing import KnownKeys, SigningKey
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.transfer.archive import EXPORTED_TABLES
from arramon_server.runs.transfer.export import export
from arramon_server.runs.transfer.restore import ImportCounts, import_archive
from tests import tiny
from tests.collecting import collecting
from tests.played import play
from tests.postgres import Cluster

NOW = datetime(2026, 5, 6, 7, 8, 9, 123456, tzinfo=UTC)


@pytest.fixture(scope="module")
def split(tmp_path_factory: pytest.TempPathFactory) -> Split:
    return tiny.write(tmp_path_factory.mktemp("data"), count=3)


@pytest.fixture(scope="module")
def key(tmp_path_factory: pytest.TempPathFactory) -> SigningKey:
    return SigningKey(tmp_path_factory.mktemp("key") / "key.pem")


def fill(database: Database, split: Split, key: SigningKey) -> str:
    """Fill every table; return the token of the participant."""
    token = Accounts(database).create_token("lab", Role.PARTICIPANT, note="für Übung")
    KnownKeys(database).check(key.public)
    play(database, split, "Done", account="lab")
    play(database, split, "cut", actions={"0": tiny.ACTIONS, "1": (0, 0)}, ended={"1": "FORFEITED"})
    play(database, split, "half", actions={"0": tiny.ACTIONS, "1": (0, 0, 3), "2": ()}, over=False)
    journal = Journal(database)
    journal.record_image_format("half", "lossless-224")
    journal.beat("worker", "127.0.0.1:1")
    Receipts(database, {"tiny": split}, key).of(HOST, "Done")
    with database.write() as connection:
        note = {"run_id": "Done", "episode_id": "0", "step": 0, "note": "बाईं ओर\n{}"}
        connection.execute(tables.step_notes.insert(), [note])
        quota = {"participant": "lab", "split": "tiny", "runs_per_day": 2}
        connection.execute(tables.quotas.insert(), [quota])
        entry = {"run_id": "Done", "published_at": NOW, "note": "हिन्दी", "scores": {"z": 0.1, "a": 1e-17}}
        connection.execute(tables.entries.insert(), [entry])
        epoch = {"split": "tiny_e1", "statement": b"{}", "opened_at": NOW, "closed_at": NOW, "secret": "0" * 64}
        connection.execute(tables.epochs.insert(), [epoch])
        connection.execute(tables.earlier_names.insert(), [{"name": "Lav", "participant": "lab", "until": NOW}])
        pruned = {"run_id": "gone", "account": "lab", "participant": "lab", "split": "tiny", "language": "hi"}
        connection.execute(tables.pruned_runs.insert(), [{**pruned, "created_at": NOW, "had_fault": True}])
        correction = {"correction_id": "c" * 32, "split": "tiny_e1", "number": 1, "kind": "void", "made_at": NOW}
        connection.execute(tables.corrections.insert(), [correction | {"reason": "कारण", "episodes": ["0"]}])
        connection.execute(tables.rescored_runs.insert(), [{"run_id": "cut", "correction_id": "c" * 32}])
        old = {
            "run_id": "cut",
            "number": 1,
            "superseded_at": NOW,
            "payload": b"{}",
            "signature": b"",
            "public_key": b"",
        }
        connection.execute(tables.superseded_receipts.insert(), [old])
    collecting.fill(database)
    return token


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory, split: Split, key: SigningKey) -> Path:
    """Return an export of a filled database."""
    folder = tmp_path_factory.mktemp("export")
    with closing(Database(f"sqlite:///{folder / 'journal.db'}")) as database:
        fill(database, split, key)
        export(database, folder / "file")
    return folder / "file"


@pytest.fixture
def other(tmp_path: Path) -> Iterator[Database]:
    """Return an empty database to import into."""
    with closing(Database(f"sqlite:///{tmp_path / 'other.db'}", fsync=False)) as database:
        yield database


@pytest.fixture
def make(cluster: Cluster, tmp_path: Path) -> Iterator[Callable[[str], Database]]:
    """Return a factory of empty databases of a kind."""
    made: list[Database] = []

    def new(kind: str) -> Database:
        url = f"sqlite:///{tmp_path / f'new-{len(made)}.db'}" if kind == "sqlite" else cluster.create()
        made.append(Database(url))
        return made[-1]

    yield new
    for database in made:
        database.close()


def lines(path: Path) -> list[bytes]:
    with path.open("rb") as file:
        return zstandard.ZstdDecompressor().stream_reader(file).read().splitlines(keepends=True)


def write(path: Path, content: list[bytes]) -> Path:
    """Write lines as an export, with a new closing line."""
    rows = sum(line.startswith(b"[") for line in content[:-1])
    digest = hashlib.sha256(b"".join(content[:-1])).hexdigest()
    end = json.dumps({"end": True, "rows": rows, "sha256": digest}).encode() + b"\n"
    path.write_bytes(zstandard.compress(b"".join([*content[:-1], end])))
    return path


def is_empty(database: Database) -> bool:
    return not any(database.read(sa.select(sa.literal(1)).select_from(table)) for table in EXPORTED_TABLES)


def test_every_table_is_exported_or_excluded_explicitly() -> None:
    left = {"workers", "streams", "service_clock", "collection_sign_ins"}
    assert {table.name for table in EXPORTED_TABLES} | left == set(tables.metadata.tables)
    order = [table.name for table in tables.metadata.sorted_tables]
    for table in EXPORTED_TABLES:
        needs = {key.column.table for key in table.foreign_keys}
        assert all(EXPORTED_TABLES.index(need) < EXPORTED_TABLES.index(table) for need in needs), order


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_exporting_an_import_gives_the_same_bytes(
    database_url: str, make: Callable[[str], Database], split: Split, key: SigningKey, tmp_path: Path, kind: str
) -> None:
    full = Database(database_url)
    with closing(full):
        token = fill(full, split, key)
        check_carried(full, make(kind), token, split, key, tmp_path)


def check_carried(full: Database, other: Database, token: str, split: Split, key: SigningKey, tmp_path: Path) -> None:
    file, again = tmp_path / "one.jsonl.zst", tmp_path / "two.jsonl.zst"
    rows = export(full, file)
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert import_archive(other, file) == ImportCounts(rows, 0)
    assert export(other, again) == rows
    assert again.read_bytes() == file.read_bytes()
    for table in EXPORTED_TABLES:
        assert len(other.read(sa.select(table))) == len(full.read(sa.select(table))) > 0, table.name

    journal, there = Journal(full), Journal(other)
    for run_id in ("Done", "cut", "half"):
        assert there.run(run_id) == journal.run(run_id)
        assert there.progress(run_id) == journal.progress(run_id)
        assert there.endings(run_id) == journal.endings(run_id)
    scores = [list(turn) for turn in there.endings("Done")[0].scores]
    assert scores == [list(turn) for turn in journal.endings("Done")[0].scores]  # in their order, too
    assert Accounts(other).caller(token).account == "lab"
    receipts = Receipts(other, {"tiny": split}, SigningKey(tmp_path / "other.pem"))
    assert receipts.of(HOST, "Done") == Receipts(full, {"tiny": split}, key).of(HOST, "Done")
    with closing(Rescorer(other, {"tiny": split})) as rescorer:
        assert rescorer.rescore("Done").differences == rescorer.rescore("cut").differences == ()
    assert list(other.read(sa.select(tables.entries.c.scores))[0].scores.items()) == [("z", 0.1), ("a", 1e-17)]
    # Nobody at the new host has the open episodes, so that the run goes on at once.
    assert {claim.worker for claim in journal.open_claims("half")} == {"worker"}
    assert {claim.worker for claim in there.open_claims("half")} == {None}


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_a_second_import_changes_nothing(file: Path, make: Callable[[str], Database], kind: str) -> None:
    database = make(kind)
    rows = import_archive(database, file).added
    assert rows == sum(line.startswith(b"[") for line in lines(file))
    assert import_archive(database, file) == ImportCounts(0, rows)


def test_import_into_a_database_with_runs_requires_merge(file: Path, other: Database, split: Split) -> None:
    play(other, split, "own")
    message = "the journal has runs already, but not participants lab of the file; add missing rows with `--merge`"
    with pytest.raises(Conflict, match=message):
        import_archive(other, file)
    assert len(other.read(sa.select(tables.participants))) == 0
    assert import_archive(other, file, merge=True) == ImportCounts(
        sum(line.startswith(b"[") for line in lines(file)), 0
    )
    assert {run.run_id for run in Journal(other).runs(9)} == {"own", "Done", "cut", "half"}


@pytest.mark.parametrize("merge", [True, False])
def test_differing_rows_are_refused_and_named(file: Path, other: Database, merge: bool) -> None:
    import_archive(other, file)
    with other.write() as connection:
        connection.execute(tables.steps.delete().where(tables.steps.c.run_id == "cut", tables.steps.c.step > 5))
        row = {"run_id": "cut", "episode_id": "0", "step": 7, "action": 0}
        connection.execute(tables.steps.insert(), [row])
    before = other.read(sa.select(tables.steps))
    message = "the journal has steps cut, 0, 7 already, with a different action than the file"
    if not merge:
        message = "the journal has runs already, but not steps cut, 0, 6 of the file|" + message
    with pytest.raises(Conflict, match=message):
        import_archive(other, file, merge=merge)
    assert other.read(sa.select(tables.steps)) == before


@pytest.mark.parametrize("keep", [0, 1, 40, 0.5, 0.9, -1])
def test_truncated_file_is_refused(file: Path, other: Database, tmp_path: Path, keep: float) -> None:
    whole = file.read_bytes()
    cut = tmp_path / "cut"
    cut.write_bytes(whole[: int(keep * len(whole)) if isinstance(keep, float) else keep])
    with pytest.raises(BadFile, match=r"is truncated|is not a Zstandard file"):
        import_archive(other, cut)
    assert is_empty(other)


def without_end(content: list[bytes]) -> list[bytes]:
    return content[:-1]


def changed(content: list[bytes]) -> list[bytes]:
    return [line.replace(b"AGENT_FINISHED", b"TIME_LIMIT") for line in content]


def lengthened(content: list[bytes]) -> list[bytes]:
    return [*content, b"[]\n"]


def shortened(content: list[bytes]) -> list[bytes]:
    return [*content[:20], *content[21:]]


@pytest.mark.parametrize(("damage", "problem"), [
    (without_end, "is truncated: its closing line is missing"),
    (changed, "has the wrong checksum: the file was changed"),
    (shortened, "has the wrong checksum: the file was changed"),
    (lengthened, "has data after its closing line"),
    (lambda _: [b"{}\n"], "is not an export: expected the format 'arramon-export' in its first line"),
    (lambda _: [b"hello\n"], "is not JSON"),
    (lambda _: [b'{"format":"arramon-export","version":2}\n'], "version: is 2, expected 1"),
])  # fmt: skip
def test_damaged_file_is_refused(
    file: Path, other: Database, tmp_path: Path, damage: Callable[[Any], Any], problem: str
) -> None:
    bad = tmp_path / "bad"
    bad.write_bytes(zstandard.compress(b"".join(damage(lines(file)))))
    with pytest.raises(BadFile, match=problem):
        import_archive(other, bad)
    assert is_empty(other)


@pytest.mark.parametrize(("old", "new", "problem"), [
    (b'"table":"quotas"', b'"table":"wishes"', "table: is 'wishes', a table unknown to this server"),
    (b'"split","language"', b'"split","dialect"', "columns: runs has no column 'dialect' in this server"),
    (b'"COMPLETE","2026', b'"COMPLETE","xx26', "is not a row of runs: Invalid isoformat string"),
    (b'["half","lossless', b'["half",7,"lossless', "is not a row of run_images with 2 values"),
])  # fmt: skip
def test_intact_file_with_incompatible_content_is_refused(
    file: Path, other: Database, tmp_path: Path, old: bytes, new: bytes, problem: str
) -> None:
    content = b"".join(lines(file))
    assert old in content
    bad = write(tmp_path / "bad", content.replace(old, new).splitlines(keepends=True))
    with pytest.raises(BadFile, match=problem):
        import_archive(other, bad)
    assert is_empty(other)


def test_columns_missing_from_older_exports_take_their_defaults(file: Path, other: Database, tmp_path: Path) -> None:
    content = lines(file)
    start = next(n for n, line in enumerate(content) if b'"table":"leaderboard_entries"' in line)
    head = json.loads(content[start])
    place = head["columns"].index("note")
    end = next(n for n in range(start + 1, len(content)) if content[n].startswith(b"{"))
    for number in range(start, end):
        line = json.loads(content[number])
        del (line["columns"] if number == start else line)[place]
        content[number] = json.dumps(line).encode() + b"\n"
    older = write(tmp_path / "older", content)
    import_archive(other, older)
    assert [row.note for row in other.read(sa.select(tables.entries.c.note))] == [""]
    import_archive(other, older)


def test_snapshot_for_an_export_ignores_later_writes(database_url: str, split: Split, tmp_path: Path) -> None:
    with closing(Database(database_url)) as database:
        play(database, split, "first", actions={"0": tiny.ACTIONS})
        with database.snapshot() as connection:
            counted = sa.select(sa.func.count()).select_from(tables.runs)
            assert connection.execute(counted).scalar() == 1
            play(database, split, "later", actions={"0": tiny.ACTIONS})
            assert connection.execute(counted).scalar() == 1
        export(database, tmp_path / "file")
    assert any(line.startswith(b'["later",') for line in lines(tmp_path / "file"))


def test_unwritable_and_unreadable_paths_are_reported(other: Database, tmp_path: Path) -> None:
    with pytest.raises(StorageError, match=r"cannot write .*/none/file: No such file or directory"):
        export(other, tmp_path / "none" / "file")
    (tmp_path / "folder").mkdir()
    with pytest.raises(StorageError, match=r"cannot write .*/folder: Is a directory"):
        export(other, tmp_path / "folder")
    with pytest.raises(BadFile, match="none: cannot be read: No such file or directory"):
        import_archive(other, tmp_path / "none")
    assert sorted(path.name for path in tmp_path.iterdir() if path.name.startswith(".")) == []
