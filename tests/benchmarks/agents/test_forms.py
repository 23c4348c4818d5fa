"""The paired drop of an agent with texts in another form."""

from pathlib import Path

import numpy as np
import pytest

from arramon_dataset.forms.splits import write_form
from arramon_dataset.paraphrases.collection import generated_episodes, paraphrased_section
from arramon_server.episodes.splits import Split, write_split
from benchmarks.agents.forms import compared, main
from tests.benchmarks.command import printed


def _write_two_episodes(folder: Path) -> Split:
    return write_split(
        folder,
        "val_unseen",
        hidden=False,
        source="generated, scale 0.01, seed 1",
        episodes=generated_episodes()[:2],
        sections=[paraphrased_section()],
    )


def test_drop_and_consistency() -> None:
    first = {"CTC-3": np.array([[1.0, 1.0], [1.0, 0.0]]), "nDTW": np.ones((2, 2)), "PTC": np.ones((2, 2))}
    form = {"CTC-3": np.array([[1.0, 0.0], [0.0, 0.0]]), "nDTW": np.zeros((2, 2)), "PTC": np.ones((2, 2))}
    result = compared(first, form, [0, 0])
    assert (result["CTC-3"], result["drop"], result["same"], result["nDTW"]) == (0.25, 0.5, 0.5, 0.0)
    assert result["low"] < 0.5 < result["high"]
    assert compared(first, first, [0, 0])["drop"] == pytest.approx(0.0)


def test_the_follower_plays_a_form(tmp_path: Path) -> None:
    split = _write_two_episodes(tmp_path)
    write_form(tmp_path, split, "romanised")
    lines = printed("benchmarks.agents.forms", "--data", tmp_path, "--episodes", 1)
    assert [line.split()[1:3] for line in lines[1:]] == [["hi", "first"], ["hi", "romanised"]]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--agents", "agents.nothing"], "there is no module agents.nothing"),
        (["--split", "val_nowhere"], "there is no split 'val_nowhere'"),
    ],
)
def test_a_wrong_name_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[str], message: str
) -> None:
    _write_two_episodes(tmp_path)
    monkeypatch.setattr("sys.argv", ["forms", "--data", str(tmp_path), *options])
    with pytest.raises(SystemExit, match=message):
        main()
