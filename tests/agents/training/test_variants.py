"""Variants of demonstrations: features, instructions and actions change consistently."""

from dataclasses import replace
from random import Random

import numpy as np
import pytest

import arramon_lang as lang
from arramon_agents.perception.eyes.grid import CHANNEL_NAMES
from arramon_agents.training.demonstrations import PhaseDemonstration
from arramon_agents.training.name_permutation import read_meaning
from arramon_agents.training.variants import Variants, mirrored
from arramon_client.agent import Action
from arramon_lang.meaning import Face, Navigation, Rotate, Thing, Walk, Where

MEANT = Navigation(
    (
        Rotate("left"),
        Walk("past", (Thing("bench"),), "right"),
        Rotate("slightly right", "at", Thing("phone_booth")),
        Face(Thing("mailbox")),
    ),
    Thing("mug", "red", "dotted", where=(Where("left_of", (Thing("tv", "blue"),)),)),
)
ACTIONS = [Action.LEFT, Action.FORWARD, Action.RIGHT, Action.RIGHT, Action.INTERACT]


def demonstration(phase: str = "navigation", channels: int = len(CHANNEL_NAMES)) -> PhaseDemonstration:
    """In each image a red mug is in the left column."""
    features = np.zeros((len(ACTIONS), 7, 7, channels), np.uint8)
    for name in ("kind:mug", "colour:red") if channels else ():
        features[:, 3, 0, CHANNEL_NAMES.index(name)] = 200
    texts = {code: lang.load(code).write(MEANT, Random(1)) for code in ("en", "hi")}
    return PhaseDemonstration("7", 1, phase, texts, np.array(ACTIONS, np.uint8), features)


def variants(shown: PhaseDemonstration, count: int = 12, languages: tuple[str, ...] = ("en", "hi")) -> Variants:
    names = CHANNEL_NAMES if shown.features.shape[-1] else None
    return Variants([shown], languages, count, names, seed=3)


def test_in_a_mirror_left_is_right_in_every_phrase() -> None:
    steps = (
        Rotate("right"),
        Walk("past", (Thing("bench"),), "left"),
        Rotate("slightly left", "at", Thing("phone_booth")),
        Face(Thing("mailbox")),
    )
    target = replace(MEANT.target, where=(Where("right_of", (Thing("tv", "blue"),)),))
    assert mirrored(MEANT) == Navigation(steps, target)
    assert mirrored(mirrored(MEANT)) == MEANT


def test_what_is_seen_said_and_done_changes_alike() -> None:
    made, sides = variants(demonstration()), set()
    for number in range(1, 13):
        variant = made.variant(0, number)
        rows, columns, channels = np.nonzero(variant.features[0])
        seen = dict(CHANNEL_NAMES[channel].split(":") for channel in channels)
        assert set(rows) == {3}
        (column,) = set(columns)
        meanings = [lang.load(code).read(text, "navigation") for code, text in variant.texts.items()]
        assert len(meanings) == 2
        for meaning in meanings:
            assert isinstance(meaning, Navigation)
            assert (meaning.target.kind, meaning.target.colour) == (seen["kind"], seen["colour"])
            turn = meaning.steps[0]
            assert turn == Rotate("left" if column == 0 else "right")
        first = Action.LEFT if column == 0 else Action.RIGHT
        assert variant.actions.tolist()[:2] == [first, Action.FORWARD]
        assert variant.actions[-1] == Action.INTERACT
        sides.add(column)
    assert sides == {0, 6}


def test_a_variant_follows_from_seed_and_number_alone() -> None:
    one, other = variants(demonstration()), variants(demonstration())
    other.variant(0, 5)
    for made in (one, other):
        made.draw(0, Random(2))
    assert one.variant(0, 3).texts == other.variant(0, 3).texts
    assert len({one.variant(0, number).texts["en"] for number in range(13)}) > 6


def test_without_variants_a_demonstration_is_drawn_as_it_is() -> None:
    shown = demonstration()
    assert variants(shown, 0).draw(0, Random(2)) is shown
    assert variants(shown).variant(0, 0) is shown


def test_things_stay_where_the_channels_have_no_names_that_could_be_exchanged() -> None:
    shown = replace(demonstration(channels=0), features=np.zeros((5, 7, 7, 3), np.uint8))
    made = Variants([shown], ("en",), 6, ("red", "green", "blue"), seed=3)
    for number in range(1, 7):
        meaning = lang.load("en").read(made.variant(0, number).texts["en"], "navigation")
        assert meaning in (MEANT, mirrored(MEANT))


def test_what_does_not_read_needs_no_texts() -> None:
    shown = replace(demonstration(), texts={"en": "No grammar reads this."})
    made = variants(shown, languages=())
    assert made.variant(0, 1).texts == shown.texts
    assert (made.variant(0, 1).features != shown.features).any()


@pytest.mark.parametrize("number", range(1, 5))
def test_without_images_texts_change_alone(number: int) -> None:
    variant = variants(demonstration(channels=0)).variant(0, number)
    assert variant.features.shape == (5, 7, 7, 0)
    assert lang.load("en").read(variant.texts["en"], "navigation") not in (MEANT, mirrored(MEANT))


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("Keep going until you see two posters. Pick up the striped white bucket.", "no wording"),
        ("Nothing that leads anywhere.", "nothing understood"),
    ],
)
def test_a_text_that_the_grammar_cannot_write_anew_stays_as_it_is(text: str, fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        lang.load("en").write(lang.load("en").read(text, "navigation"), Random(1))
    shown = replace(demonstration(), texts={"en": text})
    made = variants(shown, count=2, languages=("en",))
    for number in (1, 2):
        variant = made.variant(0, number)
        assert variant.texts == shown.texts
        assert np.array_equal(variant.features, shown.features)
        assert np.array_equal(variant.actions, shown.actions)


def test_hindi_tells_three_streets_from_four_in_variants_too() -> None:
    turn = Rotate("left", "at", Thing("intersection", identity="1", arms=3))
    meaning = Navigation((turn, *MEANT.steps[1:]), MEANT.target)
    texts = {code: lang.load(code).write(meaning, Random(1)) for code in ("en", "hi")}
    made = variants(replace(demonstration(), texts=texts))
    for number in range(13):
        assert "तिराह" in made.variant(0, number).texts["hi"]


def test_what_cannot_be_read_in_one_language_is_read_in_the_first() -> None:
    texts = {code: lang.load(code).write(MEANT, Random(1)) for code in ("en", "hi")} | {"hi": "क ख ग"}
    assert read_meaning(texts, "navigation") == MEANT
    with pytest.raises(ValueError, match="nothing understood"):
        read_meaning(dict(reversed(texts.items())), "navigation")
