"""Files from strangers: deep JSON, files that expand without end, wrong types. Each is an error that names it."""

import gzip
import hashlib
import json
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest
import zstandard

from arramon_server import cli
from arramon_server.episodes.split_files import MIN_DECOMPRESSED, read_bytes, read_json_object
from arramon_server.errors import BadFile
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.transfer.archive import columns_of
from arramon_server.runs.transfer.restore import import_archive
from tests import tiny

DEEP = "[" * 200_000
MIB = 1 << 20


@contextmanager
def memory(most: int) -> Iterator[None]:
    """Check that the block allocates at most so many bytes at once."""
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < most
    finally:
        tracemalloc.stop()


def bomb(start: bytes, repeated: bytes, thousands: int) -> bytes:
    """One Zstandard frame that repeats some bytes."""
    compressor = zstandard.ZstdCompressor(level=3).compressobj()
    parts = [compressor.compress(start), *(compressor.compress(repeated * 1000) for _ in range(thousands))]
    return b"".join(parts) + compressor.flush()


HEADER = b'{"format":"arramon-export","version":1}\n'


@pytest.mark.parametrize(
    ("start", "repeated", "problem"),
    [
        (b"", b" " * 1024, "has more than 16 MiB, more than any row"),
        (HEADER, b"[" * 1024, "has more than 16 MiB, more than any row"),
        (HEADER, b"[]\n", "bomb:2: is not the name of a table"),
        (HEADER + b'{"table":"runs","columns":["run_id"]}\n', b"[]\n", "bomb:3: is not a row of runs with 1 values"),
        (
            HEADER + b'{"table":"runs","columns":["run_id"]}\n',
            b'["%s"]\n' % (b"a" * 600),
            "expands to more than 1000 times its",
        ),
    ],
)
def test_an_import_of_a_file_that_expands_without_end_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, start: bytes, repeated: bytes, problem: str
) -> None:
    monkeypatch.setattr("arramon_server.runs.transfer.archive._MIN_SIZE", MIB)
    file = tmp_path / "bomb"
    file.write_bytes(bomb(start, repeated, 100))
    with (
        closing(Database(f"sqlite:///{tmp_path / 'j.db'}")) as database,
        memory(80 * MIB),
        pytest.raises(BadFile, match=problem),
    ):
        import_archive(database, file)


def test_a_gzip_file_that_expands_without_end_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "episodes.jsonl.gz"
    file.write_bytes(gzip.compress(b" " * (5 * MIN_DECOMPRESSED), 6))
    assert file.stat().st_size < MIB
    with memory(2 * MIN_DECOMPRESSED), pytest.raises(BadFile, match="MiB when it is decompressed, far more than"):
        read_bytes(file)


@pytest.mark.parametrize("cut", [0, 5, 30])
def test_gzip_files_are_read_whole_or_refused(tmp_path: Path, cut: int) -> None:
    file, content = tmp_path / "a.gz", b'{"a": 1}' * 1000
    whole = gzip.compress(content[:3000]) + gzip.compress(content[3000:])
    file.write_bytes(whole[: len(whole) - cut])
    if cut:
        with pytest.raises(BadFile, match="cannot be decompressed"):
            read_bytes(file)
    else:
        assert read_bytes(file) == content


def test_files_of_usual_data_are_far_from_the_bounds(tmp_path: Path) -> None:
    """Steps are what compresses best in an export."""
    from arramon_server.runs.transfer.archive import _MAX_RATIO, _MIN_SIZE, ArchiveWriter

    file = tmp_path / "file"
    with file.open("wb") as out:
        writer = ArchiveWriter(out)
        with writer.frame():
            writer.write({"table": "steps", "columns": columns_of(tables.steps)})
            for episode in range(300):
                for step in range(500):
                    writer.write(["f" * 32, str(episode), step, 0])
    with file.open("rb") as compressed, zstandard.ZstdDecompressor().stream_reader(compressed) as stream:
        size = len(stream.read())
    assert size / file.stat().st_size < _MAX_RATIO / 5
    assert _MIN_SIZE >= 64 * MIB


def archive(file: Path, *lines: Any) -> Path:
    """An export with these lines, raw ones as bytes, and a valid closing line."""
    body = HEADER + b"".join(line if isinstance(line, bytes) else json.dumps(line).encode() + b"\n" for line in lines)
    rows = sum(isinstance(line, list) for line in lines)
    end = {"end": True, "rows": rows, "sha256": hashlib.sha256(body).hexdigest()}
    file.write_bytes(zstandard.compress(body + json.dumps(end).encode() + b"\n"))
    return file


PEOPLE = {"table": "participants", "columns": ["participant", "role", "created_at"]}
AT = "2026-01-01T00:00:00+00:00"


