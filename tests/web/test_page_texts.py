"""Words, numbers and dates in each language."""

import re
import string
from datetime import UTC, datetime
from pathlib import Path

import pytest

from arramon_client.world import PREVIEW_LANGUAGES
from arramon_server.board.standings import Mark
from arramon_server.runs.storage import causes
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.web import page_texts
from arramon_server.web.standings_query import COVERAGES, SENSORS, TURNS

EN, HI = page_texts.all_texts()["en"], page_texts.all_texts()["hi"]
WEB = Path(page_texts.__file__).parent

ASKED_FOR_BY_NAME = (
    *(f"languages.{code}" for code in page_texts.all_texts()),
    *(f"metrics.{name}" for name in METRICS[:7]),
    *(f"marks.{mark}{end}" for mark in (*Mark, "cancelled", "reference") for end in ("", "_meaning")),
    *(f"causes.{name}" for name in vars(causes) if name.isupper()),
    *(f"turns.{name}" for name in TURNS),
    *(f"choices.{name}" for name in (*SENSORS, *COVERAGES)),
)
"""Keys that are put together from what there is."""


def names(text: str) -> set[str]:
    return {name for _, name, _, _ in string.Formatter().parse(text) if name is not None}


def test_the_default_language_comes_first() -> None:
    assert list(page_texts.all_texts()) == ["en", "hi"]


@pytest.mark.parametrize("code", list(page_texts.all_texts()))
def test_every_language_has_the_same_keys_and_names(code: str) -> None:
    other = page_texts.all_texts()[code]
    assert set(other.words) == set(EN.words)
    for key, text in EN.words.items():
        assert type(other.words[key]) is type(text), key
        if isinstance(text, str):
            assert names(other.words[key]) == names(text), key
            assert other.words[key].strip() == other.words[key] != "", key
    assert len(other.words["format.months"]) == 12


@pytest.mark.parametrize("key", ASKED_FOR_BY_NAME)
def test_every_requested_text_key_exists(key: str) -> None:
    assert key in EN.words


def test_every_text_key_is_used() -> None:
    source = "".join(path.read_text() for path in WEB.rglob("*") if path.suffix in (".py", ".html"))
    said = set(re.findall(r'"([a-z_]+\.[A-Za-z_0-9-]+)"', source)) | set(re.findall(r'"([a-z_]+)"', source))
    groups = (
        "languages", "sensors", "causes", "states", "turns", "choices", "marks", "references", "reference_notes",
        "aspects", "groups", "corrections", "closing", "episodes", "objects", "colours", "things", "play_js",
        "actions", "events", "failures", "notes", "outcomes",
    )  # fmt: skip
    for key in EN.words:
        group, _, name = key.partition(".")
        by_name = group in ("run", "cost", "report", "epochs", "path", "play_path") and name in said
        assert key in said or group in (*groups, "metrics") or by_name, key


def test_hindi_texts_are_in_devanagari() -> None:
    latin = ("page.site", "page.direction", "format.")
    for key, text in HI.words.items():
        if isinstance(text, str) and not key.startswith(latin) and re.sub(r"{\w+}|[^\w]|nDTW", "", text):
            assert re.search("[\u0900-\u097f]", text), f"{key}: {text}"


@pytest.mark.parametrize(
    ("number", "english", "hindi"),
    [(0, "0", "0"), (999, "999", "999"), (1065, "1,065", "1,065"), (1234567, "1,234,567", "12,34,567")],
)
def test_whole_numbers_are_grouped_per_language(number: int, english: str, hindi: str) -> None:
    assert (EN.whole(number), HI.whole(number)) == (english, hindi)


def test_scores_decimals_and_percentages_are_formatted() -> None:
    assert [EN.score(value) for value in (0, 0.0444, 0.0445001, 1)] == ["0.000", "0.044", "0.045", "1.000"]
    assert [EN.decimal(value) for value in (3.0, 0.25, 0.6000001)] == ["3", "0.25", "0.6"]
    assert [EN.percent(value) for value in (0, 0.0003, 0.006, 0.5, 0.999, 1)] == [
        "0%",
        "< 1%",
        "1%",
        "50%",
        "99%",
        "100%",
    ]


def test_dates_are_formatted_per_language() -> None:
    time = datetime(2030, 1, 9, 7, 5, tzinfo=UTC)
    assert EN.date(time) == "9 January 2030"
    assert HI.moment(time) == "9 जनवरी 2030, 07:05 UTC"


@pytest.mark.parametrize(
    ("accepted", "language"),
    [
        ("", "en"),
        ("hi", "hi"),
        ("hi-IN,hi;q=0.9,en;q=0.8", "hi"),
        ("en;q=0.5, hi;q=0.6", "hi"),
        ("fr, de;q=0.9, hi;q=0.1", "hi"),
        ("fr", "en"),
        ("hi;q=0, en", "en"),
        ("HI", "hi"),
        ("hi;q=nonsense", "en"),
        (";;,,=", "en"),
    ],
)
def test_language_is_chosen_from_accept_language(accepted: str, language: str) -> None:
    assert page_texts.preferred_language(accepted) == language


def test_language_is_added_by_one_texts_file(tmp_path: Path) -> None:
    file = tmp_path / "ta.toml"
    file.write_text((WEB / "texts" / "en.toml").read_text().replace('decimal_mark = "."', 'decimal_mark = ","'))
    tamil = page_texts.read_texts(file)
    assert (tamil.language, tamil.score(0.5)) == ("ta", "0,500")


@pytest.mark.parametrize(("texts", "mark"), [(EN, "preview"), (HI, "परीक्षण")])
def test_a_language_that_no_native_speaker_has_reviewed_is_marked(texts: page_texts.PageTexts, mark: str) -> None:
    names = {code: texts.named("languages", code) for code in ("en", "hi", *PREVIEW_LANGUAGES)}
    assert {code for code, name in names.items() if mark in name} == {*PREVIEW_LANGUAGES}
