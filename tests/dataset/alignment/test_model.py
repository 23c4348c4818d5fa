"""Alignment of words with routes: what is learned, kept on disk, and found to fit."""

import gzip
from pathlib import Path

import pytest

from arramon_dataset.alignment.model import Alignment, contradicts, learn, load, read, save, words_of
from arramon_dataset.alignment.routes import Tokens, mirrored
from arramon_dataset.paraphrases.collection import HALVES, generated_episodes, paraphrases
from arramon_server.errors import BadFile

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
def model() -> Alignment:
    return learn(PAIRS * 2, len(PAIRS) * 2)


def test_words_have_letters_of_both_scripts() -> None:
    assert words_of("Turn left, at the TV! बाएँ मुड़ें।") == ["turn", "left", "at", "the", "tv", "बाएँ", "मुड़ें"]


def test_left_and_right_are_exchanged_in_turns_and_sides_alone() -> None:
    assert mirrored(("turn:left", "turn:slight", "side:right", "thing:cone")) == (
        "turn:right", "turn:slight", "side:left", "thing:cone",
    )  # fmt: skip


@pytest.mark.parametrize(("text", "route"), PAIRS)
def test_a_text_fits_its_own_route_best(model: Alignment, text: str, route: Tokens) -> None:
    assert model.margin(text, route) > 0.0
    assert model.rank(text, route) == 0
    assert model.rank(text, mirrored(route)) > 0


def test_unknown_words_and_tokens_say_nothing(model: Alignment) -> None:
    assert model.score("lovely weather", CONE_LEFT) == 0.0
    assert model.score("left", (*CONE_LEFT, "thing:unicorn")) == model.score("left", CONE_LEFT)


def test_a_model_is_read_as_it_was_written(model: Alignment, tmp_path: Path) -> None:
    for name in ("one.json.gz", "other.json.gz"):
        save(model, tmp_path / name)
    assert (tmp_path / "one.json.gz").read_bytes() == (tmp_path / "other.json.gz").read_bytes()
    again = read(tmp_path / "one.json.gz")
    assert (again.words, again.tokens, again.others) == (model.words, model.tokens, model.others)
    for text, route in PAIRS[:4]:
        assert again.score(text, route) == pytest.approx(model.score(text, route), abs=0.01)


BROKEN = {"empty": b"", "no gzip": b"no gzip", "no model": gzip.compress(b"{}"), "a list": gzip.compress(b"[1]")}


@pytest.mark.parametrize("content", BROKEN.values(), ids=BROKEN)
def test_a_broken_model_is_named(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "en.json.gz"
    path.write_bytes(content)
    with pytest.raises(BadFile, match=r"en\.json\.gz"):
        read(path)


def test_a_language_without_a_model_is_not_checked() -> None:
    assert load("xx") is None
    assert not contradicts("go left", "xx", CONE_LEFT)


@pytest.mark.parametrize("code", ["en", "hi"])
def test_paraphrases_of_the_test_half_name_their_targets_own_tokens(code: str) -> None:
    """Colours, patterns and kinds of the targets are aligned, though no word list was given."""
    model = load(code)
    assert model is not None
    targets = {
        (episode.episode_id, number): episode.turns[number - 1].target.type
        for episode in generated_episodes()
        for number in (1, 2)
    }
    right, tried = 0, 0
    for text in paraphrases():
        if (text.half, text.language) == (HALVES[1], code):
            target = targets[text.episode, text.turn]
            own = (f"target:{target.pattern}", f"target:{target.colour}", f"target:{target.kind}")
            other = (f"target:{target.pattern}", f"target:{target.colour}", f"target:{OTHER_KIND[target.kind]}")
            right += model.score(text.navigation, own) > model.score(text.navigation, other)
            tried += 1
    assert tried == 312
    assert right > 0.95 * tried


OTHER_KIND = {
    "ball": "mug", "mug": "tv", "tv": "book", "book": "bowl", "bowl": "bucket", "bucket": "hourglass",
    "hourglass": "ball",
}  # fmt: skip
