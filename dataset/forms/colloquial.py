"""Free paraphrases: a meaning written anew in another voice, with colloquial wordings."""

import re
import tomllib
from collections.abc import Mapping
from functools import cache
from random import Random
from typing import Any

from arramon_dataset.forms.tables import DATA


def colloquial(text: str, language: str, random: Random) -> str:
    """Return a text with colloquial wordings.

    Args:
        text: in the language.
        language: "en" or "hi".
        random: source of all choices.
    """
    rules = _rules()[language]
    for pattern, wordings in rules["rules"]:

        def worded(match: re.Match[str], wordings: list[str] = wordings) -> str:
            chosen = random.choice(wordings)
            return match.group() if chosen == "=" else match.expand(chosen)

        text = re.sub(pattern, worded, text)
    opener: str = random.choice(rules["openers"])
    return f"{opener}{text[0].lower() if opener and language == 'en' else text[0]}{text[1:]}"


@cache
def _rules() -> Mapping[str, Any]:
    return tomllib.loads((DATA / "colloquial.toml").read_text(encoding="utf-8"))
