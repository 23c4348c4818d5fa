"""Puts things, their places and clauses into words: chooses patterns and fills them, with the features they need."""

from collections.abc import Callable, Iterable, Mapping
from random import Random
from typing import TypeVar

from lang.clauses import Value, focus_of, things_said
from lang.grammar import SLOTS, Grammar, Lexeme
from lang.meaning import Thing, Where
from lang.patterns import Choice, Pattern, Sequence, needed, possible

Filler = Callable[[Mapping[str, str]], str]
"""Gives a slot's text for the features that its marks ask for."""

SAME = 0.6
"""How often a thing that was just spoken of is referred back to, where that is clear."""

_T = TypeVar("_T")


def constant(text: str) -> Filler:
    """A filler that is the same whatever the features."""
    return lambda _: text


class Phraser:
    """One text in the making: its random choices, its register, what it has spoken of."""

    def __init__(self, grammar: Grammar, random: Random) -> None:
        self.grammar = grammar
        self.random = random
        self.features = {axis: values[0] for axis, values in grammar.axes.items()}
        for axis in grammar.per_text:
            self.features[axis] = random.choice(grammar.axes[axis])
        self.focus: Thing | None = None
        self.spoken_of: list[Thing] = []
        self._used: set[tuple[str, object]] = set()
        self._nouns: dict[Thing, Lexeme] = {}

    # Choosing and filling

    def pick(self, options: Iterable[_T], about: str) -> _T:
        """One of the options, one that this text has not used yet if there is any.

        Raises:
            ValueError: if there are no options.
        """
        options = list(options)
        if not options:
            raise ValueError(f"no way to say {about}")
        chosen = self.random.choice([option for option in options if (about, option) not in self._used] or options)
        self._used.add((about, chosen))
        return chosen

    def fitting(
        self, patterns: Iterable[Pattern], said: Iterable[str], fillers: Mapping[str, Filler] | None = None
    ) -> list[Pattern]:
        """The patterns that say all that is to be said and nothing else.

        Args:
            patterns: to choose from.
            said: the names of slots, and of the attributes that tables have wordings of.
            fillers: where tables' slots may stand, all that can be filled.
        """
        said, fillers = frozenset(said), fillers or {}
        tables = self.grammar.tables
        known = SLOTS | tables.keys()
        fitting = []
        for pattern in patterns:
            must = needed(pattern.body, known)
            can = {slot for slot in possible(pattern.body, known) if slot not in tables or slot in fillers}
            attributes = {tables[slot].attribute if slot in tables else slot for slot in can}
            if must <= can and {tables[s].attribute if s in tables else s for s in must} <= said <= attributes:
                fitting.append(pattern)
        return fitting

    def render(self, pattern: Pattern, fillers: Mapping[str, Filler], features: Mapping[str, str]) -> str:
        """The pattern's text, optional parts drawn, inflected words in the form that the features ask for."""
        return self._sequence(pattern.body, fillers, features)

    def _sequence(self, body: Sequence, fillers: Mapping[str, Filler], features: Mapping[str, str]) -> str:
        text = ""
        for part in body:
            if isinstance(part, str):
                text += part
            elif isinstance(part, Choice):
                text += self._sequence(self._option(part, fillers.keys()), fillers, features)
            elif part.name in fillers:
                text += fillers[part.name](self.grammar.features_of(part.marks))
            else:
                marked = {**features, **self.grammar.features_of(part.marks)}
                words = [word for word in self.grammar.words[part.name] if word.form(marked) is not None]
                text += self.pick(words, f"{part.name!r} as {', '.join(marked.values())}").form(marked) or ""
        return text

    def _option(self, choice: Choice, said: Iterable[str]) -> Sequence:
        """One of the options whose slots can all be filled: of these one that says the most."""
        known, said = SLOTS | self.grammar.tables.keys(), frozenset(said)
        allowed = [option for option in choice.options if needed(option, known) <= said]
        most = max(len(possible(option, known) & said) for option in allowed)
        return self.random.choice([option for option in allowed if len(possible(option, known) & said) == most])

    def table_fillers(self, said: Mapping[str, Value]) -> dict[str, Filler]:
        """For each table that has a wording of what is said of its attribute: its slot's filler."""
        fillers: dict[str, Filler] = {}
        for slot, table in self.grammar.tables.items():
            value = said.get(table.attribute)
            if isinstance(value, str) and value in table.values:
                fillers[slot] = self._wording(self.pick(table.values[value], f"{slot} {value}"), self.features)
        return fillers

    def _wording(self, pattern: Pattern, own: Mapping[str, str]) -> Filler:
        return lambda features: self.render(pattern, {}, {**own, **features})

    # Things

    def noun(self, thing: Thing) -> Lexeme:
        """A noun for the thing: in one text always the same.

        Raises:
            ValueError: if the language has none for its kind.
        """
        nouns = self.grammar.nouns.get(thing.kind)
        if nouns is None:
            raise ValueError(f"no noun for things of kind {thing.kind!r}; there are {', '.join(self.grammar.nouns)}")
        if thing not in self._nouns:
            self._nouns[thing] = self.pick(nouns, f"noun {thing.kind}")
        return self._nouns[thing]

    def nouns(self, said: Mapping[str, Value]) -> dict[str, Lexeme]:
        """A noun for each slot that a thing fills and whose kind has one ("you" has none)."""
        things = {slot: value for slot, value in said.items() if isinstance(value, Thing)}
        return {slot: self.noun(thing) for slot, thing in things.items() if thing.kind != "you"}

    def thing_fillers(self, said: Mapping[str, Value], nouns: Mapping[str, Lexeme]) -> dict[str, Filler]:
        """For each slot that a thing fills: its filler."""
        fillers: dict[str, Filler] = {}
        for slot, noun in nouns.items():
            thing = said[slot]
            assert isinstance(thing, Thing)
            if slot == "pair":
                fillers[slot] = self._pair(thing, noun)
            elif self._may_be_short(thing) and self.random.random() < SAME:
                fillers[slot] = self._short(thing, noun)
            else:
                fillers[slot] = self.thing(thing, noun, self.grammar.nested, top=False)
        return fillers

    def thing(self, thing: Thing, noun: Lexeme, attached: Iterable[Pattern], *, top: bool) -> Filler:
        """A thing's filler: its noun phrase, with where it stands as one of the `attached` patterns adds it."""
        given, phrases = dict(noun.given), self.grammar.noun_phrases_of(thing.kind)

        def fill(features: Mapping[str, str]) -> str:
            own = {**self.features, **features, **given}
            if not thing.where:
                return self._described(thing, noun, own, phrases)
            said: dict[str, Filler] = {
                "thing": lambda marks: self._described(thing, noun, {**own, **marks}, phrases),
                "where": lambda _: self.wheres(thing.where, top=top),
            }
            return self.render(self.pick(self.fitting(attached, said), "attached"), said, own)

        return fill

    def _short(self, thing: Thing, noun: Lexeme) -> Filler:
        bare, given = Thing(thing.kind), dict(noun.given)
        phrases = self.grammar.same_phrases
        return lambda features: self._described(bare, noun, {**self.features, **features, **given}, phrases)

    def _pair(self, thing: Thing, noun: Lexeme) -> Filler:
        given = {**dict(noun.given), **self.grammar.features_of(self.grammar.pair_marks)}
        phrases = self.grammar.pair_phrases
        return lambda features: self._described(thing, noun, {**self.features, **features, **given}, phrases)

    def _may_be_short(self, thing: Thing) -> bool:
        """Whether "that bench" is enough: the last one of its kind that was spoken of is the very same."""
        last = next((each for each in reversed(self.spoken_of) if each.kind == thing.kind), None)
        return bool(thing.kind) and last == thing

    def _described(self, thing: Thing, noun: Lexeme, own: Mapping[str, str], patterns: Iterable[Pattern]) -> str:
        grammar = self.grammar
        form = noun.form(own)
        if form is None:
            raise ValueError(f"no form of {noun.forms[0][1]!r} that is {', '.join(own.values())}")
        said: dict[str, Filler] = {"noun": constant(form)}
        if thing.colour:
            said["colour"] = self._adjective(thing.colour, grammar.colours, own)
        if thing.which:
            said["which"] = self._adjective(thing.which, grammar.whiches, own)
        if thing.look:
            looks = grammar.looks.get(grammar.look_kind(thing.kind), {})
            if thing.look not in looks:
                raise ValueError(
                    f"no words for the look {thing.look!r} of {thing.kind!r}; there are {', '.join(looks)}"
                )
            look = self.pick(looks[thing.look], f"look {thing.look}")
            said["look_after" if look.after else "look"] = self._wording(look.wording, own)
        return self.render(self.pick(self.fitting(patterns, said), "noun phrase"), said, own)

    def _adjective(self, value: str, listed: Mapping[str, tuple[Pattern, ...]], own: Mapping[str, str]) -> Filler:
        if value not in listed:
            raise ValueError(f"no words for {value!r}; there are {', '.join(listed)}")
        return self._wording(self.pick(listed[value], value), own)

    # Relations

    def wheres(self, wheres: tuple[Where, ...], *, top: bool) -> str:
        """Relations as one text; `top` where they belong to what the sentence is about, not to a landmark of it."""
        text, focus = "", self.focus
        for number, where in enumerate(wheres):
            said = self._where(where, top=top)
            if number:
                key = "where" if top else "nested where"
                if top and any(thing.where for thing in wheres[number - 1].things):
                    key = "where after clause"
                fillers = {"a": constant(text), "b": constant(said)}
                said = self.render(self.pick(self.grammar.joins[key], key), fillers, self.features)
            text = said
            self.focus = focus_of(where.things, self.focus)
        self.focus = focus
        return text

    def _where(self, where: Where, *, top: bool) -> str:
        listed = self.grammar.where
        said: dict[str, Value] = dict(things_said(where.things))
        if where.exactly:
            said["exactly"] = "yes"
        kind = where.things[0].kind
        tables = self.table_fillers(said)
        patterns: list[Pattern] = []
        if kind == "you" and "thing" in said:
            patterns = self.fitting(listed.get(f"{where.relation} you", ()), said.keys() - {"thing"}, tables)
        elif not top and f"{where.relation} nested" in listed:
            patterns = self.fitting(listed[f"{where.relation} nested"], said, tables)
        elif said.get("thing") == self.focus is not None and self.random.random() < SAME:
            patterns = self.fitting(listed.get(f"{where.relation} same", ()), said.keys() - {"thing"}, tables)
        patterns = patterns or self.fitting(listed.get(where.relation, ()), said, tables)
        nouns = self.nouns(said)
        given = dict(nouns["thing"].given) if "thing" in nouns else {}
        pattern = self.pick(patterns, f"{where.relation} of {kind!r}")
        return self.render(pattern, tables | self.thing_fillers(said, nouns), {**self.features, **given})
