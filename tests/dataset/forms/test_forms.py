"""Texts of generated episodes in other forms: deterministic, and with their meaning."""

import re
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest

import arramon_lang as lang
from arramon_dataset.forms.colloquial import colloquial
from arramon_dataset.forms.forms import FORMS, episode_in_form
from arramon_dataset.forms.mixed import NOUNS, VERBS, hinglish, with_loans
from arramon_dataset.forms.romaniser import Romaniser
from arramon_dataset.forms.splits import PREFIX, form_split_name, write_form
from arramon_dataset.forms.terse import TerseWriter, terse_hindi
from arramon_dataset.forms.typing_errors import with_typing_errors
from arramon_dataset.paraphrases.collection import generated_episodes, paraphrased_section
from arramon_lang.meaning import Navigation
from arramon_server.cli import main
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split, read_split, split_folder, write_split
from arramon_server.errors import BadInput

DEVANAGARI = re.compile("[\u0900-\u097f]")

TEXT = "बाएँ मुड़ें और लाल इमारत के पास से निकलें। चौराहे पर दाएँ मुड़कर धारीदार हरी गेंद उठा लें।"


def episodes(number: int = 4) -> list[Episode]:
    return generated_episodes()[:number]


@pytest.fixture
def split(tmp_path: Path) -> Split:
    return write_split(
        tmp_path,
        "val_unseen",
        hidden=False,
        source="generated, scale 0.01, seed 1",
        episodes=episodes(),
        sections=[paraphrased_section()],
    )


def read(text: str, language: str) -> Navigation:
    meaning = lang.load(language).read(text, "navigation")
    assert isinstance(meaning, Navigation)
    return meaning


@pytest.mark.parametrize(("form", "language"), [(form, code) for form, codes in FORMS.items() for code in codes])
def test_texts_are_other_ones_of_the_same_target_and_depend_on_the_seed_alone(form: str, language: str) -> None:
    found = 0
    for episode in episodes():
        written = episode_in_form(episode, form, language, 1)
        assert written == episode_in_form(episode, form, language, 1)
        assert written is not None
        assert replace(written, instructions=episode.instructions) == episode
        (texts,) = written.instructions.values()
        for text, first in zip(texts, episode.instructions[language], strict=True):
            assert text.navigation != first.navigation
            named, meant = read(text.navigation, language).target, read(first.navigation, language).target
            found += (named.kind, named.colour, named.look) == (meant.kind, meant.colour, meant.look)
    assert found >= 7  # of 8: a word with two typing errors may be lost


def test_another_seed_gives_other_texts() -> None:
    first, second = (episode_in_form(episodes(1)[0], "romanised", "hi", seed) for seed in (1, 2))
    assert first != second


@pytest.mark.parametrize("seed", range(5))
def test_scripts(seed: int) -> None:
    random = Random(seed)
    assert not DEVANAGARI.search(Romaniser(random).text(TEXT))
    for density in (NOUNS, VERBS):
        assert not DEVANAGARI.search(hinglish(TEXT, density, random))
    assert not re.search("[a-z]", with_loans(TEXT, random))


def test_writers_of_latin_hindi_differ_and_keep_their_habits() -> None:
    texts = [Romaniser(Random(seed)).text("पीछे पीछे पीछे पीछे पीछे पीछे") for seed in range(12)]
    assert len({text.split()[0] for text in texts}) > 2
    assert any(len(set(text.split())) == 1 for text in texts)


def test_densities_of_english_words() -> None:
    nouns, verbs = (hinglish(TEXT, density, Random(3)) for density in (NOUNS, VERBS))
    assert "red" in nouns.split()
    assert "left" not in nouns
    assert "left" in verbs


def test_typing_errors() -> None:
    text = "Turn left at the corner, then walk past the red building. Pick up the striped green ball."
    typed = [with_typing_errors(text, Random(seed)) for seed in range(8)]
    assert all(not re.search("[A-Z.,]", each) for each in typed)
    assert len(set(typed)) == 8
    assert all(abs(len(each) - len(text)) < 12 for each in typed)


def test_terse_notes() -> None:
    notes = TerseWriter(Random(1), ", ").write(read("Turn left at the bench. Pick up the red mug by the tree.", "en"))
    assert notes.startswith("left at bench, ")
    assert notes.endswith("red mug by tree")
    assert terse_hindi("दाईं ओर मुड़ें। मग को गेंद के पीछे रखें।", "assembly") == "दाएँ मुड़कर मग को गेंद के पीछे"
    assert terse_hindi(TEXT, "navigation") == "बाएँ, लाल इमारत के पास से, चौराहे पर दाएँ, धारीदार हरी गेंद"


def test_colloquial_wordings() -> None:
    texts = {colloquial("Turn left. Pick up the ball.", "en", Random(seed)) for seed in range(12)}
    assert any("Take a left" in text or "take a left" in text for text in texts)


def test_the_command_writes_a_split_a_form(split: Split, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["forms", "--data", str(tmp_path), "val_unseen", "--forms", "terse,romanised", "--seed", "5"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 2
    for form, codes in (("terse", ["en", "hi"]), ("romanised", ["hi"])):
        written = read_split(split_folder(tmp_path, form_split_name("val_unseen", form)))
        assert written.source == (
            f"{PREFIX}{form} ({', '.join(codes)}), seed 5, of val_unseen {split.data_hash[:12]}: {split.source}"
        )
        assert (list(written.languages), list(written.episodes)) == (codes, list(split.episodes))
        assert written.truth_hash == split.truth_hash


@pytest.mark.parametrize(
    ("form", "languages", "message"),
    [
        ("shouted", (), r"unknown form 'shouted'; expected one of paraphrased, terse"),
        ("romanised", ("en",), r"language 'en' has no form romanised; it has paraphrased, terse, typing"),
        ("terse", ("te",), r"language 'te' has no form terse; forms exist in en, hi"),
    ],
)
def test_unknown_forms_and_languages_are_refused(
    split: Split, tmp_path: Path, form: str, languages: tuple[str, ...], message: str
) -> None:
    with pytest.raises(BadInput, match=message):
        write_form(tmp_path, split, form, languages)


def test_hidden_splits_and_splits_of_forms_are_refused(split: Split, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="split 'val_unseen' is hidden"):
        write_form(tmp_path, replace(split, hidden=True), "terse")
    with pytest.raises(BadInput, match="expected a split with its first texts"):
        write_form(tmp_path, write_form(tmp_path, split, "terse"), "romanised")


def test_a_language_that_the_split_lacks_is_refused(split: Split, tmp_path: Path) -> None:
    english = {
        name: replace(each, instructions={"en": each.instructions["en"]}) for name, each in split.episodes.items()
    }
    alone = replace(split, episodes=english)
    with pytest.raises(BadInput, match="has no texts in 'hi'; it has en"):
        write_form(tmp_path, alone, "terse", ["hi"])
    with pytest.raises(BadInput, match="has texts in en; the form romanised exists in hi"):
        write_form(tmp_path, alone, "romanised")


def test_a_missing_split_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["forms", "--data", str(tmp_path), "nothing"]) != 0
    assert "there is no split 'nothing'" in capsys.readouterr().err
