"""Writer of instructions: arranges the clauses of a meaning in sentences."""

import math
import re
from collections.abc import Callable, Iterable, Mapping
from copy import copy
from dataclasses import replace
from functools import partial
from itertools import pairwise
from random import Random

from arramon_lang.clauses import Clause, clause_of, focus_after
from arramon_lang.grammar import SLOTS, Grammar, Patterns
from arramon_lang.meaning import PLACES, Assembly, Meaning, Navigation, Thing
from arramon_lang.patterns import Pattern, Slot, possible_slots, required_slots
from arramon_lang.tokens import PAUSES, SENTENCE_ENDS, strip_marks
from arramon_lang.writing.phrasing import Filler, Phraser, constant
from arramon_lang.writing.preferences import Preferences
from arramon_lang.writing.voice import Voice, draw_voice

ATTEMPTS = 48
"""Maximum number of drafts; writing stops earlier once enough drafts pass the checks."""

REDRAWS = 5
"""Maximum number of times that a sentence is written anew because it fails a check, in such a language."""

FURTHER_ATTEMPTS = 192
"""Maximum number of further drafts until one passes, in a language without preferences, whose checks are stricter."""

DRAFT_COUNTS = {"navigation": (2, 2, 3, 4), "assembly": (1, 1, 1, 2)}
"""Distribution of the number of acceptable drafts, of which the shortest is returned: most people are brief."""

PREFERRED_DRAFTS = {"navigation": 10, "assembly": 10}
"""Number of acceptable drafts in a language with preferences, by which one of them is drawn."""

PAIRED_PROBABILITY = 0.85
"""Probability that two neighbouring clauses for which the language has common words are written as one."""

ON_TO_PROBABILITY = 0.3
"""Probability of "past the cone to the bench", where the language can say so."""

PURPOSE_PROBABILITY = 0.05
"""Probability of "go past the bench to pick up the mug", in a language that has it, where they share a sentence."""

WALKS_APART_PROBABILITY = 0.95
"""Probability that a sentence ends between two walks."""

MIN_WORDS = 6
"""Minimum number of words in the paper's automated checks."""

PUNCTUATION = f"{PAUSES}{SENTENCE_ENDS}"
"""Punctuation before which no space is written."""

STREETS = ("street", "alley")
"""Kinds that use only their own patterns, not the general ones: one turns into a street, not at it."""

PAST_INTERSECTION = "walk past intersection"
"""Clause that uses only its own patterns, not the general ones: one crosses an intersection, not walks past it."""

_TARGET_JOINED_PROBABILITY = 0.55
"""Probability that the target is stated in the last step's sentence."""

_TURN_JOINED_PROBABILITY = 0.6
"""Probability that an assembly instruction states its turns in the sentence about the placement."""

_OPENING_PROBABILITIES = {"first": 0.01, "later": 0.07, "last": 0.08}
"""Probability of opening words ("Then"), by the sentence's place in the text."""

NOT_REACHED = ("face", "turn face", "face towards", "walk towards", "walk past towards", "walk until")
"""Clauses that do not end at their thing, so that "there" cannot refer to it."""

ONLY_FACED = ("face", "turn face")
"""Clauses that end where they begin, with their thing in front."""

CHANGED = ("focus", "mentioned_things", "is_at_thing", "last_key", "_used", "_looks")
"""Attributes of a draft that writing a sentence changes."""

REDRAWN_OPENINGS = 5.0
"""Factor on the probability of opening words in a sentence that has failed checks twice."""

_LABELS = "abc"


class _Misleading(Exception):
    """A clause says "straight" although its thing is not straight ahead."""


class _Hopeless(Exception):
    """A draft fails as many checks, before its end, as an earlier whole draft."""


