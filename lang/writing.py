"""Says a meaning in a language: which clauses there are, and how they are joined to sentences."""

import re
from collections.abc import Iterable, Mapping
from itertools import pairwise
from random import Random

from lang.clauses import Clause, clause_of, focus_of
from lang.grammar import SLOTS, Grammar
from lang.meaning import Assembly, Meaning, Navigation, Thing
from lang.patterns import Pattern, Slot, needed, possible
from lang.phrasing import Filler, Phraser, constant

ATTEMPTS = 30
"""How often a text is drawn anew that a reader would stumble over."""

DRAFTS = {"navigation": 5, "assembly": 2}
"""Of so many good drafts the shortest is taken: people are brief."""

FEWEST_WORDS = 6
"""The paper's automated checks ask for as many."""

MARKS = ",.;:।"
"""Marks that stand at a word's end."""

_SENTENCES = (1, 1, 2, 2, 2, 3)
"""How many clauses a sentence has: one of these."""

_TARGET_JOINED = 0.55
"""How often what to pick up is said in the last steps' sentence."""

_TURN_JOINED = 0.6
"""How often an assembly instruction says its turns in the sentence that says where to place the object."""

_OPENED = {"first": 0.04, "later": 0.25, "last": 0.2}
"""How often a sentence has words that open it, by its place in the text."""

_LABELS = "abc"


class Writer:
    """Writes one language's instructions."""

    def __init__(self, grammar: Grammar) -> None:
        self._grammar = grammar

    def write(self, meaning: Meaning, random: Random) -> str:
        """The meaning as one text, that depends on the two arguments alone.

        Raises:
            ValueError: for something that the language's data have no words for.
        """
        phase = "navigation" if isinstance(meaning, Navigation) else "assembly"
        drafts: list[str] = []
        for _ in range(ATTEMPTS):
            draft = _Draft(self._grammar, random)
            text = draft.navigation(meaning) if isinstance(meaning, Navigation) else draft.assembly(meaning)
            words = [word.casefold().strip(MARKS) for word in text.split()]
            if len(words) >= FEWEST_WORDS and not _stumbles(words):
                drafts.append(text)
            if len(drafts) == DRAFTS[phase]:
                break
        return min(drafts, key=lambda each: len(each.split())) if drafts else text


def _stumbles(words: list[str]) -> bool:
    """Whether a word stands twice in a row, or too few are different (the paper's checks: 40 per cent)."""
    return any(a == b for a, b in pairwise(words)) or len(set(words)) < 0.4 * len(words)


