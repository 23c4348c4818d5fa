"""Pattern matching on a text's words, with an automaton that tries many patterns at once."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from arramon_lang.patterns import Alternatives, Pattern
from arramon_lang.patterns import Sequence as Body
from arramon_lang.tokens import PAUSES, SENTENCE_ENDS

Keys = tuple[str, ...]
Bindings = tuple[tuple[str, object], ...]
"""(slot, value) pairs in order, without slots that have no value."""

SplitWords = Callable[[str], Keys]
"""Function that splits a text into comparison keys."""

OPTIONAL = frozenset(f"{PAUSES}{SENTENCE_ENDS}-–")
"""Punctuation in patterns that texts may omit."""


@dataclass(frozen=True, slots=True)
class PatternLabel:
    """Identifies the pattern that matched.

    Attributes:
        key: key in `phrases.toml`.
        only_read: whether the pattern is only read, never written.
        main_only: whether it is valid as a main clause only.
    """

    key: str
    only_read: bool = False
    main_only: bool = False


@dataclass(slots=True)
class Node:
    """A state of the automaton, with its transitions."""

    words: dict[str, list["Node"]] = field(default_factory=dict)
    slots: dict[str, list["Node"]] = field(default_factory=dict)
    accepted: list[PatternLabel] = field(default_factory=list)

    def join(self, other: "Node") -> None:
        """Add all transitions and labels of another state."""
        for word, nodes in other.words.items():
            self.words.setdefault(word, []).extend(nodes)
        for slot, nodes in other.slots.items():
            self.slots.setdefault(slot, []).extend(nodes)
        self.accepted.extend(label for label in other.accepted if label not in self.accepted)

    def after_word(self, word: str) -> "Node | None":
        """Return the state after a word, or None."""
        nodes = self.words.get(word)
        return _merged(nodes) if nodes else None

    def after_slot(self, slot: str) -> "Node":
        """Return the state after a slot."""
        return _merged(self.slots[slot])


def _merged(nodes: list[Node]) -> Node:
    """Return one state equivalent to all of these, and replace the list by it, so that it is built once."""
    if len(nodes) > 1:
        one = Node()
        for node in {id(node): node for node in nodes}.values():
            one.join(node)
        nodes[:] = [one]
    return nodes[0]


@dataclass(frozen=True, slots=True)
class Match:
    """A match of the labelled pattern, up to but excluding word `end`."""

    end: int
    label: PatternLabel
    bound: Bindings


class Automaton:
    """Patterns with slots, compiled to one automaton that finds all that match; a `Phrasebook` holds fixed phrases.

    Args:
        split: splits a text into comparison keys.
        optional: words of patterns that texts may omit, besides punctuation.

    Attributes:
        vocabulary: all words of the patterns.
    """

    def __init__(self, split: SplitWords, optional: frozenset[str] = frozenset()) -> None:
        self._split = split
        self._optional = OPTIONAL | optional
        self._start = Node()
        self.vocabulary: set[str] = set()

    def add(self, key: str, patterns: Iterable[Pattern], *, only_read: bool = False) -> None:
        """Add patterns with a key; `only_read` if they are never written."""
        for pattern in patterns:
            self.add_body(PatternLabel(key, only_read, pattern.main_only), pattern.body)

    def add_body(self, label: PatternLabel, body: Body) -> None:
        """Add a pattern's body with a label."""
        self._start.join(self._compiled(body, Node(accepted=[label])))

    def _compiled(self, body: Body, after: Node) -> Node:
        for part in reversed(body):
            if isinstance(part, str):
                for word in reversed(self._split(part)):
                    before = Node(words={word: [after]})
                    if word in self._optional:
                        before.join(after)
                    if word not in OPTIONAL:
                        self.vocabulary.add(word)
                    after = before
            elif isinstance(part, Alternatives):
                before = Node()
                for option in part.options:
                    before.join(self._compiled(option, after))
                after = before
            else:
                after = Node(slots={part.name: [after]})
        return after

    def find(
        self,
        keys: Sequence[str],
        start: int,
        read: Callable[[str, int], Iterable[tuple[int, object]]],
        excluded: Sequence[frozenset[str]] = (),
    ) -> Iterator[Match]:
        """Yield all matches that begin at `keys[start]`.

        Args:
            keys: the text's words.
            start: index of the first word.
            read: returns, for a slot's name and an index, all possible ends and values there (None if a slot has no
                value).
            excluded: for each index, including the text's end, names of slots that nothing there can fill, for which
                `read` is not called. Empty if unknown.
        """
        size = len(keys)
        pending: list[tuple[Node, int, Bindings]] = [(self._start, start, ())]
        while pending:
            node, at, bound = pending.pop()
            for label in node.accepted:
                yield Match(at, label, bound)
            after = node.after_word(keys[at]) if at < size else None
            if after is not None:
                pending.append((after, at + 1, bound))
            if node.slots:
                without = excluded[at] if excluded else ()
                for slot in node.slots:
                    if slot not in without:
                        for end, value in read(slot, at):
                            filled = bound if value is None else (*bound, (slot, value))
                            pending.append((node.after_slot(slot), end, filled))


def with_and_without(keys: Keys, optional: frozenset[str]) -> list[Keys]:
    """Return a phrase and, if it differs and is not empty, the phrase without the optional words."""
    without = tuple(key for key in keys if key not in optional)
    return [keys, without] if without and without != keys else [keys]


class Phrasebook:
    """Fixed phrases with meanings, looked up by their words; an `Automaton` holds patterns with slots.

    Attributes:
        vocabulary: all words of the phrases.
    """

    def __init__(self) -> None:
        self._entries: dict[str, list[tuple[Keys, object]]] = {}
        self.empty: list[object] = []
        self.vocabulary: set[str] = set()

    def add(self, keys: Keys, meaning: object) -> None:
        """Add a phrase; an empty one matches everywhere."""
        if not keys:
            self.empty.append(meaning)
        elif (keys, meaning) not in (entries := self._entries.setdefault(keys[0], [])):
            entries.append((keys, meaning))
            entries.sort(key=lambda entry: -len(entry[0]))
            self.vocabulary.update(keys)

    def entries(self) -> Iterator[tuple[Keys, object]]:
        """Yield all phrases that are not empty, with their meanings."""
        for listed in self._entries.values():
            yield from listed

    def may_begin(self, key: str | None) -> bool:
        """Return whether a phrase may begin with a word, or at the end of a text (None)."""
        return bool(self.empty) or key in self._entries

    def at(self, keys: Sequence[str], start: int) -> Iterator[tuple[int, object]]:
        """Yield the end and the meaning of each phrase that begins at `keys[start]`, the longest first."""
        if start < len(keys):
            for phrase, meaning in self._entries.get(keys[start], ()):
                size = len(phrase)
                if size == 1 or tuple(keys[start : start + size]) == phrase:
                    yield start + size, meaning
        for meaning in self.empty:
            yield start, meaning
