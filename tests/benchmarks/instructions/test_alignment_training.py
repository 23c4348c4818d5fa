"""Word alignment: training, saving, and fit of texts to routes."""

from pathlib import Path

import pytest

from arramon_dataset.alignment.model import AlignmentModel, read_model
from arramon_dataset.alignment.route_tokens import Tokens, mirrored
from benchmarks.instructions.alignment_training import learn, save

CONE_LEFT: Tokens = ("turn:left", "thing:red", "thing:cone", "target:mug")
CONE_RIGHT: Tokens = ("turn:right", "thing:red", "thing:cone", "target:mug")
TREE_LEFT: Tokens = ("turn:left", "thing:tree", "target:ball")
TREE_RIGHT: Tokens = ("turn:right", "thing:tree", "target:ball")

PAIRS = [
    ("go left past the red cone to the mug", CONE_LEFT),
    ("go right past the red cone to the mug", CONE_RIGHT),
    ("go left past the tree to the ball", TREE_LEFT),
    ("go right past the tree to the ball", TREE_RIGHT),
]


@pytest.fixture(scope="module")
def model() -> AlignmentModel:
    return learn(PAIRS * 2, len(PAIRS) * 2)


@pytest.mark.parametrize(("text", "route"), PAIRS)
def test_a_text_fits_its_own_route_best(model: AlignmentModel, text: str, route: Tokens) -> None:
    assert model.margin(text, route) > 0.0
    assert model.rank(text, route) == 0
    assert model.rank(text, mirrored(route)) > 0


def test_unknown_words_and_tokens_say_nothing(model: AlignmentModel) -> None:
    assert model.score("lovely weather", CONE_LEFT) == 0.0
    assert model.score("left", (*CONE_LEFT, "thing:unicorn")) == model.score("left", CONE_LEFT)


def test_a_model_is_read_as_it_was_written(model: AlignmentModel, tmp_path: Path) -> None:
    for name in ("one.json.gz", "other.json.gz"):
        save(model, tmp_path / name)
    assert (tmp_path / "one.json.gz").read_bytes() == (tmp_path / "other.json.gz").read_bytes()
    again = read_model(tmp_path / "one.json.gz")
    assert (again.words, again.tokens, again.others) == (model.words, model.tokens, model.others)
    for text, route in PAIRS[:4]:
        assert again.score(text, route) == pytest.approx(model.score(text, route), abs=0.01)
