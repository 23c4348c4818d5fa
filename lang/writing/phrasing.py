"""Wording of things, relations and clauses: random choice of patterns, whose slots are filled with inflected words."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from random import Random
from typing import Protocol, TypeVar

from arramon_lang.clauses import Value, focus_after, thing_slots
from arramon_lang.grammar import INSIDE, Grammar, Lexeme, LookWording, Patterns
from arramon_lang.meaning import Thing, Where
from arramon_lang.patterns import Alternatives, Pattern, Sequence
from arramon_lang.writing.voice import Voice, draw_voice

Filler = Callable[[Mapping[str, str]], str]
"""Function from the features that a slot's marks require to the slot's text."""

ANAPHORA_PROBABILITY = 0.12
"""Probability of an anaphoric reference ("that bench") to a thing that was just mentioned, if it is unambiguous."""

FOCUSED_PROBABILITY = 0.8
"""The same for the thing that was mentioned last, where the language has no wording with a pronoun."""

NOUN = "\0"
"""Marks the start of the noun while a noun phrase is composed."""

FAVOURITE_PROBABILITY = 0.75
"""Probability that a voice writes its favourite form of a word."""

FAVOURITE_AGAIN = 0.45
"""The same once the text has it."""

NEVER_NEW = ("street_end", "building_corner", "street", "alley", "you")
"""Kinds never introduced like a thing not mentioned before ("until you see a bench")."""

REPEATED_FACTOR = 0.4
"""Factor on the weight of a wording that the text has already used."""


class WeightedWording(Protocol):
    """A wording with its weight."""

    @property
    def weight(self) -> float:
        """Relative probability of being written; 0 if it is only read."""


_T = TypeVar("_T", bound=WeightedWording)


class _Pair(Where):
    """One relation to two things, each by itself."""

    def __post_init__(self) -> None:
        """Accept two things."""


def _is_of_room(where: Where, before: Where) -> bool:
    """Return whether a relation is to a wall or the reader, and so is the one before, or its landmark is there too."""
    fixed, kind = {"wall", "you"}, where.things[0].kind
    return kind in fixed and (before.relation == "on_top_of" or before.things[0].kind in fixed - {kind})


def constant(text: str) -> Filler:
    """Return a filler that ignores features."""
    return lambda _: text


class Phraser:
    """State of one text being written: random choices, register, and the things mentioned so far.

    Attributes:
        is_all_known: whether nothing is introduced as new ("near a ball"): in the room, all is in view.
    """

    is_all_known = False

    def __init__(self, grammar: Grammar, random: Random, voice: Voice | None = None) -> None:
        self.grammar = grammar
        self.random = random
        self.voice = voice = voice or draw_voice(grammar, random)
        self.features = {axis: values[0] for axis, values in grammar.axes.items()} | dict(voice.features)
        self.focus: Thing | None = None
        self.mentioned_things: list[Thing] = []
        self._used: set[tuple[str, object]] = set()
        self._looks: dict[tuple[str, str], LookWording] = {}

    # Choosing and filling

    def pick(self, options: Iterable[_T], about: str) -> _T:
        """Draw an option by weight, with lower weights for options that this text has already used.

        Raises:
            ValueError: if there are no options with a weight above 0.
        """
        options = [option for option in options if option.weight > 0]
        if not options:
            raise ValueError(f"no wording for {about}")
        weights = [option.weight * (REPEATED_FACTOR if (about, option) in self._used else 1.0) for option in options]
        (chosen,) = self.random.choices(options, weights)
        self._used.add((about, chosen))
        return chosen

    def fitting(self, patterns: Patterns, content: Iterable[str], filled: Iterable[str] = frozenset()) -> Patterns:
        """Return the writable patterns that express exactly the given content.

        Args:
            patterns: candidates, one of the grammar's tuples.
            content: names of slots, and of attributes with wordings in tables.
            filled: available fillers; required if the patterns contain tables' slots.
        """
        return self.grammar.fitting(patterns, frozenset(content), frozenset(self.grammar.tables.keys() & filled))

    def render(self, pattern: Pattern, fillers: Mapping[str, Filler], features: Mapping[str, str]) -> str:
        """Return the text of a pattern, with alternatives drawn at random and words inflected as required."""
        return self._sequence(pattern.body, fillers, features)

    def _sequence(self, body: Sequence, fillers: Mapping[str, Filler], features: Mapping[str, str]) -> str:
        text = ""
        for part in body:
            if isinstance(part, str):
                text += part
            elif isinstance(part, Alternatives):
                text += self._sequence(self._option(part, fillers.keys()), fillers, features)
            elif part.name in fillers:
                text += fillers[part.name](self.grammar.features_of(part.marks))
            else:
                marked = {**features, **self.grammar.features_of(part.marks)}
                text += self._word(part.name, marked).form(marked) or ""
        return text

    def _word(self, name: str, features: Mapping[str, str]) -> Lexeme:
        """Draw one of the words of a name that have a form with these features, often the voice's favourite."""
        words = [word for word in self.grammar.words[name] if word.form(features) is not None]
        favourite = self.voice.favourites.get(name)
        about = f"{name!r} as {', '.join(features.values())}"
        share = FAVOURITE_AGAIN if (about, favourite) in self._used else FAVOURITE_PROBABILITY
        if favourite in words and favourite is not None and self.random.random() < share:
            self._used.add((about, favourite))
            return favourite
        return self.pick(words, about)

    def _option(self, choice: Alternatives, content: Iterable[str]) -> Sequence:
        """Draw one of the options that fill the most slots, among those whose slots can all be filled."""
        options, bounds = self.grammar.fullest_options(choice, frozenset(content))
        (chosen,) = self.random.choices(options, cum_weights=bounds)
        return chosen

    def table_fillers(self, content: Mapping[str, Value]) -> dict[str, Filler]:
        """Return a filler for each table's slot, if the table has a wording for the given value."""
        tables = self.grammar.tables
        return {
            slot: self._wording(self.pick(tables[slot].wordings_in(content), slot), self.features)
            for slot in self.filled_tables(content)
        }

    def filled_tables(self, content: Mapping[str, Value]) -> list[str]:
        """Return the slots of the tables that have a wording for the given values."""
        if not any(isinstance(value, str) for value in content.values()):
            return []
        return [slot for slot, table in self.grammar.tables.items() if table.wordings_in(content)]

    def _wording(self, pattern: Pattern, own: Mapping[str, str]) -> Filler:
        return lambda features: self.render(pattern, {}, {**own, **features})

    # Things

    def noun(self, thing: Thing) -> Lexeme:
        """Return the voice's noun for the thing.

        Raises:
            ValueError: if the language has no noun for its kind.
        """
        noun = self.voice.junctions.get((thing.kind, thing.arms)) or self.voice.nouns.get(thing.kind)
        if noun is None:
            raise ValueError(f"no noun for kind {thing.kind!r}; there are nouns for {', '.join(self.grammar.nouns)}")
        return noun

    def nouns(self, content: Mapping[str, Value]) -> dict[str, Lexeme]:
        """Return a noun for each slot filled by a thing whose kind has one ("you" has none)."""
        things = {slot: value for slot, value in content.items() if isinstance(value, Thing)}
        return {slot: self.noun(thing) for slot, thing in things.items() if thing.kind != "you"}

    def thing_fillers(self, content: Mapping[str, Value], nouns: Mapping[str, Lexeme]) -> dict[str, Filler]:
        """Return a filler for each slot filled by a thing."""
        fillers: dict[str, Filler] = {}
        for slot, noun in nouns.items():
            thing = content[slot]
            assert isinstance(thing, Thing)
            if slot in ("pair", "several"):
                fillers[slot] = self._plural(thing, noun, slot)
            elif self._must_be_short(thing) or (
                self._may_be_short(thing)
                and self.random.random() < (FOCUSED_PROBABILITY if thing.is_same(self.focus) else ANAPHORA_PROBABILITY)
            ):
                fillers[slot] = self._short(thing, noun)
            else:
                fillers[slot] = self.thing(thing, noun, self.grammar.nested, top=False)
        return fillers

    def thing(self, thing: Thing, noun: Lexeme, attached: Patterns, *, top: bool) -> Filler:
        """Return a filler for a thing: its noun phrase, to which one of the `attached` patterns adds its relations."""
        given, phrases = dict(noun.given), self.grammar.noun_phrases_of(thing.kind)
        if thing.which == "another":
            thing, phrases = replace(thing, which=""), self.grammar.another_phrases_of(thing.kind)

        def fill(features: Mapping[str, str]) -> str:
            own = {**self.features, **features, **given}
            if not thing.where:
                return self._described(thing, noun, own, phrases)
            content: dict[str, Filler] = {
                "thing": lambda marks: self._described(thing, noun, {**own, **marks}, phrases),
                "where": lambda _: self.wheres(thing.where, top=top),
            }
            return self.render(self.pick(self.fitting(attached, content), "attached"), content, own)

        return fill

    def _short(self, thing: Thing, noun: Lexeme) -> Filler:
        bare, given = Thing(thing.kind), dict(noun.given)
        phrases = self.grammar.same_phrases_of(thing.kind)
        return lambda features: self._described(bare, noun, {**self.features, **features, **given}, phrases)

    def _plural(self, thing: Thing, noun: Lexeme, slot: str) -> Filler:
        """Return a filler for two or several things with one description."""
        given = {**dict(noun.given), **self.grammar.features_of(self.grammar.pair_marks)}
        grammar = self.grammar
        phrases = (grammar.pair_phrases_of if slot == "pair" else grammar.several_phrases_of)(thing.kind)
        return lambda features: self._described(thing, noun, {**self.features, **features, **given}, phrases)

    def without_new(self, patterns: Patterns, content: Mapping[str, Value]) -> Patterns:
        """Return the patterns that introduce nothing as new ("a bench") that has been mentioned or has an ordinal."""
        known = {
            slot
            for slot, value in content.items()
            if isinstance(value, Thing)
            and (
                (self.is_all_known and slot == "thing")
                or value.which
                or value.where
                or value.kind in NEVER_NEW
                or any(map(value.is_same, self.mentioned_things))
            )
        }
        introduced = self.grammar.introduced_slots
        return tuple(p for p in patterns if known.isdisjoint(introduced(p))) if known else patterns

    def _is_mentioned(self, thing: Thing) -> bool:
        return any(map(thing.is_same, self.mentioned_things))

    def _may_be_short(self, thing: Thing) -> bool:
        """Return whether "that bench" is unambiguous: the only mentioned thing of its kind."""
        mentioned = [each for each in self.mentioned_things if each.kind == thing.kind]
        return bool(thing.kind and mentioned) and all(map(thing.is_same, mentioned))

    def _must_be_short(self, thing: Thing) -> bool:
        """Return whether only "that bench" is correct: "another bench" and "the next bench" can name a thing only once.

        Raises:
            ValueError: if "that bench" would refer to another thing.
        """
        if thing.which not in ("next", "another") or not any(map(thing.is_same, self.mentioned_things)):
            return False
        last = next(each for each in reversed(self.mentioned_things) if each.kind == thing.kind)
        if not thing.is_same(last):
            raise ValueError(
                f"no name for a {thing.kind} first called {thing.which!r}: another one was mentioned since"
            )
        return True

    def _described(self, thing: Thing, noun: Lexeme, own: Mapping[str, str], patterns: Patterns) -> str:
        grammar = self.grammar
        form = noun.form(own)
        if form is None:
            raise ValueError(f"no form of {noun.forms[0][1]!r} that is {', '.join(own.values())}")
        content: dict[str, Filler] = {"noun": constant(f"{NOUN}{form}" if INSIDE in form else form)}
        if thing.colour:
            content["colour"] = self._adjective(thing.colour, self._colours(thing.kind), own)
        if thing.which:
            content["which"] = self._adjective(thing.which, self.voice.whiches, own)
        if thing.look:
            looks = grammar.looks.get(grammar.look_kind(thing.kind), {})
            if thing.look not in looks:
                raise ValueError(
                    f"no words for the look {thing.look!r} of {thing.kind!r}; expected one of {', '.join(looks)}"
                )
            look = self._look(grammar.look_kind(thing.kind), thing.look)
            content["look_after" if look.after else "look"] = self._wording(look.wording, own)
        text = self.render(self.pick(self.fitting(patterns, content), "noun phrase"), content, own)
        described, _, divided = text.rpartition(NOUN)
        return divided.replace(INSIDE, described) if INSIDE in divided else text

    def _colours(self, kind: str) -> Mapping[str, Pattern]:
        """Return the colour words for a kind of thing."""
        return {**self.voice.colours, **self.voice.colours_of.get(kind, {})}

    def _look(self, kind: str, value: str) -> LookWording:
        """Return the text's wording of a look: the voice's, or one that follows the noun."""
        if (kind, value) not in self._looks:
            usual = self.voice.looks[kind, value]
            behind = [each for each in self.grammar.looks[kind][value] if each.after and each.weight]
            self._looks[kind, value] = self.pick([usual, *([] if usual.after else behind)], f"look {value}")
        return self._looks[kind, value]

    def _adjective(self, value: str, listed: Mapping[str, Pattern], own: Mapping[str, str]) -> Filler:
        if value not in listed:
            raise ValueError(f"no words for {value!r}; expected one of {', '.join(listed)}")
        return self._wording(listed[value], own)

    # Relations

    def wheres(self, wheres: tuple[Where, ...], *, top: bool) -> str:
        """Return relations as one text; `top` if their subject is the sentence's subject, not a landmark."""
        text, focus = "", self.focus
        wheres = self._joined_wheres(wheres, top=top)
        for number, where in enumerate(wheres):
            content = self._where(where, top=top, alone=len(wheres) == 1)
            if number:
                key = "nested where"
                if top:
                    key = "where" if number == len(wheres) - 1 else "where of more"
                if top and _is_of_room(where, wheres[number - 1]) and "where of room" in self.grammar.joins:
                    key = "where of room"
                elif top and any(thing.where for thing in wheres[number - 1].things):
                    key = "where after clause"
                elif top and where.things[0].kind in ("you", "wall") and "where of you" in self.grammar.joins:
                    key = "where of you"
                fillers = {"a": constant(text), "b": constant(content)}
                content = self.render(self.pick(self.grammar.joins[key], key), fillers, self.features)
            text = content
            self.focus = focus_after(where.things, self.focus)
        self.focus = focus
        return text

    def _joined_wheres(self, wheres: tuple[Where, ...], *, top: bool) -> tuple[Where, ...]:
        """Return relations, the same one to two plain things as one if the language has words ("next to X and Y").

        Those that identify a landmark (not `top`) need words of their own.
        """
        if len(wheres) != 2 or wheres[0].relation != wheres[1].relation or any(where.exactly for where in wheres):
            return wheres
        things = tuple(thing for where in wheres for thing in where.things)
        plain = len(things) == 2 and not any(t.number or t.where or t.kind == "you" for t in things)
        name = wheres[0].relation if top else f"{wheres[0].relation} nested"
        patterns = self.grammar.where.get(name, ()) if plain and wheres[0].relation != "between" else ()
        return (_Pair(wheres[0].relation, things),) if self.fitting(patterns, ("thing", "other")) else wheres

    def _placed(self, where: Where) -> str:
        """Return a relation to a landmark that has one itself, in a clause of its own; "" if the language has no words.

        "Which mug is behind the hourglass, in front of it": a participle or "that is" before the noun would be harder.
        """
        landmark = where.things[0]
        if len(where.things) != 1 or len(landmark.where) != 1 or landmark.where[0].relation == "against":
            return ""
        patterns = self.grammar.where.get(f"{where.relation} placed", ())
        if not patterns:
            return ""
        exactly: dict[str, Value] = {"exactly": "yes"} if where.exactly else {}
        tables = self.table_fillers(exactly)
        fitting = self.fitting(patterns, ("thing", "where", *exactly), tables)
        if not fitting or self._must_be_short(landmark):
            return ""
        noun = self.noun(landmark)
        fillers = tables | {
            "where": lambda _: self.wheres(landmark.where, top=True),
            "thing": self.thing(replace(landmark, where=()), noun, (), top=False),
        }
        pattern = self.pick(fitting, f"{where.relation} of a placed {landmark.kind!r}")
        text = self.render(pattern, fillers, {**self.features, **dict(noun.given)})
        self.mentioned_things += where.things
        return text

    def _where(self, where: Where, *, top: bool, alone: bool) -> str:
        listed = self.grammar.where
        # Beside another relation, a clause about the landmark would be one clause too many.
        if top and alone and (placed := self._placed(where)):
            return placed
        content: dict[str, Value] = dict(zip(("thing", "other"), where.things, strict=False))
        if not isinstance(where, _Pair):
            content = dict(thing_slots(where.things))
        if where.exactly:
            content["exactly"] = "yes"
        kind = where.things[0].kind
        tables = self.table_fillers(content)
        patterns: Patterns = ()
        if content.keys() & {"pair", "several"} and where.relation != "between":
            patterns = self.fitting(listed.get(f"{where.relation} group", ()), content, tables)
        elif kind == "you" and "thing" in content:
            patterns = self.fitting(listed.get(f"{where.relation} you", ()), content.keys() - {"thing"}, tables)
        elif not top and f"{where.relation} nested" in listed:
            patterns = self.fitting(listed[f"{where.relation} nested"], content, tables)
        elif content.keys() == {"thing"} and where.things[0].is_same(self.focus):
            patterns = self.fitting(listed.get(f"{where.relation} same", ()), content.keys() - {"thing"}, tables)
        if kind != "you" or "thing" not in content:
            patterns = patterns or self.fitting(listed.get(where.relation, ()), content, tables)
        nouns = self.nouns(content)
        given = dict(nouns["thing"].given) if "thing" in nouns else {}
        pattern = self.pick(self.without_new(patterns, content), f"{where.relation} of {kind!r}")
        text = self.render(pattern, tables | self.thing_fillers(content, nouns), {**self.features, **given})
        self.mentioned_things += where.things
        return text
