"""Noun phrases and relations as a text states them, before references are resolved."""

from dataclasses import dataclass, field

PLAIN, SAME, PRONOUN, OWN = "", "same", "it", "its"


@dataclass(frozen=True, slots=True)
class NounPhrase:
    """A noun phrase; its attributes are those of `arramon_lang.meaning.Thing`.

    Attributes:
        reference: SAME for an earlier thing of its kind ("that bench"), PRONOUN for the last thing mentioned ("it"),
            OWN for a corner of the last building ("its corner"), otherwise PLAIN.
        number: as in `arramon_lang.meaning.Thing`; "several" also for a plural without a number.
        arms: as in `arramon_lang.meaning.Thing`, if the noun implies it.
    """

    kind: str
    colour: str = ""
    look: str = ""
    which: str = ""
    where: tuple["RelationPhrase", ...] = ()
    reference: str = PLAIN
    number: str = ""
    arms: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class RelationPhrase:
    """A relation with unresolved noun phrases; see `arramon_lang.meaning.Where`."""

    relation: str
    things: tuple[NounPhrase, ...]
    exactly: bool = False
