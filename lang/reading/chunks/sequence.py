"""Chunks of one text in order, with queries about their neighbours."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from arramon_lang.meaning import Thing
from arramon_lang.reading.chunks.chunker import LOOK, RELATION, SIDE, STOP, THEN, THING, VERB, YOURS, Chunk
from arramon_lang.reading.chunks.rules import ChunkRules
from arramon_lang.reading.noun_phrases import NounPhraseParser
from arramon_lang.reading.parsed_phrases import NounPhrase


@dataclass(frozen=True, slots=True)
class ChunkSequence:
    """The chunks of a text.

    Attributes:
        chunks: in order.
        noun_phrases: parser of the language's noun phrases.
        rules: meanings of the language's relations and verbs.
    """

    chunks: Sequence[Chunk]
    noun_phrases: NounPhraseParser
    rules: ChunkRules

    def is_collectible(self, number: int) -> bool:
        """Return whether a chunk names a single collectible."""
        chunk = self.chunks[number]
        return chunk.kind == THING and len(chunk.things) == 1 and self.noun_phrases.is_collectible(chunk.things[0])

    def is_negated(self, number: int) -> bool:
        """Return whether the text says that a thing is not the target."""
        if self.rules.negates_before and self._meets_negation(range(number - 1, -1, -1), (STOP, "comma", "but")):
            return True
        after = range(number + 1, len(self.chunks))
        if self.rules.negates_before:
            return self._meets_negation(after, (STOP, "comma", THING)) and not self._is_about_next(number)
        return self._meets_negation(after, (STOP,))

    def _meets_negation(self, numbers: range, ends: Sequence[str]) -> bool:
        """Return whether the first of these chunks that ends a thing's clause is "not"."""
        for n in numbers:
            if self.chunks[n].kind in ("not", *ends) or self.is_collectible(n):
                return self.chunks[n].kind == "not"
        return False

    def _is_about_next(self, number: int) -> bool:
        """Return whether a "not" after a thing negates the next thing: "the red bowl, not the blue one"."""
        at = next(n for n in range(number, len(self.chunks)) if self.chunks[n].kind == "not")
        return self.next_kind(at) == THING

    def target(self) -> int | None:
        """Return the index of the target's chunk, the most specific collectible that is not negated, or None."""
        found = [(self._score(n), n) for n in range(len(self.chunks)) if self.is_collectible(n)]
        return max(found)[1] if found else None

    def _is_landmark(self, number: int) -> bool:
        """Return whether a collectible says where another thing is: "the mug next to the dotted red ball"."""
        if not self.rules.has_prepositions:
            return self.is_landmark_after(number)
        before = self.chunks[number - 1] if number else None
        is_placing = before is not None and before.kind == RELATION and self.rules.is_in(before.value, "placing")
        return is_placing and number > 1 and self.is_collectible(number - 2)

    def is_landmark_after(self, number: int) -> bool:
        """Return whether a relation after a collectible says where the one named right before it is."""
        named = number - 1 - (number > 0 and self.chunks[number - 1].kind == "comma")
        after = self.chunks[number + 1] if number + 1 < len(self.chunks) else None
        if named < 0 or not self.is_collectible(named) or after is None or after.kind != RELATION:
            return False
        is_side = after.value == "of" and self.next_kind(number + 1) == SIDE
        return is_side or after.value in self.rules.target_relations

    def described(self, target: Thing, number: int) -> Thing:
        """Return a target with what the text says of it later: "the ball over there, the striped one".

        Args:
            target: the target as its chunk names it.
            number: index of that chunk.
        """
        if target.look and target.colour:
            return target
        later = self._later_description(number)
        return replace(target, look=target.look or later.look, colour=target.colour or later.colour)

    def _later_description(self, number: int) -> NounPhrase:
        for n in range(number + 1, len(self.chunks)):
            chunk = self.chunks[n]
            if chunk.kind in (STOP, "not"):
                break
            if chunk.kind == LOOK:
                return NounPhrase("", look=chunk.value)
            if self.is_collectible(n):
                return chunk.things[0] if chunk.things[0].kind == "" else NounPhrase("")
        return NounPhrase("")

    def is_relation(self, number: int, *values: str) -> bool:
        """Return whether a chunk is one of these relations."""
        chunk = self.chunks[number] if 0 <= number < len(self.chunks) else None
        return chunk is not None and chunk.kind == RELATION and chunk.value in values

    def next_is_relation(self, number: int, *values: str) -> bool:
        """Return whether the next chunk is one of these relations."""
        return self.is_relation(number + 1, *values)

    def next_kind(self, number: int) -> str:
        """Return the kind of the next chunk, or "" at the end."""
        return self.chunks[number + 1].kind if number + 1 < len(self.chunks) else ""

    def verb_after(self, number: int) -> str:
        """Return the value of the next verb, ignoring adverbs before it; "" without one."""
        for chunk in self.chunks[number + 1 :]:
            if chunk.kind not in ("straight", "ahead", "there", "back_again", THEN, YOURS):
                return chunk.value if chunk.kind == VERB else ""
        return ""

    def _score(self, number: int) -> tuple[bool, bool, int]:
        chunk = self.chunks[number]
        named = chunk.things[0]
        named_as = sum(map(bool, (named.kind, named.colour, named.look)))
        return not (chunk.is_additional or self.is_negated(number)), not self._is_landmark(number), named_as