class _Draft(Phraser):
    """One text in the making, and its sentences."""

    def navigation(self, meaning: Navigation) -> str:
        clauses = [clause_of(step) for step in meaning.steps]
        groups = self._grouped(clauses)
        joined = bool(groups) and len(groups[-1]) < len(_LABELS) and self.random.random() < _TARGET_JOINED
        sentences = []
        for i, group in enumerate(groups):
            target = meaning.target if joined and i == len(groups) - 1 else None
            sentences.append(self._opened("first" if i == 0 else "later", self._joined(group, target)))
        if not joined:
            listed = self.grammar.target
            body = self._target(meaning.target, (*listed["clause"], *listed["sentences"]), {})
            sentences.append(self._opened("last", body) if groups else body)
        return self._finished(sentences)

    def assembly(self, meaning: Assembly) -> str:
        parts = [self._turn(direction) for direction in meaning.turns]
        if parts and self.random.random() < _TURN_JOINED:
            return self._finished([self._assembly_joined([*parts, self._place(meaning)])])
        apart = [self._assembly_joined(parts)] if parts else []
        return self._finished([*apart, self._place(meaning)])

    def _turn(self, direction: str) -> str:
        fillers = self.table_fillers({"direction": direction})
        patterns = self.fitting(self.grammar.assembly["turn"], {"direction"}, fillers)
        return self.render(self.pick(patterns, f"turn {direction}"), fillers, self.features)

    def _place(self, meaning: Assembly) -> str:
        thing, wheres = meaning.thing, meaning.where
        named = bool(thing.kind or thing.colour or thing.look)
        said: dict[str, Filler] = {}
        given: dict[str, str] = {}
        if named:
            noun = self.noun(thing)
            given = dict(noun.given)
            said["thing"] = self.thing(thing, noun, self.grammar.nested, top=False)
        if wheres:
            said["where"] = lambda _: self.wheres(wheres, top=True)
        patterns = self.fitting(self.grammar.assembly["place" if named else "place it"], said)
        return self.render(self.pick(patterns, "where to place"), said, {**self.features, **given})

    def _assembly_joined(self, parts: list[str]) -> str:
        if len(parts) > len(_LABELS):
            raise ValueError(f"{len(parts) - 1} turns; expected at most {len(_LABELS) - 1}")
        fillers = {label: constant(part) for label, part in zip(_LABELS, parts, strict=False)}
        join = self.pick(self.fitting(self.grammar.joins["assembly"], fillers), "join")
        return self.render(join, fillers, self.features)

    def _grouped(self, clauses: list[Clause]) -> list[list[Clause]]:
        """The clauses of each sentence."""
        groups = []
        while clauses:
            size = self.random.choice(_SENTENCES)
            groups.append(clauses[:size])
            clauses = clauses[size:]
        return groups

    def _joined(self, clauses: list[Clause], target: Thing | None) -> str:
        """The clauses as one sentence, what to pick up at its end if that is to stand in it."""
        labels = _LABELS[: len(clauses) + (target is not None)]
        bendable = {label for label, clause in zip(labels, clauses, strict=False) if self._patterns(clause, bent=True)}
        joins = self.fitting(self.grammar.joins["sentence"], labels)
        join = self.pick([join for join in joins if _bent(join) <= bendable], "join")
        marks = {part.name: self.grammar.features_of(part.marks) for part in join.body if isinstance(part, Slot)}
        fillers = {
            label: constant(self._clause(clause, marks[label])) for label, clause in zip(labels, clauses, strict=False)
        }
        if target is not None:
            fillers[labels[-1]] = constant(self._target(target, self.grammar.target["clause"], marks[labels[-1]]))
        return self.render(join, fillers, self.features)

    def _opened(self, place: str, body: str) -> str:
        """A sentence, for some with words that open it at its place in the text: "first", "later" or "last"."""
        if self.random.random() >= _OPENED[place]:
            return body
        opening = self.pick(self.grammar.joins[place], place)
        return self.render(opening, {"a": constant(body)}, self.features)

    def _patterns(self, clause: Clause, *, bent: bool) -> list[Pattern]:
        """Those that say a clause: of its key, of its thing's kind too, and short ones if that was just spoken of."""
        listed, said = self.grammar.steps, clause.said.keys()
        tables = self.table_fillers(clause.said)
        patterns = self.fitting(listed.get(clause.key, ()), said, tables)
        thing = clause.said.get("thing")
        if isinstance(thing, Thing):
            patterns += 2 * self.fitting(listed.get(f"{clause.key} {thing.kind}", ()), said, tables)
            if thing == self.focus:
                patterns += 4 * self.fitting(listed.get(f"{clause.key} same", ()), said - {"thing"}, tables)
        return [pattern for pattern in patterns if not (bent and pattern.main_only)]

    def _clause(self, clause: Clause, marked: Mapping[str, str]) -> str:
        pattern = self.pick(self._patterns(clause, bent=bool(marked)), clause.key)
        nouns = self.nouns(clause.said)
        given = dict(nouns["thing"].given) if "thing" in nouns else {}
        fillers = self.table_fillers(clause.said) | self.thing_fillers(clause.said, nouns)
        text = self.render(pattern, fillers, {**self.features, **given, **marked})
        things = [value for value in clause.said.values() if isinstance(value, Thing)]
        self.focus = focus_of(tuple(things) * (2 if "pair" in clause.said else 1), self.focus)
        self.spoken_of += things
        return text

    def _target(self, target: Thing, patterns: Iterable[Pattern], marked: Mapping[str, str]) -> str:
        said = {"target", "where"} if target.where else {"target"}
        fitting = [p for p in patterns if needed(p.body, SLOTS) <= said and not (marked and p.main_only)]
        pattern = self.pick(fitting, "what to pick up")
        noun = self.noun(target)
        fillers: dict[str, Filler] = {}
        wheres = target.where
        if wheres and "where" in possible(pattern.body, SLOTS):
            fillers["where"] = lambda _: self.wheres(wheres, top=True)
            target = Thing(target.kind, target.colour, target.look, target.which)
        fillers["target"] = self.thing(target, noun, self.grammar.attached, top=True)
        return self.render(pattern, fillers, {**self.features, **dict(noun.given), **marked})

    def _finished(self, sentences: list[str]) -> str:
        """The text: sentences ended, spaces in their places, spelt, capitals where the script has them."""
        end = self.grammar.sentence_end
        text = " ".join(sentence.strip().rstrip(f"{MARKS} ") + end for sentence in sentences)
        text = re.sub(rf"\s+([{MARKS}])", r"\1", " ".join(text.split()))
        for pattern, replacement in self.grammar.spelling:
            text = re.sub(pattern, replacement, text)
        return re.sub(r"(^|[.।] )(\S)", lambda match: match[1] + match[2].upper(), text)


def _bent(join: Pattern) -> frozenset[str]:
    """The labels of the clauses that a join wants in another form."""
    return frozenset(part.name for part in join.body if isinstance(part, Slot) and part.marks)
