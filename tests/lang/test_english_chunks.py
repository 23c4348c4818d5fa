"""Reading of free English texts by chunks, beyond the written phrases."""

import pytest

from arramon_lang import load
from arramon_lang.meaning import Face, Navigation, Rotate, Step, Thing, Walk, Where

CONE, BOOTH, BANK = Thing("cone", "blue"), Thing("phone_booth"), Thing("shop_sign", look="bank")
HYDRANT, BENCH, CROSSING = Thing("hydrant"), Thing("bench"), Thing("zebra_crossing")
HOUSE, END, ALLEY = Thing("building", look="white"), Thing("street_end"), Thing("alley")
YOU = Thing("you")

BALL = " A striped red ball."

STEPS: list[tuple[str, tuple[Step, ...]]] = [
    # Where a turn is made: before it and behind it, with and without a comma.
    ("Round the white house to the right, then left.", (Rotate("right", "at", HOUSE), Rotate("left"))),
    (
        "By the bank left, then hard right before the hydrant.",
        (Rotate("left", "at", BANK), Rotate("right", "before", HYDRANT)),
    ),
    ("At its end, I think, right around the blue cone.", (Walk("to", (END,)), Rotate("right", "at", CONE))),
    ("Not quite to the hydrant. Left there, or so.", (Rotate("left", "before", HYDRANT),)),
    (
        "Walk towards the bank, but turn left before you get there.",
        (Walk("towards", (BANK,)), Rotate("left", "before", BANK)),
    ),
    ("Left into the narrow lane by the bank.", (Rotate("left", "at", BANK), Walk("along", (ALLEY,)))),
    ("Right after the bench, turn left.", (Rotate("left", "after", BENCH),)),
    # Counted streets: at the second one, not along it from here.
    ("Go into the second street on your right.", (Rotate("right", "at", Thing("street", which="second")),)),
    ("turn left into the second street", (Rotate("left", "at", Thing("street", which="second")),)),
    ("Turn left, turn slightly right at the bench.", (Rotate("left"), Rotate("slightly right", "at", BENCH))),
    # Turning around.
    ("Back round to the left, past the bench.", (Rotate("around"), Walk("past", (BENCH,)))),
    ("Turn right about, so the bank is behind you, and by the bench.", (Rotate("around"), Walk("past", (BENCH,)))),
    ("Swing round left into the lane.", (Rotate("left"), Walk("along", (ALLEY,)))),
    # Sides: of things that are listed, of all of a list, of nothing.
    ("Bench left, hydrant right.", (Walk("past", (BENCH,), "left"), Walk("past", (HYDRANT,), "right"))),
    ("Past bench and hydrant, both left now.", (Walk("past", (BENCH,), "left"), Walk("past", (HYDRANT,), "left"))),
    (
        "With on your left the bank, later on your right a bench.",
        (Walk("past", (BANK,), "left"), Walk("past", (BENCH,), "right")),
    ),
    ("Follow the lane right down to the hydrant.", (Walk("along", (ALLEY,)), Rotate("right"), Walk("to", (HYDRANT,)))),
    (
        "Into the lane. Follow it right down to the hydrant.",
        (Walk("along", (ALLEY,)), Walk("to", (HYDRANT,))),
    ),
    # Corrections, hedges and what is not meant.
    ("Turn left, or rather right, at the hydrant.", (Rotate("right", "at", HYDRANT),)),
    ("Past the bench, no wait, the hydrant.", (Walk("past", (HYDRANT,)),)),
    ("Maybe past the bench, or was it the bank, and left.", (Walk("past", (BENCH,)), Rotate("left"))),
    (
        "You'll probably see a bench. Don't go to the bank, bear left.",
        (Walk("past", (BENCH,)), Rotate("slightly left")),
    ),
    # What tells a thing apart is not on the way.
    ("Left, along the white house with the star banner.", (Rotate("left"), Walk("along", (HOUSE,)))),
    ("To the corner with the bank sign, then right.", (Walk("to", (BANK,)), Rotate("right"))),
    (
        "Over one crossing, past the bench, over another.",
        (Walk("past", (CROSSING,)), Walk("past", (BENCH,)), Walk("past", (Thing("zebra_crossing", which="another"),))),
    ),
    ("Look towards the bank, then between it and the bench.", (Face(BANK), Walk("between", (BANK, BENCH)))),
]


@pytest.mark.parametrize(("text", "steps"), STEPS, ids=[text for text, _ in STEPS])
def test_steps_of_free_texts(text: str, steps: tuple[Step, ...]) -> None:
    meaning = load("en").read(text + BALL, "navigation")
    assert isinstance(meaning, Navigation)
    assert tuple(step for step in meaning.steps if step != Walk("ahead")) == steps
    assert meaning.target == Thing("ball", "red", "striped")


TARGETS: list[tuple[str, tuple[Where, ...]]] = [
    ("Left. A bit to the right, before the bench, there's the striped red ball.", (Where("in_front_of", (BENCH,)),)),
    (
        "Left. Right after the bench, in the road, lies a striped red ball.",
        (Where("behind", (BENCH,)), Where("on_top_of", (Thing("street"),))),
    ),
    (
        "Left: striped red ball, somewhat right, bank behind it.",
        (Where("right_of", (YOU,)), Where("in_front_of", (BANK,))),
    ),
    ("Left. Not the dotted mug but the ball: red, striped, right by the bench.", (Where("near", (BENCH,)),)),
    (
        "Left. The striped red ball is left of the green ball. Leave the dotted one by the bank.",
        (Where("left_of", (Thing("ball", "green"),)),),
    ),
]


@pytest.mark.parametrize(("text", "where"), TARGETS, ids=[text for text, _ in TARGETS])
def test_targets_of_free_texts(text: str, where: tuple[Where, ...]) -> None:
    meaning = load("en").read(text, "navigation")
    assert isinstance(meaning, Navigation)
    assert meaning.steps == (Rotate("left"),)
    assert meaning.target == Thing("ball", "red", "striped", where=where)


def test_what_is_to_be_picked_up_is_no_aside() -> None:
    meaning = load("en").read("Left at the bank, where a striped red ball lies or so.", "navigation")
    assert meaning == Navigation((Rotate("left", "at", BANK),), Thing("ball", "red", "striped"))
