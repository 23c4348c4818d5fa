"""Where the object to pick up is, by the phrases that follow it."""

from collections.abc import Iterator
from dataclasses import replace

from arramon_lang.meaning import Thing, Where
from arramon_lang.reading.chunks.chunker import SIDE
from arramon_lang.reading.chunks.prepositions.phrases import OTHER, PLACES, SIDES, STOP, THINGS, Phrase, PhraseSequence
from arramon_lang.reading.discourse import GROUND_KINDS

_WHERES = {
    "on": "on_top_of", "into": "on_top_of", "before": "in_front_of", "in_front_of": "in_front_of",
    "until": "in_front_of", "after": "behind", "behind": "behind", "past": "behind", "over": "behind",
    "between": "between", "left_of": "left_of", "right_of": "right_of",
}  # fmt: skip
"""Relations that words name; others say that it is near."""

_OPPOSITES = {"behind": "before", "after": "before", "before": "behind", "in_front_of": "behind"}


def relations(phrase: Phrase) -> Iterator[Where]:
    """Yield the relations of the object to pick up to the things of a phrase."""
    things = tuple(each.thing for each in phrase.named)
    relation = _WHERES.get(phrase.value, "near")
    if relation == "between" and len(things) > 1:
        yield Where("between", things[:2])
        return
    relation = "near" if relation == "between" else relation
    yield from (
        Where(relation, (thing,)) for thing in things if not (thing.kind in GROUND_KINDS and relation == "near")
    )


def relations_after(phrases: PhraseSequence) -> Iterator[Where]:
    """Yield what is said of the object to pick up after it has been named."""
    is_other = False
    for number in range(phrases.target + 1, len(phrases.listed)):
        phrase = phrases.listed[number]
        if phrase.kind == "not":
            return
        if phrase.kind in (STOP, OTHER):
            is_other = phrase.kind == OTHER and phrase.value not in (*PLACES, "between", "past")
        if is_other:
            continue
        if _is_shown_by_target(phrases, number):
            yield from relations(replace(phrase, value=_OPPOSITES[_place_after(phrases, number).value]))
        elif phrase.kind == OTHER or (phrase.kind == THINGS and _is_place(phrases, number)):
            yield from relations(phrase)
        elif phrase.kind == SIDE and phrase.value in SIDES and not _is_stress(phrases, number):
            yield Where(f"{phrase.value}_of", (Thing("you"),))


def _is_shown_by_target(phrases: PhraseSequence, number: int) -> bool:
    """Return whether it is told where something is of the object to pick up: "the pharmacy is behind it"."""
    phrase, place = phrases.listed[number], _place_after(phrases, number)
    is_of_it = place.is_pronoun and not place.joined and place.value in _OPPOSITES
    return phrase.kind == THINGS and not phrase.value and is_of_it


def _place_after(phrases: PhraseSequence, number: int) -> Phrase:
    """Return the things that follow within two phrases, or else the phrase itself."""
    after = phrases.listed[number + 1 : number + 3]
    return next((each for each in after if each.kind == THINGS), phrases.listed[number])


def _is_place(phrases: PhraseSequence, number: int) -> bool:
    """Return whether things say where the object is, not what another thing looks like."""
    phrase, before = phrases.listed[number], phrases.listed[number - 1]
    if phrase.is_pronoun and _is_shown_by_target(phrases, number - 1):
        return False
    return phrase.value != "with" and not (before.kind == THINGS and phrase.value == "of")


def _is_stress(phrases: PhraseSequence, number: int) -> bool:
    """Return whether "right" only stresses what follows: "right there"."""
    phrase = phrases.listed[number]
    return phrase.value == "right" and not phrase.chunk.nominal and phrases.is_next(number, "there", "ahead", THINGS)
