"""Detection of the paper's linguistic properties of texts, by patterns of each language."""

import re
import tomllib
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from arramon_lang.language import ROOT, language_folder
from arramon_server.errors import BadFile

PROPERTIES = ("egocentric", "allocentric", "temporal", "directional", "sequencing", "discrete_3d")
"""Names of the properties, in the paper's order."""

FILE = "properties.toml"

_PART = re.compile(r"\{([a-z]+)\}")


@dataclass(frozen=True, eq=False)
class Patterns:
    """The patterns and stop words of one language.

    Attributes:
        properties: pattern that detects each of `PROPERTIES`.
        stopwords: words left out of the most frequent words.
    """

    properties: Mapping[str, re.Pattern[str]]
    stopwords: frozenset[str]

    def find(self, words: Sequence[str]) -> frozenset[str]:
        """Return the properties that a text shows, given its words."""
        text = f" {' '.join(words)} "
        return frozenset(name for name, pattern in self.properties.items() if pattern.search(text))


@cache
def load_patterns(code: str, root: Path = ROOT) -> Patterns:
    """Read and validate the patterns of a language.

    Raises:
        BadFile: if the language's `properties.toml` is missing, or not as described in that of `lang/en`.
    """
    path = language_folder(code, root) / FILE
    try:
        data = tomllib.loads(unicodedata.normalize("NFC", path.read_text(encoding="utf-8")))
    except OSError as error:
        raise BadFile(path, f"cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise BadFile(path, f"is not TOML: {error}") from error
    parts = _texts(path, data, "parts", str)
    patterns = _texts(path, data, "properties", list)
    if set(patterns) != set(PROPERTIES):
        raise BadFile(path, f"has {', '.join(patterns)}; expected {', '.join(PROPERTIES)}", field="properties")
    stopwords = data.get("stopwords")
    if not isinstance(stopwords, list) or not all(isinstance(word, str) for word in stopwords):
        raise BadFile(path, "is not a list of words", field="stopwords")
    compiled = {name: _compile(path, name, patterns[name], parts) for name in PROPERTIES}
    return Patterns(compiled, frozenset(word.casefold() for word in stopwords))


def _texts(path: Path, data: Mapping[str, Any], name: str, kind: type) -> dict[str, Any]:
    table = data.get(name)
    if not isinstance(table, dict) or not all(isinstance(value, kind) for value in table.values()):
        raise BadFile(path, f"is not a table of {'strings' if kind is str else 'lists of strings'}", field=name)
    return table


def _compile(path: Path, name: str, patterns: Sequence[str], parts: Mapping[str, str]) -> re.Pattern[str]:
    """Return all patterns of a property as one that matches whole words."""
    field = f"properties.{name}"

    def part(found: re.Match[str]) -> str:
        if found[1] not in parts:
            raise BadFile(path, f"has an unknown part {found[0]}; expected one of {', '.join(parts)}", field=field)
        return _PART.sub(part, parts[found[1]])

    try:
        return re.compile(rf"(?<= )(?:{'|'.join(_PART.sub(part, pattern) for pattern in patterns)})(?= )")
    except (re.error, TypeError, RecursionError) as error:
        raise BadFile(path, f"is not a list of regular expressions: {error}", field=field) from error
