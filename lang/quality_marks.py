"""Places of the words at fault in a text that failed quality checks."""

import re
from pathlib import Path

from arramon_lang.language import ROOT, load
from arramon_lang.quality import Failure


def marks(text: str, failure: Failure, language: str, root: Path = ROOT) -> tuple[tuple[int, int], ...]:
    """Return where the words at fault of a failure are in a text, as (start, end) in characters of `text`, in order.

    Args:
        text: the checked text, as given to `check`.
        failure: one that `check` returned for it.
        language: code of the language.
        root: folder that contains the languages' folders.
    """
    tokens = [token for token in load(language, root).split(text) if any(map(str.isalnum, token.text))]
    keys = [token.key for token in tokens]
    found = set[tuple[int, int]]()
    for words in map(str.split, failure.words):
        runs = [start for start in range(len(keys)) if keys[start : start + len(words)] == words]
        found |= {(tokens[start].start, tokens[start + len(words) - 1].end) for start in runs}
        if not runs:  # A symbol, letters within a word, or words with hyphens.
            pattern = r"\s+".join(map(re.escape, words))
            found |= {match.span() for match in re.finditer(pattern, text, re.IGNORECASE)}
    return tuple(sorted(found))
