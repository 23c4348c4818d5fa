"""Collected texts as playable splits: one hidden split of one episode for each verification, found when it is played.

A verification of a text and one of a known episode look alike to the worker: both have the id of the task.
"""

import hashlib
import re
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from threading import Lock
from typing import Protocol

from pydantic import TypeAdapter

from arramon_server.episodes.episode import Episode, Instructions
from arramon_server.episodes.splits import Split
from arramon_server.sim.section import Section

PREFIX = "collecting"
"""First part of the splits' names."""

CACHED = 256
"""Number of splits that are kept, so that an episode that is played stays the same object."""

_NAME = re.compile(rf"{PREFIX}/(?P<collection>[^/]+)/(?P<key>[0-9a-f]{{32}})")

_EPISODE, _SECTION = TypeAdapter(Episode), TypeAdapter(Section)


@dataclass(frozen=True, slots=True)
class PlayableText:
    """A text of an episode, or a known episode with its own texts.

    Attributes:
        collection: name of the collection.
        key: id of a verification's task, or of a text: 32 hexadecimal digits.
        split: name of the split that has the episode.
        episode_id: id of the episode there.
        language: language of the text.
        instructions: texts of turn 1 and turn 2.
    """

    collection: str
    key: str
    split: str
    episode_id: str
    language: str
    instructions: tuple[Instructions, Instructions]


class TextSource(Protocol):
    """Finds what can be played."""

    def playable_text(self, collection: str, key: str) -> PlayableText | None:
        """Return what is followed in a verification, or the present version of a text; None if there is none."""
        ...


def split_name(collection: str, key: str) -> str:
    """Return the name of the split of a verification's task or of a text."""
    return f"{PREFIX}/{collection}/{key}"


def text_split(base: Split, text: PlayableText) -> Split:
    """Return the split of one text. The same text of the same episode gives the same `data_hash`.

    It is hidden and not ranked, and its episode has the key as its id, so that a worker who finds the episode elsewhere
    cannot recognise it by its id.

    Raises:
        KeyError: if the base split does not have the episode.
    """
    described = base.episodes[text.episode_id]
    episode = replace(described, episode_id=text.key, instructions={text.language: text.instructions})
    section = base.sections[episode.section]
    digest = hashlib.sha256(b"arramon collected text 1\n")
    for content in (_EPISODE.dump_json(episode), _SECTION.dump_json(section)):
        digest.update(f"{len(content)}\n".encode() + content)
    return Split(
        split_name(text.collection, text.key),
        hidden=True,
        source=f"collection {text.collection}",
        episodes={episode.episode_id: episode},
        sections={section.id: section},
        data_hash=digest.hexdigest(),
        training=True,
    )


class TextSplits(Mapping[str, Split]):
    """The splits of all verifications and texts, by name; they cannot be listed. Thread-safe.

    Args:
        own: splits of the data folder, by name.
        source: finds the texts.
    """

    def __init__(self, own: Mapping[str, Split], source: TextSource) -> None:
        self._own = own
        self._source = source
        self._kept = OrderedDict[PlayableText, Split]()
        self._lock = Lock()

    def __getitem__(self, name: str) -> Split:
        found = _NAME.fullmatch(name)
        text = self._source.playable_text(found["collection"], found["key"]) if found else None
        if text is None:
            raise KeyError(name)
        with self._lock:
            split = self._kept.pop(text, None) or text_split(self._own[text.split], text)
            self._kept[text] = split
            if len(self._kept) > CACHED:
                self._kept.popitem(last=False)
        return split

    def __iter__(self) -> Iterator[str]:
        return iter(())

    def __len__(self) -> int:
        return 0
