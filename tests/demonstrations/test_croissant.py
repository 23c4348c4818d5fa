"""The Croissant files, validated and read by `mlcroissant`."""

from pathlib import Path

import mlcroissant
import pytest

from tests.demonstrations.exporting import playing_order

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")  # in what mlcroissant uses

RECOMMENDED = "is recommended, but does not exist"


@pytest.mark.parametrize("format_", ["plain", "minari", "lerobot", "huggingface"])
def test_it_is_valid(exports: dict[str, Path], format_: str) -> None:
    dataset = mlcroissant.Dataset(jsonld=str(exports[format_] / "croissant.json"))
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
    dataset = mlcroissant.Dataset(jsonld=str(exports[format_] / "croissant.json"))
    first = next(iter(dataset.records(records)))
    value = first[f"{records}/{field}"]
    expected = {"episode_id": playing_order(data, "en")[0], "instruction": "धारीदार लाल मग तक चलें।", "action": 0}[field]
    assert (value.decode() if isinstance(value, bytes) else value) == expected
    if format_ != "plain":
        picture = "hi/rgb" if format_ == "huggingface" else "steps/observation.images.rgb"
        assert first[picture].size == (32, 32)