@pytest.mark.parametrize(
    ("lines", "problem"),
    [
        ([DEEP.encode() + b"\n"], "file:2: is nested more than 64 levels deep"),
        ([("[" * 65 + "]" * 65).encode() + b"\n"], "file:2: is nested more than 64 levels deep"),
        ([b"NaN\n"], "file:2: has the number NaN"),
        ([{"table": ["runs"], "columns": []}], "file:2: table: is .*a table unknown"),
        ([{"table": "x" * 10_000, "columns": []}], r"file:2: table: is 'x{100}'\.\.\. \(10000 characters\)"),
        ([{"table": "runs", "columns": [[]]}], r"file:2: columns: runs has no column '\[\]'"),
        ([{"table": "runs", "columns": ["agent"]}], "file:2: columns: lacks 'run_id', which identifies a row"),
        ([{"table": "runs", "columns": ["run_id", "run_id"]}], "file:2: columns: names a column twice"),
        ([PEOPLE, [1, "host", AT]], "file:3: is not a row of participants: participant is '1', expected a text"),
        ([PEOPLE, [["a"], "host", AT]], "file:3: is not a row of participants: participant is .*expected a text"),
        ([PEOPLE, ["\ud800", "host", AT]], "file:3: is not a row of participants: "),
        ([PEOPLE, ["a", "host", 5]], "file:3: is not a row of participants: "),
        ([PEOPLE, ["a", "host"]], "file:3: is not a row of participants with 3 values"),
        ([PEOPLE, 5], "file:3: is not a row of participants with 3 values"),
        (
            [{"table": "quotas", "columns": ["participant", "split", "runs_per_day"]}, ["a", "s", 1 << 70]],
            "file:3: is not a row of quotas: runs_per_day is 1180591620717411303424, expected at most 2147483647",
        ),
        (
            [{"table": "quotas", "columns": ["participant", "split", "runs_per_day"]}, ["a", "s", True]],
            "file:3: is not a row of quotas: runs_per_day is 'True', expected a whole number",
        ),
        (
            [{"table": "quotas", "columns": ["participant", "split", "runs_per_day"]}, ["a", "s", 1]],
            "file: has rows that do not fit together: ",
        ),
    ],
)
def test_malformed_archives_are_refused_and_change_nothing(
    tmp_path: Path, database_url: str, lines: list[Any], problem: str
) -> None:
    with closing(Database(database_url)) as database:
        with pytest.raises(BadFile, match=problem):
            import_archive(database, archive(tmp_path / "file", *lines))
        assert not database.read(tables.participants.select())


@pytest.mark.parametrize("text", [DEEP, DEEP.replace("[", '{"a":'), '{"a": ' + DEEP + "}", "\ufeff" + DEEP, "[1e999]"])
def test_deep_or_broken_objects_are_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "file.json"
    file.write_text(text)
    with pytest.raises(BadFile, match=r"file\.json: (is nested|is not JSON|has a number)"):
        read_json_object(file)


def episodes(data: Path) -> Path:
    return data / "splits" / "tiny" / "episodes.jsonl"


def deepened(text: str) -> str:
    """The same lines, the second one with a deep value."""
    header, first, *rest = text.splitlines(keepends=True)
    return "".join((header, first.rstrip()[:-1] + ', "x": ' + DEEP + "}\n", *rest))


COMMANDS: dict[str, tuple[list[str], Callable[[Path], object]]] = {
    "rescore a receipt": (
        ["rescore", "--receipt", "file", "--actions", "file"],
        lambda data: (data.parent / "file").write_text(DEEP),
    ),
    "verify an epoch": (
        ["epoch", "verify", "file", "tiny_e1"],
        lambda data: (data.parent / "file").write_text(DEEP),
    ),
    "import": (["import", "file"], lambda data: archive(data.parent / "file", DEEP.encode() + b"\n")),
    "import, no export": (["import", "file"], lambda data: (data.parent / "file").write_text(DEEP)),
    "import of a release": (["import-release", "file.json"], lambda data: (data.parent / "file.json").write_text(DEEP)),
    "episodes": (["show", "0"], lambda data: episodes(data).write_text(deepened(episodes(data).read_text()))),
    "a header": (["quota", "anonymous", "tiny"], lambda data: episodes(data).write_text(DEEP + "\n")),
    "a section": (
        ["show", "0"],
        lambda data: (data / "splits" / "tiny" / "sections" / "1.json").write_text(DEEP),
    ),
    "demands": (["show", "0"], lambda data: (data / "splits" / "tiny" / "demands.json").write_text(DEEP)),
    "settings": (["config", "--config", "file"], lambda data: (data.parent / "file").write_text("steps = " + DEEP)),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_no_command_ends_with_a_traceback(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    arguments, prepare = COMMANDS[name]
    data = tmp_path / "data"
    tiny.write(data)
    prepare(data)
    monkeypatch.chdir(tmp_path)
    assert cli.main([*arguments, "--data", "data"]) == 1
    said = capsys.readouterr().err
    assert said.startswith("arramon-server: ")
    assert len(said) < 1000


def test_errors_about_files_do_not_control_the_terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    tiny.write(tmp_path / "data")
    archive(tmp_path / "file", PEOPLE, ["a\x1b[2J", "\x9b2J", 5])
    archive(tmp_path / "twice", PEOPLE, ["a\x1b[2J\u202e", "host", AT], ["a\x1b[2J\u202e", "host", AT])
    for file in ("file", "twice"):
        assert cli.main(["import", file, "--data", "data"]) == 1
        said = capsys.readouterr().err
        assert not {"\x1b", "\x9b", "\u202e"} & set(said)
