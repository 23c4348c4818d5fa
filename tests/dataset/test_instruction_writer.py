"""The instruction writer: whole generated splits in every language, and the criteria of a trial."""

import re
from pathlib import Path

import pytest

import arramon_lang as lang
from arramon_client.world import Action
from arramon_dataset.demands import episode_demands
from arramon_dataset.generation import GenerationSite, faults_of_episode
from arramon_dataset.generation.split_maker import GenerationProgress
from arramon_dataset.instruction_writer import initial_turn_angle, passes_trial
from arramon_server.cli import main
from arramon_server.episodes.splits import read_split, split_folder
from arramon_server.scoring.episode_scores import METRICS, EpisodeScores

F, L, R, P = Action.FORWARD, Action.LEFT, Action.RIGHT, Action.INTERACT


def test_generate_writes_episodes_in_every_required_language(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["generate", "--data", str(tmp_path), "--split", "val_unseen", "--scale", "0.002", "--jobs", "1"]

    assert main(arguments) == 0
    said = capsys.readouterr()
    split = read_split(split_folder(tmp_path, "val_unseen"))
    site = GenerationSite(split.sections["6"])
    assert said.out.startswith("split val_unseen (open): 2 in en, 2 in hi; 1 section;")
    first, *others = said.err.splitlines()
    assert first == "val_unseen: 0 of 2 episodes; the first ones take longest"
    assert others
    for line in others:
        assert re.fullmatch(r"val_unseen: \d of 2 episodes from \d+ drafts in 0:\d\d, 0:\d\d left", line)
    assert list(split.episodes) == ["55000", "55008"]
    for episode in split.episodes.values():
        assert set(episode.instructions) == set(lang.required())
        assert faults_of_episode(episode, site.solids, site.physics) == ()
        for code, texts in episode.instructions.items():
            assert episode_demands(episode, code) == split.demands[episode.episode_id]
            for turn, text in zip(episode.turns, texts, strict=True):
                read = lang.load(code).read(text.navigation, "navigation")
                assert read.target.kind == turn.target.type.kind  # type: ignore[union-attr]
    site.physics.close()


def test_a_further_language_changes_nothing_of_the_others(tmp_path: Path) -> None:
    few = ["--split", "val_unseen", "--scale", "0.002", "--jobs", "1", "--no-trial"]
    assert main(["generate", "--data", str(tmp_path / "two"), *few]) == 0
    assert main(["generate", "--data", str(tmp_path / "three"), *few, "--languages", "te,hi,en"]) == 0
    two, three = (read_split(split_folder(tmp_path / name, "val_unseen")) for name in ("two", "three"))
    assert list(two.episodes) == list(three.episodes)
    for one, other in zip(two.episodes.values(), three.episodes.values(), strict=True):
        assert set(other.instructions) <= {"en", "hi", "te"}
        assert {code: texts for code, texts in other.instructions.items() if code != "te"} == one.instructions
    have = three.languages.get("te", 0)
    assert three.source == f"{two.source}, te (preview) in {have} of 2"
    assert "preview" not in two.source


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (
            ["--split", "val"],
            "there is no split 'val'; there are train, val_seen, val_unseen, test_unseen, train_extra",
        ),
        (["--scale", "2"], "the scale is 2.0; expected more than 0 and at most 1"),
        (["--languages", "en,te"], "every episode has en, hi: expected hi in --languages too"),
        (["--languages", "en,hi,xx"], "there is no language 'xx'; there are en, hi, te"),
        (
            ["--rooms", "2", "--languages", "en,hi"],
            "--rooms writes the languages that every episode has; leave out --languages",
        ),
        (["--jobs", "-1"], "the number of jobs is -1; expected 1 to 256, or 0 for one per core"),
    ],
)
def test_invalid_generate_options_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], problem: str
) -> None:
    assert main(["generate", "--data", str(tmp_path), *arguments]) == 1
    assert capsys.readouterr().err == f"arramon-server: {problem}\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("actions", "degrees"),
    [((F, L, L), 0.0), ((L, L, F), 60.0), ((R,) * 6 + (F,), 180.0), ((L, R, F), 0.0), ((R, P), 30.0)],
)
def test_first_turn_sums_the_leading_rotations(actions: tuple[Action, ...], degrees: float) -> None:
    assert initial_turn_angle(actions) == degrees


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ({}, {}, True),
        ({"nDTW": 0.21}, {}, True),
        ({"nDTW": 0.2}, {}, False),
        ({}, {"nDTW": 0.1}, False),
        ({"CTC-3": 0.0}, {}, False),
        ({}, {"PTC": 0.0}, False),
        ({"CTC-0": 0.0}, {}, True),
    ],
)
def test_follower_scores_decide_whether_instructions_pass(
    first: dict[str, float], second: dict[str, float], expected: bool
) -> None:
    perfect = dict.fromkeys(METRICS, 1.0)
    assert passes_trial(EpisodeScores("1", "6", (perfect | first, perfect | second))) is expected


def test_progress_shows_the_start() -> None:
    assert str(GenerationProgress("train", 0, 400, 0, 0.0)) == "train: 0 of 400 episodes; the first ones take longest"


def test_progress_shows_counts_and_time_left() -> None:
    said = str(GenerationProgress("train", 100, 400, 130, 65.0))
    assert said == "train: 100 of 400 episodes from 130 drafts in 1:05, 3:15 left"
