"""Which text a worker verifies next, and when a known episode takes its place. Pure."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime


@dataclass(frozen=True, slots=True)
class PastWork:
    """What a worker has begun in a collection, in whatever state it is now.

    Attributes:
        worker_id: the worker.
        written: ids of the episodes that they have written for.
        walked: ids of the episodes that they have walked in verifications, known ones included.
    """

    worker_id: str
    written: frozenset[str] = frozenset()
    walked: frozenset[str] = frozenset()

    def knows(self, episode_id: str) -> bool:
        """Return whether the worker has been shown the episode."""
        return episode_id in self.written or episode_id in self.walked


@dataclass(frozen=True, slots=True)
class WaitingText:
    """A text that waits for verifications.

    Attributes:
        text_id: the text.
        episode_id: the episode that it describes.
        author: worker who wrote it; None for a text without one.
        missing: number of verifications that it still needs, without those that are open.
        submitted_at: when it was submitted.
    """

    text_id: str
    episode_id: str
    author: str | None
    missing: int
    submitted_at: datetime


def may_verify(text: WaitingText, past: PastWork) -> bool:
    """Return whether a worker may verify a text: neither their own, nor of an episode that they have been shown."""
    return text.author != past.worker_id and not past.knows(text.episode_id)


def next_text(texts: Iterable[WaitingText], past: PastWork) -> WaitingText | None:
    """Return the text that a worker verifies next; None if there is none.

    Texts that are nearly decided come first, so that few are in between, and among equal ones the oldest.
    """
    open_texts = [text for text in texts if text.missing > 0 and may_verify(text, past)]
    return min(open_texts, key=lambda text: (text.missing, text.submitted_at, text.text_id), default=None)


def is_gold_due(tasks: int, golds: int, share: float, draw: float) -> bool:
    """Return whether a worker's next verification is a known episode (a gold).

    The share holds over time, and no worker can count on which task is one.

    Args:
        tasks: number of the worker's verifications so far, golds included.
        golds: number of golds among them.
        share: desired share of golds, 0 to 1.
        draw: random number in [0, 1).
    """
    return draw < share * (tasks + 1) - golds


def gold_episodes(episode_ids: Sequence[str], past: PastWork) -> list[str]:
    """Return the known episodes that a worker has not been shown, in the given order."""
    return [episode_id for episode_id in episode_ids if not past.knows(episode_id)]
