"""The notation of the languages' patterns."""

import pytest

from arramon_lang.patterns import Alternatives, Slot, parse, possible_slots, required_slots, spell_out, split_weight

KNOWN = frozenset(("thing", "side", "where"))


def test_pattern_is_parsed_into_words_slots_and_choices() -> None:
    pattern = parse("^{go} (past|by) {thing:oblique.plural} [on your {side}]")
    assert pattern.main_only
    assert pattern.body == (
        Slot("go"), " ", Alternatives((("past",), ("by",))), " ", Slot("thing", ("oblique", "plural")), " ",
        Alternatives((("on your ", Slot("side")), ())),
    )  # fmt: skip
    assert [slot.name for slot in pattern.slots()] == ["go", "thing", "side"]


def test_weights_stand_at_the_front_of_a_pattern_or_of_a_choice() -> None:
    pattern = parse("0.5* ^{go} (3* past|by) [0* straight|2* on] {thing}")
    assert (pattern.weight, pattern.main_only) == (0.5, True)
    past, straight = (part for part in pattern.body if isinstance(part, Alternatives))
    assert (past.options, past.weights) == ((("past",), ("by",)), (3.0, 1.0))
    assert (straight.options, straight.weights) == ((("straight",), ("on",), ()), (0.0, 2.0, 1.0))
    assert parse("(past|by)").body == (Alternatives((("past",), ("by",))),)
    assert [split_weight(text) for text in ("12* walk", "walk 12* on", "180 degrees")] == [
        (12.0, "walk"), (1.0, "walk 12* on"), (1.0, "180 degrees"),
    ]  # fmt: skip


@pytest.mark.parametrize("text", ["{thing", "a (b", "a [b)", "a) b", "a | b", "thing}", "(a]"])
def test_unbalanced_brackets_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match="unbalanced brackets") as raised:
        parse(text)
    assert repr(text) in str(raised.value)


@pytest.mark.parametrize(
    ("text", "must", "may"),
    [
        ("{go} past {thing}", {"thing"}, {"thing"}),
        ("past {thing} [on your {side}]", {"thing"}, {"thing", "side"}),
        ("({thing} {side}|{thing})", {"thing"}, {"thing", "side"}),
        ("({thing}|{where})", set(), {"thing", "where"}),
        ("straight on", set(), set()),
    ],
)
def test_needed_and_possible_slots_are_determined(text: str, must: set[str], may: set[str]) -> None:
    body = parse(text).body
    assert required_slots(body, KNOWN) == must
    assert possible_slots(body, KNOWN) == may


def test_spell_out_gives_every_text_of_a_pattern() -> None:
    texts = spell_out(parse("{go} [right] (left|on)").body, {"go": ("walk", "go")})
    assert sorted(" ".join(text.split()) for text in texts) == [
        "go left", "go on", "go right left", "go right on", "walk left", "walk on", "walk right left", "walk right on",
    ]  # fmt: skip
