"""The Croissant files, validated and read by `mlcroissant`."""

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.dataset.demonstrations.exports import playing_order

if TYPE_CHECKING:
    import mlcroissant

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")  # in what mlcroissant uses

RECOMMENDED = "is recommended, but does not exist"


def read(export: Path) -> "mlcroissant.Dataset":
    import mlcroissant  # takes a second, which no process is to spend that has none of these tests

    return mlcroissant.Dataset(jsonld=str(export / "croissant.json"))


@pytest.mark.parametrize("format_", ["plain", "minari", "lerobot", "huggingface"])
def test_it_is_valid(exports: dict[str, Path], format_: str) -> None:
    dataset = read(exports[format_])
    issues = dataset.metadata.ctx.issues
    assert issues.errors == set()
    assert all(RECOMMENDED in warning for warning in issues.warnings)
    assert dataset.metadata.name == f"arramon-tiny-{format_}"
    assert "data" in dataset.metadata.description


@pytest.mark.parametrize(
    ("format_", "records", "field"),
    [
        ("plain", "demonstrations", "episode_id"),
        ("huggingface", "hi", "instruction"),
        ("lerobot", "steps", "action"),
    ],
)
def test_its_records_can_be_read(data: Path, exports: dict[str, Path], format_: str, records: str, field: str) -> None:
    dataset = read(exports[format_])
    first = next(iter(dataset.records(records)))
    value = first[f"{records}/{field}"]
    expected = {"episode_id": playing_order(data, "en")[0], "instruction": "धारीदार लाल मग तक चलें।", "action": 0}[field]
    assert (value.decode() if isinstance(value, bytes) else value) == expected
    if format_ != "plain":
        picture = "hi/rgb" if format_ == "huggingface" else "steps/observation.images.rgb"
        assert first[picture].size == (32, 32)
