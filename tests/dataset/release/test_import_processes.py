"""Import of the release on several processes: the same files for any number, and errors."""

from pathlib import Path

import pytest

from arramon_dataset.release import importer
from arramon_dataset.release.importer import import_release
from arramon_server.errors import BadInput

SAMPLE = Path(__file__).parents[3] / "examples" / "sample"


def test_several_processes_import_the_same_bytes_as_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importer, "EPISODES_A_PROCESS", 1)
    files = [SAMPLE / "sample.json", SAMPLE / "sample_hindi.json"]
    (one,) = import_release(files, tmp_path / "one", jobs=1)
    (two,) = import_release(files, tmp_path / "two", jobs=2)
    assert len(one.sections) == 2
    written = {path.relative_to(tmp_path / "one"): path.read_bytes() for path in (tmp_path / "one").rglob("*.json*")}
    assert len(written) > 2
    assert {name: (tmp_path / "two" / name).read_bytes() for name in written} == written
    assert two.data_hash == one.data_hash


def test_a_number_of_processes_out_of_range_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="the number of jobs is 1000; expected 1 to 256"):
        import_release([SAMPLE / "sample.json"], tmp_path, jobs=1000)
    assert not any(tmp_path.iterdir())
