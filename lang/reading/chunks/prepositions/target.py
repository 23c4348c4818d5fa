"""Relations of the target, from the phrases around its name."""

from collections.abc import Iterator
from dataclasses import replace

from arramon_lang.meaning import Thing, Where
from arramon_lang.reading.chunks.chunker import SIDE, SIDES, STOP
from arramon_lang.reading.chunks.prepositions.phrases import OTHER, THINGS, Phrase, PhraseSequence
from arramon_lang.reading.chunks.rules import ChunkRules
from arramon_lang.reading.discourse import GROUND_KINDS


def relations(phrase: Phrase, rules: ChunkRules) -> Iterator[Where]:
    """Yield the target's relations to the things of a phrase."""
    things = tuple(each.thing for each in phrase.named)
    relation = rules.target_relations.get(phrase.value, "near")
    if relation == "between" and len(things) > 1:
        yield Where("between", things[:2])
        return
    relation = "near" if relation == "between" else relation
    yield from (
        Where(relation, (thing,)) for thing in things if not (thing.kind in GROUND_KINDS and relation == "near")
    )


def relations_after(phrases: PhraseSequence) -> Iterator[Where]:
    """Yield the target's relations stated after its name."""
    is_other = False
    for number in range(phrases.target + 1, len(phrases.listed)):
        phrase = phrases.listed[number]
        if phrase.kind == "not":
            return
        if phrase.kind in (STOP, OTHER):
            is_placing = phrase.value in ("between", "past") or phrases.rules.is_in(phrase.value, "placing")
            is_other = phrase.kind == OTHER and not is_placing
        if is_other:
            continue
        if _is_located_by_target(phrases, number):
            opposite = phrases.rules.opposites[_place_after(phrases, number).value]
            yield from relations(replace(phrase, value=opposite), phrases.rules)
        elif phrase.kind == OTHER or (phrase.kind == THINGS and _is_place(phrases, number)):
            yield from relations(phrase, phrases.rules)
        elif phrase.kind == SIDE and phrase.value in SIDES and not _is_intensifier(phrases, number):
            yield Where(f"{phrase.value}_of", (Thing("you"),))


def _is_located_by_target(phrases: PhraseSequence, number: int) -> bool:
    """Return whether a thing is located relative to the target: "the pharmacy is behind it"."""
    phrase, place = phrases.listed[number], _place_after(phrases, number)
    is_of_it = place.is_pronoun and not place.joined and place.value in phrases.rules.opposites
    return phrase.kind == THINGS and not phrase.value and is_of_it


def _place_after(phrases: PhraseSequence, number: int) -> Phrase:
    """Return the first things among the next two phrases, or else the phrase itself."""
    after = phrases.listed[number + 1 : number + 3]
    return next((each for each in after if each.kind == THINGS), phrases.listed[number])


def _is_place(phrases: PhraseSequence, number: int) -> bool:
    """Return whether things locate the target rather than describe another thing."""
    phrase, before = phrases.listed[number], phrases.listed[number - 1]
    if phrase.is_pronoun and _is_located_by_target(phrases, number - 1):
        return False
    return phrase.value != "with" and not (before.kind == THINGS and phrase.value == "of")


def _is_intensifier(phrases: PhraseSequence, number: int) -> bool:
    """Return whether a side only stresses the next phrase: "right there"."""
    phrase = phrases.listed[number]
    may_stress = phrases.rules.is_in(phrase.value, "stressing") and not phrase.chunk.nominal
    return may_stress and phrases.is_next(number, "there", "ahead", THINGS)
