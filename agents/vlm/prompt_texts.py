"""Prompts of the agent, from TOML files, one for each language."""

import hashlib
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from string import Template

from arramon_client.errors import AgentLoadError

FOLDER = Path(__file__).parent / "prompts"
FALLBACK = "en"


class Prompts:
    """The texts of one language.

    Attributes:
        language: of the texts; that of the instructions unless the agent has no prompts in it.
    """

    def __init__(self, language: str, texts: Mapping[str, str]) -> None:
        self.language = language
        self._texts = texts

    def text(self, key: str, **values: object) -> str:
        """Return a text with its placeholders filled in.

        Args:
            key: such as "system" or "observation.blocked".
            values: by the names of placeholders.
        """
        return Template(self._texts[key]).substitute({name: str(value) for name, value in values.items()}).strip()


class PromptFolder:
    """The prompts of all languages.

    Args:
        custom: a file that is used in every language in place of the shipped ones; None for these.
        notify: called with a notice if the agent has no prompts in a language.

    Attributes:
        digest: hash of all texts, 12 hexadecimal digits.

    Raises:
        AgentLoadError: if the custom file cannot be read, or lacks a key.
    """

    def __init__(self, custom: str | None, notify: Callable[[str], None]) -> None:
        self._custom = Path(custom) if custom is not None else None
        self._notify = notify
        self._loaded: dict[str, Prompts] = {}
        paths = [self._custom] if self._custom is not None else sorted(FOLDER.glob("*.toml"))
        self._read = {path.stem: _read(path) for path in paths}
        if self._custom is not None:
            _check_keys(self._custom, self._read[self._custom.stem])
        content = repr([sorted(texts.items()) for texts in self._read.values()])
        self.digest = hashlib.sha256(content.encode()).hexdigest()[:12]

    def of(self, language: str) -> Prompts:
        """Return the prompts for instructions in a language; English ones, with a notice, if there are none in it."""
        if language not in self._loaded:
            self._loaded[language] = self._find(language)
        return self._loaded[language]

    def _find(self, language: str) -> Prompts:
        if self._custom is not None:
            return Prompts(language, self._read[self._custom.stem])
        if language in self._read:
            return Prompts(language, self._read[language])
        self._notify(
            f"agents.vlm has no prompts in {language!r}, only in {', '.join(self._read)}: it asks in English. Add "
            f"{FOLDER / language}.toml, or give a file with --agent-arg prompts=FILE"
        )
        return Prompts(FALLBACK, self._read[FALLBACK])


def _read(path: Path) -> dict[str, str]:
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise AgentLoadError(f"agents.vlm: prompts {path} cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise AgentLoadError(f"agents.vlm: prompts {path} are not TOML: {error}") from error
    texts = {}
    for name, value in content.items():
        for key, text in ({name: value} if not isinstance(value, dict) else _prefixed(name, value)).items():
            if not isinstance(text, str):
                raise AgentLoadError(f"agents.vlm: prompts {path}: {key} is {text!r}; expected a text")
            texts[key] = text
    return texts


def _prefixed(name: str, table: Mapping[str, object]) -> dict[str, object]:
    return {f"{name}.{key}": value for key, value in table.items()}


def _check_keys(path: Path, texts: Mapping[str, str]) -> None:
    """Check that a custom file has the keys of the English one, and no placeholders that are never filled in.

    Raises:
        AgentLoadError: if not.
    """
    model = _read(FOLDER / f"{FALLBACK}.toml")
    missing = [key for key in model if key not in texts]
    if missing:
        raise AgentLoadError(f"agents.vlm: prompts {path} lack {missing[0]}; {FOLDER / FALLBACK}.toml has all keys")
    for key, text in texts.items():
        known = set(Template(model.get(key, "")).get_identifiers())
        template = Template(text)
        if not template.is_valid() or not set(template.get_identifiers()) <= known:
            names = ", ".join(f"${name}" for name in sorted(known)) or "none"
            raise AgentLoadError(
                f"agents.vlm: prompts {path}: {key} has an unknown placeholder; expected {names}, and $$ for a dollar"
            )
