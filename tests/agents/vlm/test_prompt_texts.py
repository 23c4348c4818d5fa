"""Prompts: every language has all of them, another falls back to English, and a file of one's own is checked."""

from pathlib import Path
from string import Template

import pytest

import arramon_lang as lang
from arramon_agents.vlm.prompt_texts import FOLDER, PromptFolder, _read
from arramon_agents.vlm.replies import CAUSES
from arramon_client.errors import AgentLoadError


def test_every_language_has_prompts() -> None:
    assert {path.stem for path in FOLDER.glob("*.toml")} == set(lang.required())


@pytest.mark.parametrize("language", lang.required())
def test_prompts_have_the_same_keys_and_placeholders_as_the_english_ones(language: str) -> None:
    english, texts = _read(FOLDER / "en.toml"), _read(FOLDER / f"{language}.toml")
    assert texts.keys() == english.keys()
    for key, text in texts.items():
        assert set(Template(text).get_identifiers()) == set(Template(english[key]).get_identifiers()), key
    for key in ("system", "answer.json", "task.navigation"):  # the prose is in the language's own script
        assert lang.load(language).count_letters(texts[key]) > len(texts[key]) / 4 or len(texts[key]) < 80
    assert {f"unusable.{cause}" for cause in CAUSES} < texts.keys()


def test_a_language_without_prompts_is_asked_in_english_with_one_notice() -> None:
    notices: list[str] = []
    folder = PromptFolder(None, notices.append)
    assert folder.of("te").language == folder.of("te").language == "en"
    assert len(notices) == 1
    assert "no prompts in 'te', only in en, hi" in notices[0]
    assert folder.of("hi").text("observation.done", actions="left") == "आपके पिछले उत्तर के बाद किया गया: left।"


def test_a_file_of_ones_own(tmp_path: Path) -> None:
    english = (FOLDER / "en.toml").read_text()
    own = tmp_path / "own.toml"
    own.write_text(english.replace("You control a walker", "You are a walker"))
    folder = PromptFolder(str(own), pytest.fail)
    assert folder.of("te").text("system").startswith("You are a walker")
    assert folder.digest != PromptFolder(None, pytest.fail).digest


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("system = ", "sistem = ", "lack system"),
        ("$phase_step", "$stage", "observation.now has an unknown placeholder; expected $phase_step, $steps_left"),
        ("steps are left", "steps are left for $", "observation.now has an unknown placeholder"),
        ('frame = "What you see now:"', "frame = 3", "observation.frame is 3; expected a text"),
        ("[scene]", "[scene", "are not TOML"),
    ],
)
def test_faults_of_a_file_of_ones_own(tmp_path: Path, old: str, new: str, message: str) -> None:
    own = tmp_path / "own.toml"
    own.write_text((FOLDER / "en.toml").read_text().replace(old, new))
    with pytest.raises(AgentLoadError) as caught:
        PromptFolder(str(own), pytest.fail)
    assert message in str(caught.value)
    assert str(own) in str(caught.value)
