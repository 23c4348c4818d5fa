"""`arramon-server show`: the pictures and instructions that it writes, and its errors."""

from pathlib import Path

import pytest
from PIL import Image

from arramon_dataset.pictures import show
from arramon_server.errors import NotFound, StorageError
from tests import tiny
from tests.forked import run

NAMES = ("map.png", "views.png", "instructions.txt")


@pytest.fixture
def data(tmp_path: Path) -> Path:
    tiny.write(tmp_path / "data", "one", 2)
    tiny.write(tmp_path / "data", "two", 4)
    return tmp_path / "data"


def test_show_writes_map_contact_sheet_and_instructions(data: Path, tmp_path: Path) -> None:
    output = tmp_path / "not" / "there"
    paths = show(data, "1", None, output)
    assert [path.name for path in paths] == [f"one-1-{name}" for name in NAMES]
    assert {path.parent for path in paths} == {output}
    sizes = []
    for path in paths[:2]:
        with Image.open(path) as picture:
            assert (picture.format, picture.mode) == ("PNG", "RGB")
            sizes.append(picture.size)
    assert sizes == [(832, 832 + 4 * 130 + 2 * (29 + 8)), (8 * 228, 4 * (48 + 236))]  # each part has a title and a gap
    assert paths[2].read_text(encoding="utf-8").splitlines() == [
        "en, turn 1, navigation: Go on to the striped red mug.",
        "en, turn 1, assembly: Put it two steps ahead.",
        "en, turn 2, navigation: Go on to the striped red mug.",
        "en, turn 2, assembly: Put it two steps ahead.",
        "hi, turn 1, navigation: धारीदार लाल मग तक चलें।",
        "hi, turn 1, assembly: उसे दो क़दम आगे रखें।",
        "hi, turn 2, navigation: धारीदार लाल मग तक चलें।",
        "hi, turn 2, assembly: उसे दो क़दम आगे रखें।",
    ]


def test_output_for_the_same_episode_is_identical(data: Path, tmp_path: Path) -> None:
    one, other = (show(data, "0", None, tmp_path / name) for name in ("a", "b"))
    assert [path.read_bytes() for path in one] == [path.read_bytes() for path in other]


@pytest.mark.parametrize(
    ("episode_id", "split", "found"), [("1", None, "one"), ("3", None, "two"), ("1", "two", "two")]
)
def test_episode_is_taken_from_the_named_or_first_matching_split(
    data: Path, tmp_path: Path, episode_id: str, split: str | None, found: str
) -> None:
    assert show(data, episode_id, split, tmp_path)[0].name == f"{found}-{episode_id}-map.png"


@pytest.mark.parametrize(
    ("episode_id", "split", "said"),
    [
        ("9", None, "there is no episode '9' in one, two"),
        ("3", "one", "there is no episode '3' in one"),
        ("../1", "one", "there is no episode '../1' in one"),
        ("1", "three", "there is no split 'three'; there are one, two"),
    ],
)
def test_missing_episodes_and_splits_are_reported(
    data: Path, tmp_path: Path, episode_id: str, split: str | None, said: str
) -> None:
    with pytest.raises(NotFound) as error:
        show(data, episode_id, split, tmp_path / "output")
    assert str(error.value) == said
    assert not (tmp_path / "output").exists()


def test_unwritable_output_folder_is_reported(data: Path, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(StorageError, match=r"cannot write .*/file"):
        show(data, "1", None, tmp_path / "file")


def test_show_command_prints_written_files_or_the_error(data: Path, tmp_path: Path) -> None:
    done = run("show", "1", "--data", data, "--split", "two", "--output", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split() == [
        str(tmp_path / "out" / f"two-1-{n}") for n in ("map.png", "views.png", "instructions.txt")
    ]
    failed = run("show", "9", "--data", data)
    assert (failed.returncode, failed.stdout) == (1, "")
    assert "there is no episode '9' in one, two" in failed.stderr
