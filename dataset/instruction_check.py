"""Quality checks of instructions written by people, for `arramon-server check-instruction`."""

from collections.abc import Iterable, Iterator

from arramon_lang import UnknownLanguage, load
from arramon_lang.meaning import Thing
from arramon_lang.quality import Failure, check
from arramon_server.errors import BadInput


def check_texts(
    texts: Iterable[str], language: str, phase: str, target: str = "", first_turn: float = 0.0
) -> Iterator[tuple[str, tuple[Failure, ...]]]:
    """Check texts lazily, yielding each with the checks that it fails.

    Args:
        texts: instructions.
        language: code of the language that they should be written in.
        phase: "navigation" or "assembly".
        target: the object to pick up or place, in words of the language ("dotted brown bucket"); "" to skip the check
            that the instruction names it.
        first_turn: degrees by which the ground truth turns before its first step forward.

    Raises:
        BadInput: if the language does not exist, or `target` does not name exactly one object in it.
    """
    thing = _read_target(target, language)
    for text in texts:
        yield text, check(text, language, phase, target=thing, first_turn=first_turn)


def _read_target(words: str, code: str) -> Thing | None:
    try:
        mentions = load(code).find_objects(words)
    except UnknownLanguage as unknown:
        raise BadInput(str(unknown)) from None
    if not words:
        return None
    if len(mentions) != 1:
        raise BadInput(f"target {words!r} names {len(mentions)} objects; expected one, such as 'dotted brown bucket'")
    (mention,) = mentions
    return Thing(mention.kind or "", mention.colour or "", mention.pattern or "")