class Writer:
    """Writes one language's instructions."""

    def __init__(self, grammar: Grammar, preferences: Preferences | None = None) -> None:
        self._grammar = grammar
        self._preferences = preferences

    def write(self, meaning: Meaning, random: Random, voice: Voice | None = None) -> str:
        """Return a text for a meaning, a deterministic function of the arguments; draw a voice if none is given.

        Raises:
            ValueError: if the language's data lack words for some part of it.
        """
        phase = "navigation" if isinstance(meaning, Navigation) else "assembly"
        voice = voice or draw_voice(self._grammar, random)
        if self._preferences is not None:
            wanted = PREFERRED_DRAFTS[phase]
        else:
            brief = random.choice(DRAFT_COUNTS[phase])  # Drawn for every voice, so that all write the same drafts.
            wanted = brief if voice.manner.brevity >= 0.0 else 1
        return self._chosen(self.drafts(meaning, random, voice, wanted), phase, random, voice)

    def draft(self, meaning: Meaning, random: Random, voice: Voice) -> str:
        """Return the first draft that passes the checks, or the one with the fewest faults.

        Raises:
            ValueError: as `write` does.
        """
        return self.drafts(meaning, random, voice, 1)[0]

    def drafts(self, meaning: Meaning, random: Random, voice: Voice, wanted: int) -> list[str]:
        """Return up to `wanted` texts that pass the checks; if none passes, the one with the fewest faults.

        Raises:
            ValueError: as `write` does.
        """
        drafts: list[str] = []
        text, fewest = "", math.inf
        further = FURTHER_ATTEMPTS if self._preferences is None else 0
        for attempt in range(ATTEMPTS + further):
            if attempt >= ATTEMPTS and drafts:
                break
            draft = _Draft(self._grammar, random, voice)
            draft.redraws = REDRAWS if self._preferences is None else 0
            draft.most_clumsy = max(fewest, 1)
            try:
                written = draft.navigation(meaning) if isinstance(meaning, Navigation) else draft.assembly(meaning)
            except (_Misleading, _Hopeless):
                continue
            known = draft.clumsy_before if draft.redraws and isinstance(meaning, Navigation) else None
            faults = self._count_faults(written, max(fewest, 1), known)
            if faults == 0:
                drafts.append(draft.typed(written))
            if faults < fewest:
                text, fewest = draft.typed(written), faults
            if len(drafts) == wanted:
                break
        if not text:
            raise ValueError("every wording says 'straight' although the thing is not straight ahead")
        return drafts or [text]

    def _count_faults(self, written: str, most: float, known: int | None) -> float:
        """Return the number of checks that a draft fails, or `most` if it fails as many.

        `known` is the number of the language's own checks that it fails, if that has been counted.
        """
        words = [strip_marks(word.casefold()) for word in written.split()]
        faults = _is_clumsy(words) + (len(words) < MIN_WORDS)
        if known is not None:
            return min(faults + known, most)
        return _count_clumsy(written, self._grammar.clumsy, most, faults)

    def _chosen(self, drafts: list[str], phase: str, random: Random, voice: Voice) -> str:
        """Return one of the drafts: by the language's preferences and the voice's brevity, or the shortest."""
        sizes = [len(draft.split()) for draft in drafts]
        if self._preferences is None:
            return drafts[sizes.index(min(sizes))]
        scores = [
            self._preferences.score(draft, phase) - voice.manner.brevity * size
            for draft, size in zip(drafts, sizes, strict=True)
        ]
        best = max(scores)
        return random.choices(drafts, [math.exp(score - best) for score in scores])[0]


def _count_clumsy(text: str, patterns: Iterable[re.Pattern[str]], most: float, faults: int = 0) -> int:
    """Return the given number of faults and that of the patterns found in a text, or `most` if there are as many."""
    for pattern in patterns:
        if faults >= most:
            break
        faults += pattern.search(text) is not None
    return faults


def _is_clumsy(words: list[str]) -> bool:
    """Return whether a word occurs twice in a row, or under 40% of the words are distinct (the paper's checks)."""
    return any(a == b for a, b in pairwise(words)) or len(set(words)) < 0.4 * len(words)


