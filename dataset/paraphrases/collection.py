"""The split `val_unseen_paraphrased`: generated episodes of section 6 with freely written texts.

The package contains the episodes themselves, as the generator may change but the texts describe exactly these.
`data/README.md` documents how the texts were written and checked.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from arramon_server.episodes.episode import Episode, Instructions
from arramon_server.episodes.split_files import read_episodes, read_section
from arramon_server.episodes.splits import Split, write_split
from arramon_server.sim.section import Section

NAME = "val_unseen_paraphrased"

SOURCE = "generated, with machine-written paraphrases that no native speaker has reviewed"

HALVES = ("development", "test")
"""The first half's texts serve to improve parsers, the second half's only for final figures."""

DATA = Path(__file__).parent / "data"


@dataclass(frozen=True, slots=True)
class Paraphrase:
    """The texts of one turn in one language, and how a reader who saw neither path nor target understood them.

    Attributes:
        episode: id of the episode.
        turn: 1 or 2.
        language: code.
        writer: name of the writer.
        manner: the writer's style.
        half: one of HALVES; all texts of an episode are in one half.
        navigation, assembly: the texts.
        navigation_led, assembly_led: whether the reader found the target, and its cell; None if the text has not been
            read yet.
        meaning: the texts' meaning according to another reader: "steps", "target" and "room", see `data/README.md`;
            None for most episodes.
    """

    episode: str
    turn: int
    language: str
    writer: str
    manner: str
    half: str
    navigation: str
    assembly: str
    navigation_led: bool | None
    assembly_led: bool | None
    meaning: Mapping[str, Any] | None

    @property
    def key(self) -> tuple[str, int, str]:
        """Episode, turn and language: unique."""
        return self.episode, self.turn, self.language


_PARAPHRASE = TypeAdapter(Paraphrase)


@cache
def paraphrases() -> tuple[Paraphrase, ...]:
    """Return all texts, by episode, turn and language."""
    lines = (DATA / "texts.jsonl").read_text(encoding="utf-8").splitlines()
    return tuple(_PARAPHRASE.validate_json(line) for line in lines)


def paraphrased_episodes() -> list[Episode]:
    """Return the episodes with the paraphrases as their instructions."""
    texts = {(text.episode, text.turn, text.language): text for text in paraphrases()}
    languages = sorted({text.language for text in paraphrases()})

    def spoken(episode: str) -> Iterator[tuple[str, tuple[Instructions, Instructions]]]:
        for language in languages:
            turns = [texts[episode, turn, language] for turn in (1, 2)]
            first, second = (Instructions(text.navigation, text.assembly) for text in turns)
            yield language, (first, second)

    return [replace(episode, instructions=dict(spoken(episode.episode_id))) for episode in generated_episodes()]


def generated_episodes() -> list[Episode]:
    """Return the same episodes with their generated instructions."""
    return read_episodes(DATA / "episodes.jsonl.gz")[1]


def paraphrased_section() -> Section:
    """Return the section that the episodes take place in."""
    return read_section(DATA / "section.json")


def install(data: Path) -> Split:
    """Write the split into a data folder, replacing an earlier one, and return it.

    Raises:
        StorageError: if the folder cannot be written.
    """
    return write_split(
        data, NAME, hidden=False, source=SOURCE, episodes=paraphrased_episodes(), sections=[paraphrased_section()]
    )
