"""Statistics of a split small enough to count by hand, as text, JSON and plots."""

import json
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from PIL import Image

from arramon_dataset.release.files import read_release
from arramon_dataset.statistics.command import as_json, statistics_of
from arramon_dataset.statistics.histogram import bin_shares
from arramon_dataset.statistics.lengths import Lengths
from arramon_dataset.statistics.measure import measure
from arramon_dataset.statistics.plots import write_plots
from arramon_dataset.statistics.table import as_text
from arramon_server.cli import main
from arramon_server.errors import BadInput, NotFound, StorageError
from tests import tiny
from tests.release import VAL_SEEN, needs_release


def test_lengths_are_counted_per_turn_and_episode(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    english, hindi = statistics_of(tmp_path)
    assert [(each.split, each.language, each.episodes) for each in (english, hindi)] == [
        ("tiny", "en", 6),
        ("tiny", "hi", 4),
    ]
    assert [(each.lacking, each.preview) for each in (english, hindi)] == [(0, False), (2, False)]
    rows = [line.split() for line in as_text([english, hindi]) if line.startswith("without this language")]
    assert rows == [["without", "this", "language", "0", "2"]] * 2
    lengths = english.phases["navigation"].lengths
    assert {name: each.counts for name, each in lengths.turns.items()} == {
        "words": {7: 12},  # Go on to the striped red mug
        "path": {3: 12},
        "actions": {3: 6, 6: 6},
    }
    assert {name: (each.mean, each.longest) for name, each in lengths.episodes.items()} == {
        "words": (14, 14),
        "path": (6, 6),
        "actions": (9, 9),
    }
    assert hindi.phases["assembly"].lengths.turns["words"].counts == {5: 8}  # उसे दो क़दम आगे रखें
    assert english.phases["assembly"].lengths.turns["path"].counts == {2: 12}


def test_frequent_words_and_properties_are_counted(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    english, hindi = statistics_of(tmp_path)
    assert english.phases["navigation"].frequent == (("go", 12),)  # Neither stop words nor "striped red mug".
    assert hindi.phases["navigation"].frequent == (("चलें", 8),)
    shares = english.phases["assembly"].properties
    assert {name for name, share in shares.items() if share.instructions == share.episodes == 1} == {"directional"}
    assert {name for name, share in shares.items() if share.episodes == 0} == set(shares) - {"directional"}


def test_diversity_samples_have_equal_sizes(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    found = [phase.diversity for each in statistics_of(tmp_path) for phase in each.phases.values()]
    assert [each and each.texts for each in found] == [8, 8, 8, 8]
    found = [phase.diversity for each in statistics_of(tmp_path, sample=5) for phase in each.phases.values()]
    assert [each and each.texts for each in found] == [5, 5, 5, 5]


def test_splits_and_languages_can_be_chosen(tmp_path: Path) -> None:
    for name in ("one", "two"):
        tiny.write(tmp_path, name)
    chosen = [(each.split, each.language) for each in statistics_of(tmp_path, ["two", "one", "two"], ["hi"])]
    assert chosen == [("two", "hi"), ("one", "hi")]


@pytest.mark.parametrize(
    ("splits", "languages", "sample", "message"),
    [
        (["x"], [], 9, "there is no split 'x' in .*; there are tiny"),
        ([], ["fr"], 9, "there is no language 'fr' in tiny; there are en, hi"),
        ([], [], 1, "the sample size is 1; expected at least 2"),
    ],
)
def test_invalid_selections_are_refused(
    tmp_path: Path, splits: list[str], languages: list[str], sample: int, message: str
) -> None:
    tiny.write(tmp_path)
    with pytest.raises((NotFound, BadInput), match=message):
        statistics_of(tmp_path, splits, languages, sample=sample)


def test_folder_without_episodes_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(NotFound, match="there are no episodes in"):
        statistics_of(tmp_path)


@pytest.mark.parametrize(
    ("lengths", "width", "stop", "shares"),
    [
        ([1, 2, 2, 4], 1, 5, [0, 0.25, 0.5, 0, 0.25, 0]),
        ([0, 4, 5, 9], 5, 10, [0.5, 0.5, 0]),
        ([10, 11, 400, 1], 5, 10, [0.25, 0, 0.75]),
    ],
)
def test_lengths_are_binned_with_an_overflow_bin(
    lengths: list[int], width: int, stop: int, shares: list[float]
) -> None:
    assert bin_shares(Lengths.of(lengths), width, stop) == shares


def test_text_table_shows_the_measured_figures(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    lines = list(as_text(statistics_of(tmp_path)))
    for row in (
        ["NAVIGATION", "tiny", "en", "tiny", "hi"],
        ["episodes", "6", "4"],
        ["words", "7.00", "7", "5.00", "5"],
        ["path", "steps", "4.00", "4", "4.00", "4", "48.14", "156"],
        ["directional", "reference", "100%", "100%", "100%", "100%", "68%"],
        ["self-BLEU", "in", "300", "100.0", "100.0"],
        ["1", "go", "12", "चलें", "8"],
        ["5", "-", "9", "██████████", "100.0%", "██████████", "100.0%"],
    ):
        assert row in [line.split() for line in lines], row


def test_stats_command_prints_json_writes_plots_and_reports_errors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tiny.write(tmp_path)
    assert main(["stats", "--data", str(tmp_path), "--lang", "en", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert found == json.loads(json.dumps(as_json(statistics_of(tmp_path, languages=["en"]))))[0]
    assert found["phases"]["assembly"]["lengths"]["episodes"]["words"]["mean"] == 10
    assert main(["stats", "--data", str(tmp_path), "--output", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(tmp_path / "out" / "frequent-words.svg")
    assert main(["stats", "--data", str(tmp_path), "--split", "x"]) == 1
    assert "there is no split 'x'" in capsys.readouterr().err


def test_plots_are_drawn_and_write_errors_reported(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    figures = statistics_of(tmp_path) * 5  # More columns than colours.
    *pictures, drawing = write_plots(figures, tmp_path / "out")
    for path in pictures:
        with Image.open(path) as picture:
            assert len(picture.getcolors(1 << 20) or ()) > 8, path
    words = {element.text for element in ET.parse(drawing).iter()}
    assert {"go", "चलें", "tiny hi: navigation"} <= words
    (tmp_path / "file").touch()
    with pytest.raises(StorageError, match=r"cannot write .*file/words-a-turn\.png: "):
        write_plots(figures[:1], tmp_path / "file")


@needs_release
def test_lengths_of_the_official_release_match_known_values() -> None:
    """The known means and maxima of val-seen's turns."""
    language, episodes = read_release(VAL_SEEN)
    found = measure("val_seen", episodes, language, sample=2)
    lengths = {
        phase: {name: (each.mean, each.longest) for name, each in figures.lengths.turns.items()}
        for phase, figures in found.phases.items()
    }
    for phase, name, mean, longest in (
        ("navigation", "words", 33.1, 97),
        ("navigation", "path", 25.9, 81),
        ("navigation", "actions", 39.05, 131),
        ("assembly", "words", 15.2, 70),
        ("assembly", "path", 2.6, 5),
        ("assembly", "actions", 6.7, 17),
    ):
        assert lengths[phase][name] == pytest.approx((mean, longest), abs=0.051)
