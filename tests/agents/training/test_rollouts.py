"""Checks of validation before a training."""

from dataclasses import replace
from pathlib import Path

import pytest

from arramon_agents.training.rollouts import check_validation
from arramon_client.errors import UsageError
from arramon_server.episodes.splits import write_split
from tests import tiny


@pytest.fixture
def split(tmp_path: Path) -> Path:
    """A data folder with a split of an English and a Hindi episode."""
    both = [tiny.episode(number) for number in ("1", "2")]
    episodes = [
        replace(episode, instructions={code: episode.instructions[code]})
        for episode, code in zip(both, ("en", "hi"), strict=True)
    ]
    write_split(tmp_path, "val_seen", hidden=False, source="tests", episodes=episodes, sections=[tiny.SECTION])
    return tmp_path


@pytest.mark.parametrize(
    ("name", "languages", "episodes"),
    [("val_seen", ("en",), 2), ("val_seen", ("hi",), 2), ("nowhere", ("en", "hi"), 0)],
)
def test_a_training_can_be_validated(name: str, languages: tuple[str, ...], episodes: int, split: Path) -> None:
    check_validation(split, name, languages, episodes)


@pytest.mark.parametrize(
    ("name", "languages", "problem"),
    [
        ("nowhere", ("en",), "there is no split 'nowhere'"),
        ("val_seen", ("en", "fr"), "has no language 'fr'; it has en, hi"),
        ("val_seen", ("en", "hi"), "no episode of 'val_seen' has all of the languages en, hi"),
    ],
)
def test_a_training_cannot_be_validated(name: str, languages: tuple[str, ...], problem: str, split: Path) -> None:
    with pytest.raises(UsageError, match=rf"cannot be validated: .*{problem}.* \(--validate names the split for it;"):
        check_validation(split, name, languages, 1)
