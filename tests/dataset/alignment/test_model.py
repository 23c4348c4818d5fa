"""Word alignment models: scores of the shipped ones, and errors of invalid files."""

import gzip
from pathlib import Path

import pytest

from arramon_dataset.alignment.model import contradicts_route, load, read_model, words_of
from arramon_dataset.alignment.route_tokens import mirrored
from arramon_dataset.paraphrases.collection import HALVES, generated_episodes, paraphrases
from arramon_server.errors import BadFile


def test_words_have_letters_of_both_scripts() -> None:
    assert words_of("Turn left, at the TV! बाएँ मुड़ें।") == ["turn", "left", "at", "the", "tv", "बाएँ", "मुड़ें"]


def test_left_and_right_are_exchanged_in_turns_and_sides_alone() -> None:
    assert mirrored(("turn:left", "turn:slight", "side:right", "thing:cone")) == (
        "turn:right", "turn:slight", "side:left", "thing:cone",
    )  # fmt: skip


BROKEN = {"empty": b"", "no gzip": b"no gzip", "no model": gzip.compress(b"{}"), "a list": gzip.compress(b"[1]")}


@pytest.mark.parametrize("content", BROKEN.values(), ids=BROKEN)
def test_a_broken_model_is_named(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "en.json.gz"
    path.write_bytes(content)
    with pytest.raises(BadFile, match=r"en\.json\.gz"):
        read_model(path)


def test_a_language_without_a_model_is_not_checked() -> None:
    assert load("xx") is None
    assert not contradicts_route("go left", "xx", ("turn:left", "target:mug"))


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


def test_true_texts_with_left_of_something_on_a_way_that_ends_to_the_right_are_kept() -> None:
    """Bounds that rejected one Hindi text in fourteen dropped these."""
    by_car = "गाड़ी तक जाकर बाईं तरफ़ मुड़ें और ट्रैफ़िक लाइट के बाईं तरफ़ रखी धारीदार बैंगनी रेतघड़ी उठाएँ।"
    by_sign = "बाईं ओर मुड़ें। स्पीड लिमिट बोर्ड के बाईं ओर रखे धारीदार भूरे टीवी को उठा लें।"
    to_car = _route(
        "turn:slight turn:right thing:grey thing:building side:right thing:blue thing:awning side:right thing:blue "
        "thing:building side:left thing:mailbox side:left thing:triangle thing:black thing:banner side:right "
        "thing:brick thing:building side:right thing:corner side:left thing:tree side:left thing:t thing:junction "
        "turn:left thing:white thing:car side:right thing:tree last:slight last:right target:striped target:purple "
        "target:hourglass around:tree around:corner around:traffic around:light around:mailbox around:white around:car"
    )
    to_sign = _route(
        "turn:left thing:zebra thing:crossing thing:corner side:left thing:hydrant side:right thing:planter side:right "
        "thing:blue thing:building side:right thing:t thing:junction thing:zebra thing:crossing side:left thing:blue "
        "thing:kiosk last:slight last:right target:striped target:brown target:tv around:speed around:sign around:t "
        "around:junction around:blue around:kiosk around:corner around:planter around:hydrant"
    )
    assert not contradicts_route(by_car, "hi", to_car)
    assert not contradicts_route(by_sign, "hi", to_sign)
    assert contradicts_route(by_car, "hi", to_sign)


def _route(tokens: str) -> tuple[str, ...]:
    return tuple(tokens.split())
