"""Exports that are interrupted, that fill the disk, or whose folder contains other files."""

import resource
import subprocess
import sys
from pathlib import Path

import pytest

from arramon_dataset.demonstrations.export import ExportProgress
from arramon_dataset.demonstrations.folder import RECORD, WORK, ExportFolder, read_record
from arramon_server.errors import BadFile, BadInput, Conflict, StorageError
from tests.dataset.demonstrations.exports import contents, export

FORMATS = ("plain", "minari", "lerobot", "huggingface")


class Stop(Exception):
    """Ends an export from outside, as an interrupt does."""


@pytest.mark.parametrize("format_", FORMATS)
def test_an_interrupted_export_goes_on_to_the_same_files(
    data: Path, exports: dict[str, Path], tmp_path: Path, format_: str
) -> None:
    heard: list[ExportProgress] = []

    def stop(progress: ExportProgress) -> None:
        heard.append(progress)
        raise Stop

    with pytest.raises(Stop):
        export(data, tmp_path / "out", format_, on_progress=stop)
    assert (heard[0].parts, heard[0].export.parts) == (1, 3)
    kept = {name for name in contents(tmp_path / "out") if not name.startswith(WORK) and name != RECORD}
    assert kept
    (tmp_path / "out" / WORK / "new-00002-1").mkdir()  # As a process that was killed leaves it.
    (tmp_path / "out" / WORK / "new-00002-1" / "half").write_text("half")
    assert not read_record(tmp_path / "out")["complete"]

    again: list[ExportProgress] = []
    export(data, tmp_path / "out", format_, on_progress=again.append)

    assert [progress.parts for progress in again] == [2, 3]
    assert contents(tmp_path / "out") == contents(exports[format_])
    assert not (tmp_path / "out" / WORK).exists()


def test_a_complete_export_is_left_alone(data: Path, exports: dict[str, Path]) -> None:
    before = contents(exports["plain"])
    heard: list[ExportProgress] = []
    export(data, exports["plain"], "plain", on_progress=heard.append)
    assert heard == []
    assert contents(exports["plain"]) == before


def test_progress(data: Path, tmp_path: Path) -> None:
    heard: list[ExportProgress] = []
    export(data, tmp_path, "plain", on_progress=heard.append)
    assert [(each.parts, each.episodes, each.steps) for each in heard][-1] == (3, 10, 130)
    assert str(heard[-1]).startswith("tiny: 10 of 10 episodes, 130 steps, 0.0 of about 0.0 MB in 0:0")


def test_other_settings_are_refused(data: Path, exports: dict[str, Path]) -> None:
    with pytest.raises(Conflict, match="contains an export whose size is 32, not 64: expected the same settings"):
        export(data, exports["huggingface"], "huggingface", size=64)
    with pytest.raises(Conflict, match="whose format is 'plain', not 'minari'"):
        export(data, exports["plain"], "minari")


def test_foreign_folders_are_refused(data: Path, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(BadInput, match="contains other files than an export: expected a new or an empty folder"):
        export(data, tmp_path, "plain")
    (tmp_path / RECORD).write_text("{}")
    with pytest.raises(BadFile, match="is not the record of an export"):
        export(data, tmp_path, "plain")
    assert (tmp_path / "thesis.tex").read_text() == "mine"


def test_two_exports_cannot_write_to_one_folder(data: Path, tmp_path: Path) -> None:
    def begin_another(_: ExportProgress) -> None:
        with pytest.raises(Conflict, match="another export is writing to"):
            export(data, tmp_path, "plain")

    export(data, tmp_path, "plain", on_progress=begin_another)


@pytest.mark.parametrize("format_", FORMATS)
def test_a_full_disk_loses_nothing(data: Path, exports: dict[str, Path], tmp_path: Path, format_: str) -> None:
    """The operating system limits the size of files: every write beyond fails, as on a full disk."""
    _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)

    def fill(_: ExportProgress) -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (512, hard))

    try:
        with pytest.raises(StorageError) as caught:
            export(data, tmp_path / "out", format_, on_progress=fill)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
    said = str(caught.value)
    assert said.startswith(f"there is no room left in {tmp_path / 'out'} (File too large): 1 of 3 parts are finished")
    assert "the same command then goes on where this one ended" in said

    heard: list[ExportProgress] = []
    export(data, tmp_path / "out", format_, on_progress=heard.append)
    assert [each.parts for each in heard] == [2, 3]
    assert contents(tmp_path / "out") == contents(exports[format_])


def test_a_folder_that_cannot_be_made(data: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match=r"cannot write to .*: Not a directory"):
        export(data, tmp_path / "file" / "out", "plain")


def test_an_unknown_camera(data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ARRAMON_CAMERA", "obscura")
    with pytest.raises(BadInput, match="ARRAMON_CAMERA is 'obscura', expected one of raster, tiny"):
        export(data, tmp_path / "out", "minari")


def test_a_camera_that_is_not_installed(data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pybullet", None)
    monkeypatch.setenv("ARRAMON_CAMERA", "tiny")
    with pytest.raises(BadInput, match=r"ARRAMON_CAMERA is .tiny., which needs pybullet, .*arramon-server.pybullet."):
        export(data, tmp_path / "out", "plain")


@pytest.mark.slow
def test_processes_make_the_same_files(data: Path, exports: dict[str, Path], tmp_path: Path) -> None:
    export(data, tmp_path / "out", "huggingface", jobs=2)
    assert contents(tmp_path / "out") == contents(exports["huggingface"])


BASE = """
import sys
for name in ("gymnasium", "pettingzoo", "pyarrow", "pandas", "datasets", "minari", "mlcroissant"):
    sys.modules[name] = None
from server import cli
sys.exit(cli.main(sys.argv[1:]))
"""
"""The command line of an installation without any extra."""


def test_the_base_installation_exports_plain_and_says_what_the_others_need(data: Path, tmp_path: Path) -> None:
    def command(format_: str) -> "subprocess.CompletedProcess[str]":
        words = ["export-demos", "--data", str(data), "--split", "tiny", "--jobs", "1", "--format", format_]
        return subprocess.run(
            [sys.executable, "-c", BASE, *words, "--output", str(tmp_path / format_)],
            capture_output=True, text=True, check=False,
        )  # fmt: skip

    assert command("plain").stdout == f"{tmp_path / 'plain'}: 10 episodes with 130 steps in en, hi\n"
    done = command("minari")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == (
        "arramon-server: the format 'minari' needs gymnasium, minari, pyarrow, which this installation lacks; expected "
        "the libraries of the extra `demos`: pip install 'arramon-server[demos]'\n"
    )


def test_a_part_appears_at_once(tmp_path: Path) -> None:
    folder = ExportFolder(tmp_path / "out")
    assert folder.begin({"format": "plain"}) is False
    made = folder.scratch("00000")
    (made / "data").mkdir()
    (made / "data" / "file").write_text("text")
    assert folder.finished_parts() == {}
    folder.finish_part(0, made, {"size": 4, "content": {}})
    assert folder.finished_parts() == {0: {"size": 4, "content": {}}}
    assert (tmp_path / "out" / "data" / "file").read_text() == "text"
    assert not made.exists()
