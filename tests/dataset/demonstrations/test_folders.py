"""Exports to relative folders, and to folders with spaces or Hindi in their names."""

from pathlib import Path

import minari
import pytest

from arramon_client.demonstrations import Demonstrations
from arramon_dataset.demonstrations.request import FORMATS
from arramon_server import cli
from tests.dataset.demonstrations.exports import contents, export

NAMES = ("out", "my data/the first export", "प्रदर्शन/पहला", "../beside")


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("format_", FORMATS)
def test_a_relative_folder(
    data: Path, exports: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, format_: str, name: str
) -> None:
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    export(data, Path(name), format_)
    assert contents(tmp_path / "work" / name) == contents(exports[format_])
    places = {path.name for path in tmp_path.iterdir()} | {path.name for path in (tmp_path / "work").iterdir()}
    assert places == {"work", Path(name).parts[-1 if name.startswith("..") else 0]}


@pytest.mark.parametrize("format_", FORMATS)
def test_the_default_folder_of_the_command(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], format_: str
) -> None:
    (tmp_path / "डेटा फ़ोल्डर").symlink_to(data)
    monkeypatch.chdir(tmp_path)
    small = [] if format_ == "plain" else ["--size", "16", "--sensors", "rgb"]
    command_line = [
        "export-demos",
        "--data",
        "डेटा फ़ोल्डर",
        "--split",
        "tiny",
        "--format",
        format_,
        "--jobs",
        "2",
        *small,
    ]
    assert cli.main(command_line) in (0, None)
    folder = Path("demonstrations") / f"tiny-{format_}"
    assert capsys.readouterr().out == f"{folder}: 10 episodes with 130 steps in en, hi\n"
    assert (tmp_path / folder / "demonstrations.json").is_file()
    assert {path.name for path in tmp_path.iterdir()} == {"demonstrations", "डेटा फ़ोल्डर"}


def test_they_are_read_from_relative_folders(data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    export(data, Path("मेरा डेटा/minari"), "minari")
    export(data, Path("मेरा डेटा/plain"), "plain")
    monkeypatch.setenv("MINARI_DATASETS_PATH", "मेरा डेटा/minari")
    assert minari.load_dataset("arramon/tiny-hi-v0").total_episodes == 4
    assert len(Demonstrations(Path("मेरा डेटा/plain"))) == 6
