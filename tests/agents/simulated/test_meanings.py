"""Generated texts with meanings: exchanged things, combined steps, all languages."""

import itertools
from random import Random

import arramon_lang as lang
from arramon_agents.reading.reader.slots import rows_of
from arramon_agents.simulated.meanings import draw_samples, randomise_things, write_in_all_languages
from arramon_lang.meaning import Navigation, Rotate, Thing, Walk, Where

BENCH = Thing("bench", identity="1")
PLAN = Navigation(
    (Rotate("left", "at", BENCH), Walk("past", (Thing("building", look="brick", identity="2"),)), Walk("to", (BENCH,))),
    Thing("mug", "red", "dotted", where=(Where("near", (Thing("cone", "red", identity="3"),)),), identity="4"),
)


def test_things_are_exchanged_for_others_that_are_named_as_fully() -> None:
    seen, directions = set(), set()
    for seed in range(30):
        other = randomise_things(PLAN, Random(seed))
        assert isinstance(other, Navigation)
        first, second, third = other.steps
        assert isinstance(first, Rotate)
        assert isinstance(second, Walk)
        assert isinstance(third, Walk)
        assert (first.at, second.way, third.way) == ("at", "past", "to")
        directions.add(first.direction)
        assert first.thing == third.things[0]
        assert first.thing is not None
        assert not first.thing.colour
        assert second.things[0].kind == "building"
        assert second.things[0].look
        assert other.target.colour
        assert other.target.look
        assert other.target.where[0].things[0].colour
        rows_of(other)
        seen.add(other)
    assert len(seen) > 20
    assert "left" in directions  # Most directions stay as they are.
    assert len(directions) > 2


def test_texts_are_drawn_in_all_languages_by_the_seed() -> None:
    one, again, other = (list(draw_samples([PLAN], lang.required(), 12, seed)) for seed in (1, 1, 2))
    assert one == again != other
    plain = [sample for number, sample in enumerate(one) if not number or sample.meaning is not one[number - 1].meaning]
    assert [sample.language for sample in plain] == ["en", "hi"] * 6
    assert all(lang.identify(sample.text) == sample.language for sample in plain)


def test_some_texts_come_again_in_a_form_that_people_type() -> None:
    drawn = list(draw_samples([PLAN], lang.required(), 40, 1))
    forms = [two for one, two in itertools.pairwise(drawn) if two.meaning is one.meaning]
    assert 24 <= len(forms) < 40
    assert all(one.text != two.text for one, two in itertools.pairwise(drawn) if two in forms)
    assert any(sample.language == "hi" and sample.text.isascii() for sample in forms)


def test_two_processes_draw_the_same_texts() -> None:
    alone, together = (list(draw_samples([PLAN], lang.required(), 6, 1, processes)) for processes in (1, 2))
    assert alone == together


def test_plans_are_written_as_they_are() -> None:
    samples = list(write_in_all_languages([PLAN], lang.required(), 0))
    assert [(sample.language, sample.meaning) for sample in samples] == [("en", PLAN), ("hi", PLAN)]
    assert "bench" in samples[0].text.lower()


def test_an_intersection_is_called_by_both_of_its_hindi_names() -> None:
    meaning = Navigation((Walk("to", (Thing("intersection", identity="1"),)), Rotate("left")), PLAN.target)
    texts = [lang.load("hi").write(randomise_things(meaning, Random(seed)), Random(seed)) for seed in range(12)]
    assert {name for name in ("तिराह", "चौराह") if any(name in text for text in texts)} == {"तिराह", "चौराह"}
