"""Checks of a text while it is written: the paper's, which may block it, and this project's own, which never do."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from numpy import hypot

from arramon_collecting.storage.texts.records import HINT
from arramon_collecting.writing.bends import initial_turn
from arramon_collecting.writing.characters import invisible_in, pictures_in
from arramon_collecting.writing.exact_names import names_exactly
from arramon_collecting.writing.walk import PARTS, lines, room_before
from arramon_dataset.instruction_writer import initial_turn_angle
from arramon_dataset.instructions.assembly.plan import MIN_LEAD
from arramon_dataset.instructions.assembly.visible_objects import whole_room
from arramon_dataset.release.landmarks.agreement import placed_things
from arramon_dataset.release.landmarks.turn_paths import paths_of_turns
from arramon_dataset.world_check import absent_things
from arramon_lang.cell_grading import Cell, Room, find_cell, is_all_there
from arramon_lang.language import ROOT, load
from arramon_lang.meaning import Assembly, Thing
from arramon_lang.quality import BLOCKED, SUSPICIOUS, Failure, check
from arramon_lang.quality_marks import marks
from arramon_server.episodes.episode import Episode
from arramon_server.sim.own_furniture import furnished
from arramon_server.sim.rules import Phase
from arramon_server.sim.section import Section

SEVERITIES = (BLOCKED, SUSPICIOUS, HINT)
"""Severities of findings; hints are this project's own checks."""

NEVER_SURE = frozenset(("banner",))
"""Kinds about which the reader of texts is never sure: it takes a shop with a colour ("the blue bank") for a banner."""

IN_SIGHT = 40.0
"""Distance from the path, in units, within which a writer may well mean a thing of the kind that the text names."""


@dataclass(frozen=True, slots=True)
class Finding:
    """A failed check of a text.

    Attributes:
        check: its name; the page has a sentence for each.
        severity: one of SEVERITIES.
        words: the words or characters at fault.
        expected: what was expected instead, as in `arramon_lang.quality.Failure`; for "not_there" the kind of thing.
        marks: where the words at fault are, as (start, end) in characters of the text as given.
        term: as in `Failure`.
    """

    check: str
    severity: str
    words: tuple[str, ...] = ()
    expected: str = ""
    marks: tuple[tuple[int, int], ...] = ()
    term: str = ""


@dataclass(frozen=True, slots=True)
class TextChecker:
    """Checks the texts of one episode.

    Attributes:
        episode: the episode.
        section: its section, without the episode's own furniture.
        language: code of the texts' language.
        max_characters: maximum number of characters of a text.
        root: folder that contains the languages' folders.
    """

    episode: Episode
    section: Section
    language: str
    max_characters: int
    root: Path = ROOT

    def findings(self, text: str, part: int) -> tuple[Finding, ...]:
        """Return the failed checks of a text, those that block it first.

        Args:
            text: as the writer typed it.
            part: index in `walk.PARTS`.
        """
        too_long = len(text) > self.max_characters
        found = list(self._characters(text))
        if not too_long:  # The checks take time with the square of the length.
            found += self._quality(text, part)
            found += self._own(text, part)
        return tuple(sorted(found, key=lambda finding: SEVERITIES.index(finding.severity)))

    def _characters(self, text: str) -> Iterator[Finding]:
        if len(text) > self.max_characters:
            yield Finding("too_long", BLOCKED, expected=str(self.max_characters))
        for name, letters in (
            ("picture", pictures_in(text)),
            ("invisible", invisible_in(text, self.language, self.root)),
        ):
            if letters:
                at = tuple((i, i + 1) for i, letter in enumerate(text) if letter in letters)
                yield Finding(name, BLOCKED, tuple(map(_name_of, letters)), marks=at)

    def _quality(self, text: str, part: int) -> Iterator[Finding]:
        number, phase = PARTS[part]
        turn = self.episode.turns[number - 1]
        type_ = turn.target.type
        target = Thing(type_.kind, type_.colour, type_.pattern)
        # A stub of the line, which together with the next bends leads straight on, need not be told.
        first_turn = min(initial_turn_angle(turn.actions), abs(initial_turn(lines(self.episode)[number - 1])))
        found: dict[tuple[str, str, str, str], list[Failure]] = {}
        for failure in check(text, self.language, phase, target=target, first_turn=first_turn, root=self.root):
            key = (failure.check, failure.severity, failure.expected, failure.term)
            found.setdefault(key, []).append(failure)
        for (name, severity, expected, term), failures in found.items():
            words = dict.fromkeys(word for failure in failures for word in failure.words)
            at = {span for failure in failures for span in marks(text, failure, self.language, self.root)}
            yield Finding(name, severity, tuple(words), expected, tuple(sorted(at)), term)

    def _own(self, text: str, part: int) -> Iterator[Finding]:
        if not load(self.language, self.root).has_grammar:
            return
        turn, phase = PARTS[part]
        if phase == Phase.ASSEMBLY.value:
            yield from self._cells(text, turn)
            return
        seen = self._kinds_along(turn) | NEVER_SURE
        for thing in absent_things(text, self.language, self.episode, turn, self.section):
            kind = thing.event.kind
            if kind not in seen and names_exactly(text, kind, self.language, self.root):
                seen.add(kind)
                yield Finding("not_there", HINT, expected=kind)

    def _kinds_along(self, turn: int) -> set[str]:
        """Return the kinds of street furniture that stand in sight of a turn's path.

        Of these the writer may mean another one than the aligned text implies, so that nothing is said about them.
        """
        places = paths_of_turns(self.episode)[turn - 1].places
        things = placed_things(furnished(self.section, self.episode.furniture).props)
        return {kind for kind, x, z, *_ in things if hypot(*(places - (x, z)).T).min() < IN_SIGHT}

    def _cells(self, text: str, turn: int) -> Iterator[Finding]:
        """Yield what a text about the room leaves open: its cell, or an object that is not there.

        Nothing is said of texts of which the reader skips a word: about half of people's correct texts were misread by
        that, and who has seen several wrong hints reads no more of them.
        """
        spoken, phase = load(self.language, self.root), Phase.ASSEMBLY.value
        try:
            meaning = spoken.read(text, phase)
        except ValueError:  # Nothing of it is understood, which says nothing about the text.
            return
        assert isinstance(meaning, Assembly)
        room = whole_room(room_before(self.episode, turn))
        goal = self.episode.turns[turn - 1].target_cell
        doubt = _doubt(meaning, room, (goal.column, goal.row))
        if doubt and spoken.reads_whole(text, phase):
            yield Finding(doubt, HINT)


def _doubt(meaning: Assembly, room: Room, goal: Cell) -> str:
    """Return the name of the hint about a text with this meaning; "" for none."""
    named = [thing for where in meaning.where for thing in where.things]
    if not named or any(thing.kind == "corner" for thing in named):  # Of corners the room has no list.
        return ""
    if not is_all_there(meaning, room):
        return "not_in_room"
    cell, lead = find_cell(meaning, room)
    if cell != goal:
        return "other_cell"
    return "two_cells" if lead < MIN_LEAD else ""


def any_blocks(findings: tuple[Finding, ...]) -> bool:
    """Return whether any of the findings prevents that the text is submitted."""
    return any(finding.severity == BLOCKED for finding in findings)


def _name_of(letter: str) -> str:
    """Return a character for a message: itself, or its number if it is not visible."""
    return letter if letter.isprintable() else f"U+{ord(letter):04X}"
