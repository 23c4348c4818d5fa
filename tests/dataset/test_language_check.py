"""Check of a language's data: what it finds in files with faults, and that the languages pass."""

from pathlib import Path
from shutil import copytree

import pytest

from arramon_dataset.language_check import LanguageReport, check_language, repeats
from arramon_dataset.language_meanings import all_meanings
from arramon_lang.language import ROOT, Language, available, load
from arramon_lang.meaning import Navigation, Rotate, Thing
from arramon_server.cli import main
from arramon_server.errors import NotFound

MEANINGS = tuple(all_meanings())


def test_meanings_have_different_names() -> None:
    assert len(dict(MEANINGS)) == len(MEANINGS) > 900


@pytest.mark.parametrize("code", available())
def test_languages_pass(code: str) -> None:
    report = check_language(code, seeds=1, meanings=MEANINGS[::6])
    assert report.passes, list(report.lines())
    assert report.texts == report.meanings == len(MEANINGS[::6])
    assert len(report.preview) == 20


@pytest.fixture
def root(tmp_path: Path) -> Path:
    copytree(ROOT / "en", tmp_path / "en")
    return tmp_path


def replace(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


@pytest.mark.parametrize(
    ("file", "old", "new", "fault"),
    [
        ("language", 'script = "', 'scirpt = "', r"language\.toml: unknown key 'scirpt'"),
        ("lexicon", "[kinds]\nball", "[kinds]\nbaal", r"lexicon\.toml: unknown key 'baal' in \[kinds\]"),
        ("relations", "near = ", "nearly = ", r"relations\.toml: unknown key 'nearly' in \[phrases\]"),
        ("grammar", "straight = '", "staright = '", r"grammar\.toml: unknown key 'staright' in \[text\]"),
        ("things", "\nbench = [", "\nbnech = [", r"things\.toml: unknown key 'bnech' in \[nouns\]"),
        ("phrases", '"turn before" = [', '"turn bevore" = [', r"phrases\.toml: unknown key 'turn bevore' in \[steps\]"),
        ("quality", "[counts]", "[count]", r"quality\.toml: unknown key 'count'"),
        ("properties", "stopwords", "stop_words", r"properties\.toml: unknown key 'stop_words'"),
        ("chunks", "also = ", "alsoo = ", r"chunks\.toml: unknown key 'alsoo'"),
        (
            *("grammar", 'words = ["the"]', 'words = "the"'),
            r"grammar\.toml: text\.articles\.words: 'the' is a text; expected a list or table, as in lang/en",
        ),
        (
            "grammar",
            "small_letters = 0.15",
            'small_letters = "0.15"',
            r"small_letters: '0\.15' is a text; expected a num",
        ),
        (
            "relations",
            'position = "before"',
            'position = ["before"]',
            r"position: \['before'\] is a list or table; exp",
        ),
    ],
)
def test_unknown_keys_and_wrong_types_are_named_with_their_file(
    root: Path, file: str, old: str, new: str, fault: str
) -> None:
    replace(root / "en" / f"{file}.toml", old, new)
    report = check_language("en", root=root)
    assert not report.passes
    with pytest.raises(AssertionError, match=fault):
        raise AssertionError("\n".join(report.faults))


def test_unknown_keys_are_errors_when_a_language_is_loaded(root: Path) -> None:
    replace(root / "en" / "things.toml", "\nbench = [", "\nbnech = [")
    with pytest.raises(ValueError, match=r"things\.toml: unknown key 'bnech' in \[nouns\]; expected alley, awning"):
        Language(root / "en").grammar  # noqa: B018 - loads the files


def test_missing_and_further_files_are_faults(root: Path) -> None:
    (root / "en" / "quality.toml").rename(root / "en" / "qualities.toml")
    faults = check_language("en", root=root).faults
    assert [fault.rpartition("/")[2] for fault in faults] == [
        "quality.toml: is missing",
        "qualities.toml: is not a file of a language",
    ]


def test_what_no_text_uses_is_a_hint_and_what_cannot_be_said_a_fault(root: Path) -> None:
    replace(root / "en" / "grammar.toml", "\n[words]\n", '\n[words]\nunused = "unused"\n')
    replace(root / "en" / "phrases.toml", '"walk until" = [', '"walk until wall" = [')
    named = [each for each in MEANINGS if each[0] in ("walk until bench", "walk ahead")]
    report = check_language("en", seeds=2, root=root, meanings=named)
    assert "grammar.toml: no text uses the word 'unused'" in report.hints
    assert report.faults == ("walk until bench: cannot be written: no wording for walk until",)
    assert report.texts == 2


def test_a_meaning_without_a_wording_is_named_with_its_values(root: Path) -> None:
    replace(root / "en" / "grammar.toml", '\naround = ["20* around", ', '\nslight_left = ["20* around", ')
    around = Navigation((Rotate("around", "at", Thing("bench")),), Thing("mug", "red", "dotted"))
    report = check_language("en", seeds=1, root=root, meanings=[("turn around at bench", around)])
    (fault,) = report.faults
    assert fault == "turn around at bench: cannot be written: no wording for turn at with direction 'around'"


def test_files_that_are_anothers_and_nouns_without_gender_are_hints(root: Path) -> None:
    copytree(ROOT / "hi", root / "xx")
    (root / "xx" / "relations.toml").write_bytes((ROOT / "en" / "relations.toml").read_bytes())
    replace(root / "xx" / "language.toml", 'code = "hi"', 'code = "xx"')
    replace(root / "xx" / "things.toml", ', gender = "masculine"', "")
    hints = check_language("xx", seeds=1, root=root, meanings=MEANINGS[:1]).hints
    assert "relations.toml: is the file of 'en', unchanged" in hints
    assert "grammar.toml: is the file of 'hi', unchanged" in hints
    assert not any("language.toml" in hint for hint in hints)
    assert [hint for hint in hints if "has no gender" in hint] == [next(hint for hint in hints if "no gender" in hint)]


def test_the_report_counts_what_it_does_not_list_and_lists_all_if_asked() -> None:
    faults = tuple(f"walk past {number % 2}: fault {number}" for number in range(26))
    report = LanguageReport("xx", 1, 26, faults, (), (), ())
    assert list(report.lines())[-2] == "fault: 6 more: walk past 0 (3), walk past 1 (3)"
    assert list(report.lines(None))[1:-1] == [f"fault: {fault}" for fault in faults]


def test_a_file_that_is_no_toml_is_one_fault(root: Path) -> None:
    (root / "en" / "things.toml").write_text("[nouns\n", encoding="utf-8")
    assert len(check_language("en", root=root).faults) == 1


def test_a_single_letter_is_allowed_in_either_case(root: Path) -> None:
    replace(root / "en" / "quality.toml", 'single_letters = ["a"]', 'single_letters = ["A"]')
    named = [each for each in MEANINGS if each[0] == "walk to bench"]
    assert check_language("en", root=root, meanings=named).passes


def test_the_command_lists_and_checks_languages(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["language", "list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "en  English (English), Latin script, in every generated episode"
    assert lines[2] == "te  Telugu (తెలుగు), Telugu script, on request, preview: not reviewed by native speakers"
    (root / "en" / "quality.toml").unlink()
    assert main(["language", "check", "en", "--root", str(root)]) == 1
    assert "quality.toml: is missing" in capsys.readouterr().out
    assert main(["language", "check", "en", "--seeds", "0"]) == 1
    assert "--seeds is 0; expected at least 1" in capsys.readouterr().err


def test_a_language_that_does_not_exist_is_an_error(root: Path) -> None:
    with pytest.raises(NotFound, match="there is no language 'xx'"):
        check_language("xx", root=root)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Turn left at the next bench.", []),
        ("Walk towards toward it.", ["'towards' beside 'toward'"]),
        ("Go to the the bench.", []),  # Of fewer than four letters: the quality checks report it.
    ],
)
def test_neighbouring_words_with_one_stem_are_reported(text: str, expected: list[str]) -> None:
    assert list(repeats(load("en"), text)) == expected
