"""Finds patterns in a text's words: they are compiled to one automaton, so that many are tried at once."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from lang.patterns import Choice, Pattern
from lang.patterns import Sequence as Body

Keys = tuple[str, ...]
Bound = tuple[tuple[str, object], ...]
"""What was found in each slot that has a value, in order."""

Split = Callable[[str], Keys]
"""Gives a text's words as they are compared."""

OPTIONAL = frozenset(",.;:।-–")
"""Marks that are read whether or not they stand in the text."""


@dataclass(frozen=True, slots=True)
class Label:
    """Which pattern was found.

    Attributes:
        key: under which it is listed in `phrases.toml`.
        also: whether it is one that is only read.
        main_only: whether it can only be a main clause.
    """

    key: str
    also: bool = False
    main_only: bool = False


@dataclass(slots=True)
class Node:
    """A state: what may come next."""

    words: dict[str, list["Node"]] = field(default_factory=dict)
    slots: dict[str, list["Node"]] = field(default_factory=dict)
    accepted: list[Label] = field(default_factory=list)

    def join(self, other: "Node") -> None:
        """Take over all that the other may be followed by."""
        for word, nodes in other.words.items():
            self.words.setdefault(word, []).extend(nodes)
        for slot, nodes in other.slots.items():
            self.slots.setdefault(slot, []).extend(nodes)
        self.accepted.extend(label for label in other.accepted if label not in self.accepted)

    def after_word(self, word: str) -> "Node | None":
        """What may follow that word."""
        nodes = self.words.get(word)
        return _merged(nodes) if nodes else None

    def after_slot(self, slot: str) -> "Node":
        """What may follow that slot."""
        return _merged(self.slots[slot])


def _merged(nodes: list[Node]) -> Node:
    """The one state that stands for all of these; the list is made to hold it alone, so that it is made once."""
    if len(nodes) > 1:
        one = Node()
        for node in {id(node): node for node in nodes}.values():
            one.join(node)
        nodes[:] = [one]
    return nodes[0]


@dataclass(frozen=True, slots=True)
class Match:
    """A pattern found: it ends before `end`; `label` is that of the pattern."""

    end: int
    label: Label
    bound: Bound


class Automaton:
    """Patterns with labels, ready to be found.

    Args:
        split: of the language.

    Attributes:
        vocabulary: all words in the patterns.
    """

    def __init__(self, split: Split) -> None:
        self._split = split
        self._start = Node()
        self.vocabulary: set[str] = set()

    def add(self, key: str, patterns: Iterable[Pattern], *, also: bool = False) -> None:
        """Have these patterns found, under that key; `also` where they are only read."""
        for pattern in patterns:
            self.add_body(Label(key, also, pattern.main_only), pattern.body)

    def add_body(self, label: Label, body: Body) -> None:
        """The same for a pattern's body."""
        self._start.join(self._compiled(body, Node(accepted=[label])))

    def _compiled(self, body: Body, after: Node) -> Node:
        for part in reversed(body):
            if isinstance(part, str):
                for word in reversed(self._split(part)):
                    before = Node(words={word: [after]})
                    if word in OPTIONAL:
                        before.join(after)
                    else:
                        self.vocabulary.add(word)
                    after = before
            elif isinstance(part, Choice):
                before = Node()
                for option in part.options:
                    before.join(self._compiled(option, after))
                after = before
            else:
                after = Node(slots={part.name: [after]})
        return after

    def find(
        self, keys: Sequence[str], start: int, read: Callable[[str, int], Iterable[tuple[int, object]]]
    ) -> Iterator[Match]:
        """All patterns that begin at `keys[start]`.

        Args:
            keys: the text's words.
            start: where the patterns are to begin.
            read: what a slot of that name, at that place, can be: where it ends, and its value (None if it has none).
        """
        pending: list[tuple[Node, int, Bound]] = [(self._start, start, ())]
        while pending:
            node, at, bound = pending.pop()
            for label in node.accepted:
                yield Match(at, label, bound)
            after = node.after_word(keys[at]) if at < len(keys) else None
            if after is not None:
                pending.append((after, at + 1, bound))
            for slot in node.slots:
                for end, value in read(slot, at):
                    pending.append((node.after_slot(slot), end, bound if value is None else (*bound, (slot, value))))


class Phrasebook:
    """Phrases with meanings, found by their words.

    Attributes:
        vocabulary: all words in the phrases.
    """

    def __init__(self) -> None:
        self._entries: dict[str, list[tuple[Keys, object]]] = {}
        self.empty: list[object] = []
        self.vocabulary: set[str] = set()

    def add(self, keys: Keys, meaning: object) -> None:
        """Have a phrase found; an empty one is found everywhere."""
        if not keys:
            self.empty.append(meaning)
        elif (keys, meaning) not in (entries := self._entries.setdefault(keys[0], [])):
            entries.append((keys, meaning))
            entries.sort(key=lambda entry: -len(entry[0]))
            self.vocabulary.update(keys)

    def at(self, keys: Sequence[str], start: int) -> Iterator[tuple[int, object]]:
        """The end and the meaning of each phrase that begins at `keys[start]`, the longest first."""
        if start < len(keys):
            for phrase, meaning in self._entries.get(keys[start], ()):
                if tuple(keys[start : start + len(phrase)]) == phrase:
                    yield start + len(phrase), meaning
        for meaning in self.empty:
            yield start, meaning
