"""Relation beside one mention, for quality checks and missing objects; `parser.py` parses instructions."""

from collections.abc import Mapping, Sequence
from typing import Any

from arramon_lang.lexicon import FUZZY_LENGTH, Lexicon, WordRole, keys_of, within_one_edit
from arramon_lang.reading.mentions import Mention
from arramon_lang.tokens import ScriptTokenizer, Token

RELATIONS = ("on_top_of", "left_of", "right_of", "in_front_of", "behind", "between", "near", "against")

_POSITIONS = ("before", "after")


class Relations:
    """Relation phrases of one language, from its `relations.toml`.

    The data says whether a phrase precedes its landmark ("behind the mug") or follows it ("मग के पीछे"). Words are
    matched outwards from the landmark, so that the two cases differ only in direction.

    Args:
        data: content of the file.
        tokenizer: the language's tokenizer.
        lexicon: the language's lexicon.

    Raises:
        ValueError: if the position or a relation is unknown, or a relation is missing.
    """

    def __init__(self, data: Mapping[str, Any], tokenizer: ScriptTokenizer, lexicon: Lexicon) -> None:
        if data["position"] not in _POSITIONS:
            raise ValueError(f"relations: position {data['position']!r} is not one of {', '.join(_POSITIONS)}")
        if set(data["phrases"]) != set(RELATIONS):
            raise ValueError(f"relations: phrases for {', '.join(data['phrases'])}; expected {', '.join(RELATIONS)}")
        self._before = data["position"] == "before"
        self._lexicon = lexicon
        self._tokenizer = tokenizer
        self._conjunctions = frozenset(data["conjunctions"])
        self._skipped = self._phrases({"": data["skipped"]})
        # Longest first, so that "to the right of" does not match as "of", nor "on the right of" as "on".
        self._relations = self._phrases(data["phrases"])
        self._vocabulary = frozenset(word for phrase, _ in self._relations for word in phrase)

    def of(self, tokens: Sequence[Token], mention: Mention) -> str | None:
        """Return the relation whose landmark is `mention`, one of RELATIONS, or None.

        Two landmarks joined by a conjunction ("between the wall and the mug") both have the relation.
        """
        if self._before:
            outwards = keys_of(token for token in tokens if token.end <= mention.start)[::-1]
        else:
            outwards = keys_of(token for token in tokens if token.start >= mention.end)
        words = self._without_skipped(outwards)
        relation = self._at(words)
        if relation or not words or words[0] not in self._conjunctions:
            return relation
        passed = self._pass_noun_phrase(words, 1)
        return self._at(words[passed:]) if passed > 1 else None

    def _at(self, words: Sequence[str]) -> str | None:
        """Return the relation expressed by the first of `words` (outwards), or None."""
        for phrase, relation in self._relations:
            if phrase == tuple(words[: len(phrase)]):
                return relation
        near = [
            (p, relation) for p, relation in self._relations if len(p) <= len(words) and all(map(self._same, words, p))
        ]
        relations = {relation for phrase, relation in near if len(phrase) == len(near[0][0])}
        return relations.pop() if len(relations) == 1 else None

    def _same(self, written: str, word: str) -> bool:
        """Return whether `written` is `word`, exactly or with a typing error that makes no other word of a phrase."""
        misspelt = len(word) >= FUZZY_LENGTH and written not in self._vocabulary
        return written == word or (misspelt and within_one_edit(written, word))

    def _without_skipped(self, outwards: Sequence[str]) -> list[str]:
        words, i = [], 0
        while i < len(outwards):
            for phrase, _ in self._skipped:
                if tuple(outwards[i : i + len(phrase)]) == phrase:
                    i += len(phrase)
                    break
            else:
                words.append(outwards[i])
                i += 1
        return words

    def _pass_noun_phrase(self, words: Sequence[str], start: int) -> int:
        """Return the index after the noun phrase that begins at `start`; `start` if there is none."""
        end, noun = start, False
        while end < len(words):
            # The lexicon matches from an entry's first word in reading order, which is the last one outwards.
            ahead = words[end : end + 3]
            for length in range(len(ahead), 0, -1):
                entry = ahead[:length][::-1] if self._before else ahead[:length]
                word = self._lexicon.read(entry, 0)
                if word is not None and word.length == length:
                    break
            else:
                break
            noun = noun or word.role in (WordRole.KIND, WordRole.PATTERNED_KIND, WordRole.OTHER)
            end += length
        return end if noun else start

    def _phrases(self, listed: Mapping[str, Sequence[str]]) -> tuple[tuple[tuple[str, ...], str], ...]:
        """Return (phrase read outwards, meaning) pairs, the longest first."""
        direction = -1 if self._before else 1
        phrases = [
            (keys_of(self._tokenizer.split(text))[::direction], meaning)
            for meaning, texts in listed.items()
            for text in texts
        ]
        return tuple(sorted(phrases, key=lambda phrase: -len(phrase[0])))
