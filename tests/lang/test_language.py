"""Available languages, their files, and identification of a text's language."""

import shutil
from pathlib import Path

import pytest

import arramon_lang as lang
from arramon_client.world import PREVIEW_LANGUAGES
from arramon_lang.language import ROOT, available, identify, load


def test_public_names_are_stable() -> None:
    assert lang.__all__ == [
        "CannotRead",
        "Language",
        "Mention",
        "UnknownLanguage",
        "available",
        "identify",
        "load",
        "required",
    ]


def test_languages_are_available() -> None:
    assert lang.available() == ("en", "hi", "te")
    names = {code: (load(code).name, load(code).english_name, load(code).script) for code in available()}
    assert names == {
        "en": ("English", "English", "Latin"),
        "hi": ("हिन्दी", "Hindi", "Devanagari"),
        "te": ("తెలుగు", "Telugu", "Telugu"),
    }


def test_every_episode_has_english_and_hindi_and_telugu_is_a_preview() -> None:
    assert lang.required() == ("en", "hi")
    assert [code for code in available() if load(code).preview] == ["te"] == [*PREVIEW_LANGUAGES]


def test_all_languages_have_the_same_files() -> None:
    files = {code: sorted(path.stem for path in (ROOT / code).iterdir()) for code in available()}
    expected = ["chunks", "grammar", "language", "lexicon", "phrases", "properties", "quality", "relations", "things"]
    own = {"en": ["preferences", "typing"], "hi": ["latin"], "te": []}
    assert files == {code: sorted([*expected, *further]) for code, further in own.items()}


def test_languages_are_loaded_once() -> None:
    assert lang.load("hi") is lang.load("hi")


def test_unknown_language_error_lists_the_known_ones() -> None:
    with pytest.raises(lang.UnknownLanguage, match=r"no language 'fr'; there are en, hi, te"):
        lang.load("fr")
    with pytest.raises(LookupError):
        lang.load("../lang/en")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Turn left and place the mug.", "en"),
        ("बाएँ मुड़ें और मग रखें।", "hi"),
        ("धारीदार TV को मग के पीछे रखें।", "hi"),
        ("Place the मग there, on the bucket.", "en"),
        ("ఎడమవైపుకు తిరిగి కప్పును తీసుకోండి.", "te"),
        ("left mud jao, phir seedhe chalo jab tak neela phone booth na aaye. laal mag utha lo", "hi"),
        ("red building ke paas se right lo aur dotted blue ball utha lo", "hi"),
        ("bowl pe striped purple book place kar do", "hi"),
        ("Turn right and go past the red barrel. phir bench ke paas rakha laal mug uthao.", "hi"),
        ("go strait to the bech n pick up the dotte red bal", "en"),
        ("place thee dotted green book directly to the left of thee dotte brown book", "en"),
        ("u-turn, to red barrel, right after tree, dotted blue ball by phone booth", "en"),
    ],
)
def test_language_of_a_text_is_identified(text: str, expected: str) -> None:
    assert lang.identify(text) == expected


@pytest.mark.parametrize("text", ["", "12 .", "१२।", "Слева"])
def test_a_text_in_no_known_script_is_an_error(text: str) -> None:
    with pytest.raises(ValueError, match="is in none of en, hi, te"):
        lang.identify(text)


@pytest.fixture
def three_languages(tmp_path: Path) -> Path:
    """Return a folder with the existing languages and a third in Latin script, with its own words for two things."""
    for code in available():
        shutil.copytree(ROOT / code, tmp_path / code)
    third = shutil.copytree(ROOT / "en", tmp_path / "nl")
    replace(third / "language.toml", 'code = "en"', 'code = "nl"')
    replace(third / "lexicon.toml", 'ball = ["ball"', 'ball = ["bal"')
    replace(third / "lexicon.toml", 'bucket = ["bucket"', 'bucket = ["emmer"')
    replace(third / "relations.toml", 'behind = ["behind"', 'behind = ["achter"')
    return tmp_path


def replace(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


def test_language_is_added_by_a_folder(three_languages: Path) -> None:
    assert available(three_languages) == ("en", "hi", "nl", "te")
    dutch = load("nl", three_languages)
    text = "de bal achter de emmer"
    assert [mention.kind for mention in dutch.find_objects(text)] == ["ball", "bucket"]
    assert identify(text, three_languages) == "nl"
    assert identify("the ball behind the bucket", three_languages) == "en"


def test_folder_name_must_equal_the_language_code(three_languages: Path) -> None:
    shutil.copytree(three_languages / "nl", three_languages / "de")
    with pytest.raises(ValueError, match=r"language\.toml: code 'nl'; expected the folder's name, 'de'"):
        load("de", three_languages)
