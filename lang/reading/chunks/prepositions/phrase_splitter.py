"""Grouping of an English-like text's chunks into phrases, from left to right."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from arramon_client.world import COLLECTIBLE_PATTERNS
from arramon_lang.meaning import Thing
from arramon_lang.reading.chunks.chunker import RELATION, SIDE, SIDES, STOP, THEN, THING, VERB, Chunk
from arramon_lang.reading.chunks.prepositions.phrases import (
    OTHER,
    TARGET,
    THINGS,
    ListedThing,
    Phrase,
)
from arramon_lang.reading.chunks.sequence import ChunkSequence
from arramon_lang.reading.discourse import CROSSED_KINDS, GROUND_KINDS, Discourse
from arramon_lang.reading.parsed_phrases import NounPhrase

BUILDING_FEATURES = ("banner", "awning", "shop_sign", "building_corner", "wall", "corner")
"""Kinds of features that identify a building and are not landmarks of their own."""

_PRONOUNS = ("it", "them")

_CONJUNCTIONS = ("comma", "and")


@dataclass(slots=True, kw_only=True)
class PhraseSplitter:
    """Grouping of one text's chunks into phrases.

    Attributes:
        text: chunks of the text.
        discourse: resolves references.
        target: index of the chunk that names the target.
        phrases: phrases found so far.
    """

    text: ChunkSequence
    discourse: Discourse
    target: int
    phrases: list[Phrase] = field(default_factory=list)
    _joined: str = THEN
    _side: str = ""
    _last_side: str = ""
    _is_aside: bool = False
    _is_all: bool = False
    _is_correcting: bool = False
    _mentioned: list[Thing] = field(default_factory=list)
    _open: Phrase | None = None

    def read(self) -> list[Phrase]:
        """Return the phrases in order, without empty ones."""
        for number, chunk in enumerate(self.text.chunks):
            self._is_aside = self._is_aside and number != self.target and not _ends_aside(chunk)
            if self._is_aside:
                continue
            if chunk.kind == THING:
                self._handle_things(number)
            elif chunk.kind == RELATION:
                self._begin_relation(number, chunk.value)
            elif chunk.kind == SIDE:
                self._handle_side(number)
            elif chunk.kind == VERB:
                self._handle_verb(number)
            elif chunk.kind in _CONJUNCTIONS:
                self._join(chunk.kind)
            else:
                self._handle_word(number)
        return [phrase for phrase in self.phrases if phrase.kind != THINGS or phrase.named]

    # Things.

    def _handle_things(self, number: int) -> None:
        chunk = self.text.chunks[number]
        things = [self._resolved(named) for named in chunk.things]
        if number == self.target or (self.text.is_collectible(number) and not self._is_of_street(number, things[0])):
            kind = TARGET if number == self.target else OTHER
            relation = self._open.value if self._open is not None and not self._open.named else ""
            if self._open is not None and not self._open.named:
                self.phrases.remove(self._open)
            self.phrases.append(Phrase(kind, relation, self._joined, chunk, [ListedThing(things[0])]))
            self._open, self._joined, self._side = None, "", ""
        else:
            self._add(things, number)

    def _resolved(self, named: NounPhrase) -> Thing:
        thing = self.discourse.mention(named)
        if not thing.kind and thing.look not in COLLECTIBLE_PATTERNS and self._mentioned:
            thing = replace(thing, kind=self._mentioned[-1].kind)
        if self._open is not None and self._open.value == "at_end" and not self._open.named:
            self._open.value = "at"
            thing = Thing("street_end") if thing.kind in ("street", "alley") else thing
        return thing

    def _is_of_street(self, number: int, thing: Thing) -> bool:
        """Return whether a name without a noun ("the white one") refers to street furniture mentioned before."""
        return number < self.target and bool(self._mentioned) and thing.kind == self._mentioned[-1].kind

    def _add(self, things: Sequence[Thing], number: int) -> None:
        """Add things to the open phrase if it continues, or else to a new phrase."""
        if self._open is not None and self._open.named and not self._joined and things[0].kind == "corner":
            return  # "The barrel's corner."
        last = self.phrases[-1] if self.phrases else None
        if self._is_correcting and self._open is None and last is not None and last.kind == THINGS:
            self._open = last
        if self._is_correcting and self._open is not None and self._open.named:
            self._open.named.pop()
            self._joined = self._joined if self._open.named else ""
        elif self._open is None or not self._continues():
            self._begin("", number)
        self._is_correcting = False
        assert self._open is not None
        if self.text.chunks[number].is_additional and not self._side:
            self._side = self._last_side
        for thing in things:
            self._open.named.append(ListedThing(thing, self._side, self._joined if self._open.named else ""))
            self._joined = "and"
        if not self._identify_building(things):
            self._mentioned += things
        self._joined = ""

    def _identify_building(self, things: Sequence[Thing]) -> bool:
        """Return whether things only identify a building ("the white one with the banner")."""
        assert self._open is not None
        return self._open.value == "with" and not self._open.joined and things[0].kind in BUILDING_FEATURES

    def _continues(self) -> bool:
        assert self._open is not None
        if not self._open.named:
            return True
        if self._open.value == "between":
            return self._joined == "and"
        is_sided = bool(self._open.named[-1].side) and self._open.value in ("past", "over", "through", "under")
        return self._joined == "and" or (self._joined == "comma" and self._relates_list() and not is_sided)

    def _relates_list(self) -> bool:
        assert self._open is not None
        return self.text.rules.is_in(self._open.value, "listing")

    def _begin(self, value: str, number: int) -> None:
        self._open = Phrase(THINGS, value, self._joined, self.text.chunks[number])
        self.phrases.append(self._open)
        self._joined = ""

    def _begin_relation(self, number: int, value: str) -> None:
        following = self._following(number)
        if value == "bend" and self._is_at_place():
            self._is_aside = True
            return
        if value in self.text.rules.named_places:
            self._begin("at", number)
            self._add([Thing(self.text.rules.named_places[value])], number)
            return
        is_side_relation = self.text.next_is_relation(number, "left_of", "right_of")
        if following is None and value == "around" and not is_side_relation:
            self._add_word(replace(self.text.chunks[number], kind="round"))
        if following is None or (value == "of" and self._open is not None and not self._open.named):
            return
        if self._open is not None and not self._open.named:
            self.phrases.remove(self._open)
        if self._identifies_corner(value, following):
            return
        self._begin(value, number)
        if following.kind in _PRONOUNS:
            self._add(self._referents(value, following.kind), number)
            self.phrases[-1].is_pronoun = True

    def _identifies_corner(self, value: str, following: Chunk) -> bool:
        """Replace a corner by the building that identifies it; return whether the relation names no further thing."""
        if self._open is None or not self._open.named or self._joined or not following.things:
            return False
        kind, before = following.things[0].kind, self._open.last.kind
        if before == "corner" and value in ("with", "of", "by", "at") and kind in ("building", "shop_sign"):
            self._open.named.pop()  # "The corner with the bakery's sign."
            return True
        return value == "with" and kind == before

    def _referents(self, value: str, pronoun: str) -> list[Thing]:
        """Return the referents of a pronoun: the last one or two things, or the last street for "follow it"."""
        grounds = [thing for thing in self._mentioned[-3:] if thing.kind in GROUND_KINDS]
        if value == "along" and grounds:
            return grounds[-1:]
        return self._mentioned[-2:] if pronoun == "them" else self._mentioned[-1:]

    def _handle_where(self, number: int) -> None:
        """Read "where" as a place, or as a description of the place named before it."""
        if self._is_at_place():
            self._is_aside = True
        elif self.text.next_kind(number) == THING:
            self._begin_relation(number, "at")
        else:
            self._add_word(replace(self.text.chunks[number], kind="there"))

    def _is_at_place(self) -> bool:
        """Return whether a place has just been named, which "where" then describes."""
        is_open = self._open is not None and bool(self._open.named)
        return is_open and self._open is not None and self._open.value in ("at", "by", "near", "to", "until")

    def _drop_thing_behind(self) -> None:
        """Drop a thing that is behind the walker after a turn; "until it is behind you" means past it."""
        last = next((phrase for phrase in reversed(self.phrases) if phrase.kind != VERB), None)
        if last is not None and last.kind == THINGS and last.value == "until":
            last.value = "past"
        elif last is not None and last.kind == THINGS and last.value in ("", "with", "keep"):
            self.phrases.remove(last)

    def _following(self, number: int) -> Chunk | None:
        """Return the chunk of the thing that a relation applies to, or None."""
        for chunk in self.text.chunks[number + 1 : number + 3]:
            if chunk.kind == "round" or (chunk.kind == "comma" and self.text.chunks[number].value == "at"):
                continue  # "To about the barrel"; "left at, yes, the barrel".
            if chunk.kind == "there" and self.text.chunks[number].value == "before" and self._mentioned:
                return replace(chunk, kind="it")
            if chunk.kind in (THING, "again", *_PRONOUNS):
                return chunk if chunk.kind not in _PRONOUNS or self._mentioned else None
            if not (chunk.kind == SIDE and chunk.nominal):
                return None
        return None

    def _crossed_kind(self) -> str:
        if self._open is not None and self._open.value == "over":
            return next(
                (each.kind for each in reversed(self._mentioned) if each.kind in CROSSED_KINDS), "zebra_crossing"
            )
        return self._mentioned[-1].kind if self._mentioned else "zebra_crossing"

    # Sides.

    def _handle_side(self, number: int) -> None:
        chunk, named = self.text.chunks[number], [] if self._open is None else self._open.named
        following = self.text.next_kind(number)
        is_ended = following in ("comma", "and", STOP, THEN, "")
        before = self.text.chunks[number - 1].kind if number else ""
        if before in _PRONOUNS and following == RELATION and self.text.rules.is_in(chunk.value, "stressing"):
            return  # "Follow it right down to the hydrant."
        if chunk.value not in SIDES:
            self._add_word(chunk)
        elif self.text.next_is_relation(number, "of"):
            self._begin_side_relation(number)
        elif chunk.nominal and named and (not self._joined or (is_ended and self._joined == "comma")):
            self._set_side(chunk.value)
        elif chunk.nominal and following not in (STOP, THEN, ""):
            self._side = chunk.value
        elif named and not self._joined and self._is_of_thing(chunk, is_ended=is_ended):
            self._set_side(chunk.value)
        else:
            self._add_word(chunk)

    def _is_of_thing(self, chunk: Chunk, *, is_ended: bool) -> bool:
        """Return whether a side right after a thing belongs to it: "dumpster left", "the booth to your left"."""
        phrase = self._open
        assert phrase is not None
        before = self.phrases[-2] if len(self.phrases) > 1 else None
        if phrase.last.kind == "corner" or (before is not None and before.kind == VERB and before.value == "turn"):
            return False
        is_placed = chunk.end - chunk.start > 1 and phrase.value not in ("around", "along", "up", "into")
        return is_placed or phrase.value in ("", "with", "keep") or (is_ended and phrase.value == "past")

    def _set_side(self, side: str) -> None:
        """Give a side to the things joined by "and" before it."""
        assert self._open is not None
        named = self._open.named
        self._last_side = side
        is_list = len(named) > 2 and (self._open.value == "" or named[-1].joined == "and")
        for each in reversed(named):
            if each.side:
                break
            each.side = side
            if each.joined != "and" and not (is_list or self._is_all):
                break
        self._joined, self._is_all = "", False

    def _begin_side_relation(self, number: int) -> None:
        self._begin(f"{self.text.chunks[number].value}_of", number)

    # Verbs and other words.

    def _handle_word(self, number: int) -> None:
        """Handle a word that modifies its neighbours; other words become a phrase of their own."""
        chunk = self.text.chunks[number]
        following = self.text.next_kind(number)
        if chunk.kind == "where":
            self._handle_where(number)
        elif chunk.kind == "again" and self.text.chunks[number - 1].kind != SIDE:
            self._add([Thing(self._crossed_kind(), which="another")], number)
        elif chunk.kind == "correction":
            self._is_correcting = True
        elif chunk.kind == "or":
            self._is_aside, self._is_correcting = following in (THING, VERB), following == SIDE
        elif chunk.kind == "behind_you":
            self._drop_thing_behind()
        elif chunk.kind in (*_PRONOUNS, "all", "again"):
            self._is_all = chunk.kind == "all"
            self._joined = self._joined if self._joined == THEN else ""  # "Kiosk and hydrant, both left."
        else:
            self._add_word(chunk)

    def _handle_verb(self, number: int) -> None:
        chunk = self.text.chunks[number]
        following = self._following(number)
        if chunk.value in self.text.rules.verb_relations and following is not None:
            self._begin_relation(number, self.text.rules.verb_relations[chunk.value])
        elif not (self._open is not None and self._is_before_side(number)):
            self._add_word(chunk)

    def _is_before_side(self, number: int) -> bool:
        """Return whether a verb only introduces a thing's side ("the kiosk, which is on the right")."""
        following = self.text.chunks[number + 1] if number + 1 < len(self.text.chunks) else None
        if following is None or following.kind != SIDE or not following.nominal:
            return False
        self._joined = ""
        return self.text.chunks[number].value in ("be", "see", "walk", "keep")

    def _add_word(self, chunk: Chunk) -> None:
        self._open = None
        if chunk.kind in (STOP, THEN):
            self._side, self._is_correcting = "", False
        if self._is_correcting and chunk.kind == SIDE:
            self._correct_side()
        self.phrases.append(Phrase(chunk.kind, chunk.value, self._joined, chunk))
        self._joined = THEN if chunk.kind in (STOP, THEN) else ""

    def _correct_side(self) -> None:
        """Remove the side that is being corrected ("left, no, right")."""
        last = next((phrase for phrase in reversed(self.phrases) if phrase.kind != VERB), None)
        if last is not None and last.kind == SIDE:
            self._joined = last.joined
            self.phrases.remove(last)
        self._is_correcting = False

    def _join(self, kind: str) -> None:
        self._joined = "and" if kind == "and" and self._joined != THEN else self._joined or kind
        if kind == "comma":
            self._side = ""


def _ends_aside(chunk: Chunk) -> bool:
    return chunk.kind in ("comma", STOP, THEN) or (chunk.kind == VERB and chunk.value in ("turn", "bear", "walk"))
