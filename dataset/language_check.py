"""Check of a language's data, for `arramon-server language check`: files, texts of every kind of meaning, repeats."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from arramon_dataset.instructions.gate.texts import faults_of_reading
from arramon_dataset.language_meanings import all_meanings
from arramon_dataset.randomness import seeded
from arramon_dataset.statistics.properties import load_patterns
from arramon_lang.files import FILES, KINDS, OPTIONAL_FILES, read_file
from arramon_lang.language import ROOT, Language, available, load
from arramon_lang.meaning import Meaning, Navigation
from arramon_lang.quality import BLOCKED, check
from arramon_server.errors import BadFile, NotFound

PREVIEW = 20
"""Number of texts in the preview."""

SHOWN, SUMMED_UP = 20, 12
"""Maximum number of faults of one sort that a report lists, and of kinds of meaning in which it counts the others."""

MAX_MISREAD = 0.002
"""Maximum share of texts that may be misread, as generation rejects them."""

STEM = 4
"""Minimum length of a word with which its neighbour begins, in characters, that counts as a repeat."""

_SLOT = re.compile(r"\{([^{}:]+)")


@dataclass(frozen=True)
class LanguageReport:
    """The result of a check.

    Attributes:
        language: code of the language.
        meanings: number of kinds of meaning.
        texts: number of texts written.
        faults: what must be mended: faults of files, meanings that no text expresses, and texts that the quality checks
            block.
        misread: texts that are not read as they were meant. Generation rejects them.
        hints: what may be intended: files that are another language's, unused words, kinds without nouns, nouns without
            gender where others have one, neighbouring words that share their start.
        preview: some of the texts.
    """

    language: str
    meanings: int
    texts: int
    faults: tuple[str, ...]
    misread: tuple[str, ...]
    hints: tuple[str, ...]
    preview: tuple[str, ...]

    @property
    def passes(self) -> bool:
        """Whether there are no faults, and at most MAX_MISREAD of the texts are misread."""
        return not self.faults and len(self.misread) <= MAX_MISREAD * self.texts

    def lines(self, shown: int | None = SHOWN) -> Iterator[str]:
        """Yield the report as lines of text, with up to `shown` faults of each sort; None for all of them."""
        yield from self.preview
        yield ""
        for title, listed in (("fault", self.faults), ("misread", self.misread), ("hint", self.hints)):
            yield from (f"{title}: {line}" for line in listed[:shown])
            if further := listed[shown:] if shown is not None else ():
                counts = Counter(line.partition(":")[0] for line in further).most_common(SUMMED_UP)
                yield f"{title}: {len(further)} more: {', '.join(f'{name} ({count})' for name, count in counts)}"
        yield (
            f"{self.language}: {self.meanings} kinds of meaning, {self.texts} texts, {len(self.faults)} faults, "
            f"{len(self.misread)} misread, {len(self.hints)} hints"
        )


def check_language(
    code: str, *, seeds: int = 3, root: Path | None = None, meanings: Sequence[tuple[str, Meaning]] = ()
) -> LanguageReport:
    """Check a language's files, write every kind of meaning with several seeds, and read each text.

    Args:
        code: name of the language's folder.
        seeds: number of texts of each kind of meaning.
        root: folder that contains the languages' folders; None for the installed languages.
        meanings: with their names; empty for all.

    Raises:
        NotFound: if there is no such folder.
    """
    root = root or ROOT
    folder = root / code
    if not folder.is_dir():
        raise NotFound(f"there is no language {code!r} in {root}")
    faults = list(_faults_of_files(folder))
    if faults:
        return LanguageReport(code, 0, 0, tuple(faults), (), (), ())
    language, meanings = load(code, root), meanings or tuple(all_meanings())
    texts: list[str] = []
    misread: list[str] = []
    hints = list(_hints_of_files(folder, language))
    for number, (name, meaning) in enumerate(meanings):
        for seed in range(seeds):
            try:
                text = language.write(meaning, seeded(code, number, seed))
            except ValueError as error:
                faults.append(f"{name}: cannot be written: {error}")
                continue
            texts.append(text)
            misread += (f"{name}: {text}: {fault}" for fault in faults_of_reading(text, language, meaning))
            faults += (f"{name}: {text}: {fault}" for fault in _blocking(text, language, meaning, root))
            hints += (f"{name}: {text}: {repeat}" for repeat in repeats(language, text))
    preview = texts[:: max(1, len(texts) // PREVIEW)][:PREVIEW]
    found, wrong, unsure = (tuple(dict.fromkeys(each)) for each in (faults, misread, hints))
    return LanguageReport(code, len(meanings), len(texts), found, wrong, unsure, tuple(preview))


def descriptions() -> Iterator[str]:
    """Yield a line about each installed language."""
    for code in available():
        language = load(code)
        use = "in every generated episode" if language.required else "on request"
        mark = ", preview: not reviewed by native speakers" if language.preview else ""
        yield f"{code}  {language.english_name} ({language.name}), {language.script} script, {use}{mark}"


def repeats(language: Language, text: str) -> Iterator[str]:
    """Yield each pair of neighbouring words of which one begins with the other ("తర్వాత తర్వాతి")."""
    words = [token.casefold() for token in language.tokenize(text)]
    for first, second in pairwise(words):
        shorter, longer = sorted((first, second), key=len)
        if len(shorter) >= STEM and longer.startswith(shorter):
            yield f"{first!r} beside {second!r}"


def _faults_of_files(folder: Path) -> Iterator[str]:
    unreadable = list(_unreadable_files(folder))
    yield from unreadable
    known = {f"{name}.toml" for name in FILES}
    yield from (f"{path}: is not a file of a language" for path in sorted(folder.iterdir()) if path.name not in known)
    if unreadable:
        return
    try:
        language = Language(folder)
        language.grammar  # noqa: B018 - loads the files
        language.outline("")
        check("", folder.name, "navigation", root=folder.parent)
        load_patterns(folder.name, folder.parent)
    except (ValueError, KeyError, BadFile) as error:
        yield f"{folder}: {error}"


def _unreadable_files(folder: Path) -> Iterator[str]:
    """Yield what is wrong with each file that is missing, no TOML, or has unknown keys."""
    for name in FILES:
        path = folder / f"{name}.toml"
        if path.exists():
            try:
                read_file(folder, name)
            except ValueError as error:
                yield str(error)
        elif name not in OPTIONAL_FILES:
            yield f"{path}: is missing"


def _hints_of_files(folder: Path, language: Language) -> Iterator[str]:
    """Yield files of other languages, words that no pattern uses, kinds without a noun, and nouns without a gender."""
    for other in available():
        same = [name for name in FILES if other != folder.name and _is_same(folder / f"{name}.toml", ROOT / other)]
        yield from (f"{name}.toml: is the file of {other!r}, unchanged" for name in same)
    used = {name.strip() for name in _SLOT.findall(" ".join(_texts(folder)))}
    grammar = language.grammar
    yield from (f"grammar.toml: no text uses the word {name!r}" for name in grammar.words if name not in used)
    yield from (f"grammar.toml: no text uses the table {name!r}" for name in grammar.tables if name not in used)
    yield from (f"things.toml: no noun for {kind!r}" for kind in sorted(KINDS - {""}) if kind not in grammar.nouns)
    every = [(kind, dict(noun.given)) for kind, nouns in grammar.nouns.items() for noun in nouns]
    for axis in sorted(grammar.imposed):
        lacking = [kind for kind, given in every if axis not in given]
        if 2 * len(lacking) < len(every):  # Few nouns have an axis for a peculiarity of theirs.
            yield from (f"things.toml: a noun of {kind!r} has no {axis}, which most have" for kind in lacking)


def _is_same(path: Path, folder: Path) -> bool:
    """Return whether a file has the content of the file of its name in another folder."""
    other = folder / path.name
    return path.exists() and other.exists() and path.read_bytes() == other.read_bytes()


def _texts(folder: Path) -> Iterator[str]:
    """Yield the text of every pattern of a language's files."""

    def walk(value: object) -> Iterator[str]:
        if isinstance(value, str):
            yield value
        elif isinstance(value, dict):
            for each in value.values():
                yield from walk(each)
        elif isinstance(value, list):
            for each in value:
                yield from walk(each)

    for name in ("grammar", "things", "phrases"):
        yield from walk(dict(read_file(folder, name)))


def _blocking(text: str, language: Language, meaning: Meaning, root: Path) -> Iterator[str]:
    """Yield the quality checks that block a text, but for those of length: most of these texts have one step."""
    phase = "navigation" if isinstance(meaning, Navigation) else "assembly"
    for failure in check(text, language.code, phase, root=root):
        if failure.severity == BLOCKED and failure.check not in ("few_words", "few_unique"):
            yield f"{failure} (by quality.toml)"
