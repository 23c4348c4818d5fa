"""Who gets which task.

As in the paper, nobody gets a map again that they know, and no map gets two sets of instructions: nobody verifies their
own text or an episode that they have written for, and nobody writes for an episode that has a text, or that they have
verified.
"""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Candidate:
    """A text that waits for verifiers.

    Attributes:
        text_id, episode_id: the text, and its episode.
        author: id of the worker who wrote it; None if it was imported.
        verifiers: ids of the workers whose verification counts, or is open.
    """

    text_id: str
    episode_id: str
    author: str | None
    verifiers: frozenset[str]


@dataclass(frozen=True, slots=True)
class Known:
    """Ids of the episodes that a worker knows: those written for, and those verified, golds included."""

    written: frozenset[str] = frozenset()
    verified: frozenset[str] = frozenset()

    @property
    def episodes(self) -> frozenset[str]:
        """All of them."""
        return self.written | self.verified


def next_to_write(episodes: Iterable[str], taken: Collection[str], known: Known) -> str | None:
    """Return the first episode that a worker may write for; None if there is none.

    Args:
        episodes: ids of the collection's episodes, in order.
        taken: ids of those that have a text or are being written for.
        known: the worker's.
    """
    return next((one for one in episodes if one not in taken and one not in known.episodes), None)


def next_to_verify(texts: Sequence[Candidate], worker_id: str, known: Known, needed: int) -> Candidate | None:
    """Return the text that a worker verifies next: the one with the most verifiers, so that texts are settled soon.

    Args:
        texts: the texts that wait for verifiers, oldest first.
        worker_id: the worker.
        known: the worker's.
        needed: number of verifiers of each text.

    Returns:
        The text; None if there is none.
    """
    allowed = [
        text
        for text in texts
        if text.author != worker_id and text.episode_id not in known.episodes and len(text.verifiers) < needed
    ]
    return max(allowed, key=lambda text: len(text.verifiers), default=None)


def wants_gold(verified: int, golds: int, share: float, draw: float) -> bool:
    """Return whether a worker's next verification is one of a known episode.

    The chance is such that the share is kept, and no worker can tell when one comes.

    Args:
        verified: number of verifications that the worker has begun, golds included.
        golds: number of golds among them.
        share: share of golds, from 0 to 1.
        draw: random number in [0, 1).
    """
    behind = share * (verified + 1) - golds
    return draw < min(max(behind, 0.25 * share), 2.0 * share)


def next_gold(episodes: Sequence[str], known: Known, draw: float) -> str | None:
    """Return a known episode that a worker has not seen, drawn at random; None if there is none."""
    unseen = [one for one in episodes if one not in known.episodes]
    return unseen[int(draw * len(unseen))] if unseen else None
