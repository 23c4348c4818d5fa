"""Gate checks of texts: reading a text must give back its meaning, and names must be unambiguous.

`navigation` and `assembly` beside this file check the meaning itself against the world. The gate shares no code with
the planners except geometry and what a relation in the room means to a person
(`arramon_dataset.instructions.assembly.cells`).
"""

from collections.abc import Iterator

import arramon_lang as lang
from arramon_lang.coreference import first_mentions, mentions
from arramon_lang.meaning import Meaning, Navigation, Thing


def faults_of_text(text: str, language: str, meaning: Meaning) -> tuple[str, ...]:
    """Return how the reading of a text differs from its meaning; () if it does not.

    Args:
        text: an instruction.
        language: its code.
        meaning: the intended one, with identities.
    """
    return faults_of_reading(text, lang.load(language), meaning)


def faults_of_reading(text: str, language: lang.Language, meaning: Meaning) -> tuple[str, ...]:
    """Return the same for a language given as itself."""
    phase = "navigation" if isinstance(meaning, Navigation) else "assembly"
    try:
        read = language.read(text, phase)
    except lang.CannotRead as error:
        return (str(error),)
    if read != meaning:
        return (f"says {_difference(read, meaning)}",)
    if first_mentions(read) != first_mentions(meaning):
        return (f"takes one thing for another: {_mixed_up(read, meaning)}",)
    return ()


def faults_of_names(meaning: Meaning) -> Iterator[str]:
    """Yield each mention whose name also fits an earlier thing, and each "next" or "another" without an earlier one."""
    earlier: list[Thing] = []
    for thing in mentions(meaning):
        if not thing.identity or not thing.kind:
            continue
        named = [other for other in earlier if other.kind == thing.kind]
        is_new = all(other.identity != thing.identity for other in named)
        if is_new and thing.which not in ("next", "another"):
            for other in named:
                if other.number == thing.number and _is_name_of(thing, other):
                    yield f"{_called(thing)} is also called {_called(other)}"
        if is_new and thing.which in ("next", "another") and not named:
            yield f"{_called(thing)}, but none was named before"
        earlier.append(thing)


def _is_name_of(thing: Thing, other: Thing) -> bool:
    """Return whether every attribute of a name fits the name of an earlier thing."""
    return (
        thing.colour in ("", other.colour)
        and thing.look in ("", other.look)
        and thing.which in ("", other.which)
        and thing.where in ((), other.where)
    )


def _called(thing: Thing) -> str:
    words = (thing.number, thing.which, thing.look, thing.colour, thing.kind)
    return f"the {' '.join(word for word in words if word)} {thing.identity}"


def _difference(read: Meaning, meaning: Meaning) -> str:
    if isinstance(read, Navigation) and isinstance(meaning, Navigation):
        for one, other in zip(read.steps, meaning.steps, strict=False):
            if one != other:
                return f"{one}; expected {other}"
        if len(read.steps) != len(meaning.steps):
            return f"{len(read.steps)} steps; expected {len(meaning.steps)}"
        return f"{read.target}; expected {meaning.target}"
    return f"{read}; expected {meaning}"


def _mixed_up(read: Meaning, meaning: Meaning) -> str:
    pairs = zip(first_mentions(read), first_mentions(meaning), mentions(meaning), strict=True)
    return next(f"{_called(thing)}" for one, other, thing in pairs if one != other)