class _Draft(Phraser):
    """The sentences of one text being written.

    Attributes:
        is_at_thing: whether the last clause ends at its thing, so that "there" may refer to it.
        last_key: key of the last clause.
        redraws: maximum number of times that a sentence is written anew because it fails a check.
        opening_factor: factor on the probability of opening words.
        clumsy_before: number of the language's checks that the sentences written so far fail, if sentences are redrawn.
        most_clumsy: number of failed checks from which on the draft is given up, if sentences are redrawn.
    """

    is_at_thing = False
    clumsy_before = 0
    most_clumsy: float = math.inf
    last_key = ""
    redraws = 0
    opening_factor = 1.0

    def navigation(self, meaning: Navigation) -> str:
        clauses = self._paired(clause_of(step) for step in meaning.steps)
        groups = self._group_clauses(clauses)
        joined = bool(groups) and len(groups[-1]) < len(_LABELS) and self.random.random() < _TARGET_JOINED_PROBABILITY
        sentences: list[str] = []
        for i, group in enumerate(groups):
            target = meaning.target if joined and i == len(groups) - 1 else None
            sentences.append(self._drawn(sentences, partial(self._steps, group, target, i, len(groups))))
        if not joined:
            sentences.append(self._drawn(sentences, partial(self._last, meaning.target, len(groups))))
        return self._finish_text(sentences)

    def _steps(self, group: list[Clause], target: Thing | None, number: int, count: int) -> str:
        """Return the sentence of a group of clauses, of which there are `count`."""
        body = self._join_clauses(group, target)
        return self._add_opening("later" if number else "first", body) if count > 1 else body

    def _last(self, target: Thing, count: int) -> str:
        """Return the sentence about the target, after `count` others."""
        listed = self.grammar.target
        body, plain = self._target(target, (*listed["clause"], *listed["sentences"]), {})
        return self._add_opening("last", body) if count > 1 and plain else body

    def _drawn(self, before: list[str], write: Callable[[], str]) -> str:
        """Return the sentence that `write` draws, drawn anew while it adds faults to the text before it."""
        clumsy = self.grammar.clumsy
        allowed = self.clumsy_before if self.redraws and before else 0
        state = {name: copy(getattr(self, name)) for name in CHANGED}
        for number in range(self.redraws):
            self.opening_factor = 1.0 if number < 2 else REDRAWN_OPENINGS
            try:
                sentence = write()
                counted = _count_clumsy(self._finish_text([*before, sentence]), clumsy, allowed + 1)
                if counted <= allowed:
                    self.clumsy_before = counted
                    return sentence
            except _Misleading:
                pass
            for name, value in state.items():
                setattr(self, name, copy(value))
        sentence = write()
        if self.redraws:
            self.clumsy_before = _count_clumsy(self._finish_text([*before, sentence]), clumsy, math.inf)
            if self.clumsy_before >= self.most_clumsy:
                raise _Hopeless(sentence)
        return sentence

    def assembly(self, meaning: Assembly) -> str:
        parts = [self._turn(direction) for direction in meaning.turns]
        if parts and self.random.random() < _TURN_JOINED_PROBABILITY:
            return self._finish_text([self._join_assembly([*parts, self._place(meaning, joined=True)])])
        apart = [self._join_assembly(parts)] if parts else []
        return self._finish_text([*apart, self._place(meaning, joined=False)])

    def _turn(self, direction: str) -> str:
        fillers = self.table_fillers({"direction": direction})
        patterns = self.fitting(self.grammar.assembly["turn"], {"direction"}, fillers)
        return self.render(self.pick(patterns, f"turn {direction}"), fillers, self.features)

    def _place(self, meaning: Assembly, *, joined: bool) -> str:
        """Return the placement clause; `joined` if it shares a sentence with turns."""
        thing, wheres = meaning.thing, meaning.where
        self.is_all_known = True
        named = bool(thing.kind or thing.colour or thing.look)
        content: dict[str, Filler] = {}
        given: dict[str, str] = {}
        if named:
            noun = self.noun(thing)
            given = dict(noun.given)
            content["thing"] = self.thing(thing, noun, self.grammar.nested, top=False)
        if wheres:
            content["where"] = lambda _: self.wheres(wheres, top=True)
        patterns = self.fitting(self.grammar.assembly["place" if named else "place it"], content)
        return self.render(
            self.pick(_usable(patterns, subordinate=joined), "where to place"), content, {**self.features, **given}
        )

    def _join_assembly(self, parts: list[str]) -> str:
        if len(parts) > len(_LABELS):
            raise ValueError(f"{len(parts) - 1} turns; expected at most {len(_LABELS) - 1}")
        fillers = {label: constant(part) for label, part in zip(_LABELS, parts, strict=False)}
        join = self.pick(self.fitting(self.grammar.joins["assembly"], fillers), "join")
        return self.render(join, fillers, self.features)

    def _pairs(self, one: Clause, other: Clause) -> Clause | None:
        """Return one clause for two, if there are words for both and chance does not keep them apart.

        These are a turn to face something, facing something and walking there, a walk past two things, and a walk past
        one thing to or towards another.
        """
        things = one.slots.get("thing"), other.slots.get("thing")
        share, pair = PAIRED_PROBABILITY, None
        if (one.key, other.key) == ("turn", "face") and isinstance(things[1], Thing):
            pair = Clause("turn face", {**one.slots, **other.slots})
        elif one.key == "face" and other.key in ("walk to", "walk towards") and other.slots.keys() == {"thing"}:
            if isinstance(things[0], Thing) and things[0].is_same(things[1] if isinstance(things[1], Thing) else None):
                pair, share = Clause(f"face {other.key.removeprefix('walk ')}", one.slots), 1.0
        elif one.key == "walk past" and one.slots.keys() == other.slots.keys() == {"thing"} and things[0] != things[1]:
            plain = [thing for thing in things if isinstance(thing, Thing) and thing.kind not in PLACES]
            both = {"thing": one.slots["thing"], "other": other.slots["thing"]}
            if other.key == "walk past" and len({thing.kind for thing in plain}) == 2:
                pair = Clause(one.key, both, one.straight and other.straight)
            elif other.key in ("walk to", "walk towards") and other.straight:
                pair, share = (
                    Clause(f"walk past {other.key.removeprefix('walk ')}", both, one.straight),
                    ON_TO_PROBABILITY,
                )
        if pair is None or not self._patterns(pair, subordinate=False) or self.random.random() >= share:
            return None
        return pair

    def _paired(self, clauses: Iterable[Clause]) -> list[Clause]:
        """Return the clauses, some neighbours written as one."""
        found: list[Clause] = []
        for clause in clauses:
            pair = self._pairs(found[-1], clause) if found else None
            before = found[-2].slots.get("thing") if len(found) > 1 else None
            is_back = pair is not None and isinstance(before, Thing) and before.is_same(_thing(pair, "other"))
            # What one was just told to face is "it".
            is_back |= (
                pair is not None
                and self.redraws > 0
                and isinstance(before, Thing)
                and before.is_same(_thing(pair, "thing"))
            )
            if pair is not None and not is_back:
                found[-1] = pair
            else:
                found.append(clause)
        return found

    def _group_clauses(self, clauses: list[Clause]) -> list[list[Clause]]:
        """Divide the clauses among sentences."""
        groups = []
        while clauses:
            size = self.random.choice(self.voice.manner.sentence_sizes)
            # People seldom join two walks by "and".
            for place, (one, other) in enumerate(pairwise(clauses[:size]), start=1):
                if _is_walk(one) and _is_walk(other) and self.random.random() < WALKS_APART_PROBABILITY:
                    size = place
                    break
            groups.append(clauses[:size])
            clauses = clauses[size:]
        return groups

    def _join_clauses(self, clauses: list[Clause], target: Thing | None) -> str:
        """Return the clauses as one sentence, ending with the target if it is given."""
        labels = _LABELS[: len(clauses) + (target is not None)]
        can_be_subordinate = {
            label for label, clause in zip(labels, clauses, strict=False) if self._patterns(clause, subordinate=True)
        }
        key = "purpose" if target is not None and self._is_for(clauses[-1], target) else "sentence"
        joins = self.fitting(self.grammar.joins[key], labels)
        join = self.pick([join for join in joins if _subordinate_labels(join) <= can_be_subordinate], "join")
        marks = {part.name: self.grammar.features_of(part.marks) for part in join.body if isinstance(part, Slot)}
        fillers = {
            label: constant(self._clause(clause, marks[label], front=label == labels[0]))
            for label, clause in zip(labels, clauses, strict=False)
        }
        if target is not None:
            patterns = self.grammar.target["purpose" if key == "purpose" else "clause"]
            fillers[labels[-1]] = constant(self._target(target, patterns, marks[labels[-1]])[0])
        return self.render(join, fillers, self.features)

    def _is_for(self, clause: Clause, target: Thing) -> bool:
        """Return whether a clause is followed by picking up the target as its purpose, by chance."""
        if "purpose" not in self.grammar.joins or not _is_walk(clause) or clause.key in NOT_REACHED:
            return False
        is_named = any(isinstance(value, Thing) and value.is_same(target) for value in clause.slots.values())
        return not is_named and self.random.random() < PURPOSE_PROBABILITY

    def _add_opening(self, place: str, body: str) -> str:
        """Return a sentence, possibly with opening words for its place in the text ("first", "later" or "last")."""
        if self.random.random() >= _OPENING_PROBABILITIES[place] * self.voice.manner.openings * self.opening_factor:
            return body
        opening = self.pick(self.grammar.joins[place], place)
        return self.render(opening, {"a": constant(body)}, self.features)

    def _patterns(self, clause: Clause, *, subordinate: bool) -> Patterns:
        """Return the patterns of a clause whose words agree with its first thing."""
        patterns = self._all_patterns(clause, subordinate=subordinate)
        noun = next(iter(self.nouns(clause.slots).values()), None)
        return patterns if noun is None else tuple(p for p in patterns if self.grammar.has_words_for(noun, p))

    def _all_patterns(self, clause: Clause, *, subordinate: bool) -> Patterns:
        """Return the patterns of a clause: with a pronoun for the thing in focus, or else all others."""
        listed, content = self.grammar.steps, clause.slots.keys()
        tables = self.filled_tables(clause.slots)
        if content & {"pair", "several"} and clause.key != "walk between":
            return _usable(
                self.fitting(listed.get(f"{clause.key} group", ()), content, tables), subordinate=subordinate
            )
        thing = clause.slots.get("thing")
        if isinstance(thing, Thing) and thing.is_same(self.focus):
            is_faced = not self.is_at_thing if clause.key == "turn at" else self.last_key in ONLY_FACED
            key = f"{clause.key} faced"
            key = key if is_faced and key in listed else f"{clause.key} same"
            short = _usable(self.fitting(listed.get(key, ()), content - {"thing"}, tables), subordinate=subordinate)
            if short:  # People never name a thing again in the next clause.
                return short
        patterns = self.fitting(listed.get(clause.key, ()), content, tables)
        if clause.far:
            patterns += self.fitting(listed.get(f"{clause.key} far", ()), content, tables)
        special: Patterns = ()
        if isinstance(thing, Thing) and "other" not in clause.slots:
            own_key = f"{clause.key} {thing.kind}"
            special = self.without_new(self.fitting(listed.get(own_key, ()), content, tables), clause.slots)
            if special and (thing.kind in STREETS or own_key == PAST_INTERSECTION):
                return _usable(special, subordinate=subordinate)
        return _usable(self.without_new(patterns, clause.slots) + 2 * special, subordinate=subordinate)

    def _clause(self, clause: Clause, marked: Mapping[str, str], *, front: bool) -> str:
        """Return a clause's text; unmarked and at the front of a sentence, it may use any pattern."""
        subordinate = bool(marked) or not front
        fitting = self._patterns(clause, subordinate=subordinate) or self._patterns(clause, subordinate=bool(marked))
        if not fitting:
            said = (f"{slot} {value!r}" for slot, value in clause.slots.items() if isinstance(value, str))
            raise ValueError(f"no wording for {' with '.join((clause.key, *said))}")
        pattern = self.pick(fitting, clause.key)
        nouns = self.nouns(clause.slots)
        given = dict(nouns["thing"].given) if "thing" in nouns else {}
        fillers = self.table_fillers(clause.slots) | self.thing_fillers(clause.slots, nouns)
        text = self.render(pattern, fillers, {**self.features, **given, **marked})
        if not clause.straight and self.grammar.straight and re.search(self.grammar.straight, text):
            raise _Misleading(text)
        self.is_at_thing, self.last_key = clause.key not in NOT_REACHED, clause.key
        things = [value for value in clause.slots.values() if isinstance(value, Thing)]
        if clause.key.startswith("walk past t"):  # To or towards the other thing.
            self.focus = things[-1]
        else:
            is_twice = clause.key == "walk between" and "pair" in clause.slots
            self.focus = focus_after(tuple(things) * (2 if is_twice else 1), self.focus)
        self.mentioned_things += things
        return text

    def _target(self, target: Thing, patterns: Patterns, marked: Mapping[str, str]) -> tuple[str, bool]:
        """Return the target's clause, and whether opening words may precede it."""
        if target.is_same(self.focus):
            same = _usable(self.grammar.target["same"], subordinate=bool(marked))
            return self.render(self.pick(same, "to pick it up"), {}, {**self.features, **marked}), True
        content = {"target", "where"} if target.where else {"target"}
        if not target.where:
            patterns = self.grammar.target.get("alone", patterns)
        fitting = [
            p
            for p in _usable(patterns, subordinate=bool(marked))
            if p.weight and required_slots(p.body, SLOTS) <= content
        ]
        pattern = self.pick(fitting, "what to pick up")
        noun = self.noun(target)
        fillers: dict[str, Filler] = {}
        wheres = target.where
        if wheres and "where" in possible_slots(pattern.body, SLOTS):
            fillers["where"] = lambda _: self.wheres(wheres, top=True)
            target = replace(target, where=())
        fillers["target"] = self.thing(target, noun, self.grammar.attached, top=True)
        text = self.render(pattern, fillers, {**self.features, **dict(noun.given), **marked})
        return text, not pattern.main_only

    def _finish_text(self, sentences: list[str]) -> str:
        """Return the final text: sentences ended, spacing and spelling fixed, capitals where the script has them."""
        end = self.grammar.sentence_end
        bare = [sentence.strip().rstrip(f"{PUNCTUATION} ") for sentence in sentences]
        text = f"{end} ".join(bare) + self.voice.end
        text = re.sub(rf"\s+([{PUNCTUATION}])", r"\1", " ".join(text.split()))
        for pattern, replacement in self.grammar.spelling:
            text = pattern.sub(replacement, text)
        return self._capitalised(text)

    def typed(self, text: str) -> str:
        """Return a final text as the voice types it: without articles, as in a note, if it leaves these out."""
        if self.voice.has_articles:
            return text
        words = (word for word in text.split() if word.casefold() not in self.grammar.articles)
        return self._capitalised(" ".join(words))

    def _capitalised(self, text: str) -> str:
        if not self.voice.has_capitals:
            return text
        return re.sub(rf"(^|[{SENTENCE_ENDS}] )(\S)", lambda match: match[1] + match[2].upper(), text)


def _usable(patterns: Patterns, *, subordinate: bool) -> Patterns:
    """Return the patterns without those that are main clauses only, if a subordinate clause is needed."""
    return tuple(pattern for pattern in patterns if not pattern.main_only) if subordinate else patterns


def _is_walk(clause: Clause) -> bool:
    return clause.key.startswith("walk ")


def _thing(clause: Clause, slot: str) -> Thing | None:
    value = clause.slots.get(slot)
    return value if isinstance(value, Thing) else None


def _subordinate_labels(join: Pattern) -> frozenset[str]:
    """Return the labels of the clauses that a join needs in a subordinate form."""
    return frozenset(part.name for part in join.body if isinstance(part, Slot) and part.marks)
