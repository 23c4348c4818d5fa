"""The hash chain over a run's actions: how a receipt names what was played. Server and clients compute the same.

A field is a text in UTF-8 with its length in bytes before it, as four bytes, the highest first.
"""

import hashlib
from collections.abc import Iterable, Sequence

_EPISODE, _RUN, _ENDING = "arramon.v1 episode", "arramon.v1 run", "arramon.v1 ending"


def episode_head(run_id: str, episode_id: str, data_hash: str, actions: Iterable[int]) -> bytes:
    """The head of an episode's chain, 32 bytes.

    h(0) is SHA-256 over the fields "arramon.v1 episode", run id, episode id and data hash; h(n + 1) is SHA-256 over
    h(n), the step's number n as four bytes, the highest first, and the action as one byte.

    Args:
        run_id, episode_id: of what was played.
        data_hash: of the split, in hexadecimal.
        actions: in order, from step 0; each 0 to 3.
    """
    head = _first(run_id, episode_id, data_hash)
    for step, action in enumerate(actions):
        head = _following(head, step, action)
    return head


def steps_to(head: bytes, run_id: str, episode_id: str, data_hash: str, actions: Iterable[int]) -> int | None:
    """The number of steps after which the chain over some actions has a given head; None if it never has.

    Args:
        head: 32 bytes.
        run_id, episode_id, data_hash, actions: as for `episode_head`; actions after the head are ignored.
    """
    reached = _first(run_id, episode_id, data_hash)
    if reached == head:
        return 0
    for step, action in enumerate(actions):
        reached = _following(reached, step, action)
        if reached == head:
            return step + 1
    return None


def episode_ending(run_id: str, episode_id: str, cause: str, actions: Sequence[int]) -> bytes:
    """What commits to an episode's cause, 32 bytes, and tells it to those alone who know the actions.

    SHA-256 over the fields "arramon.v1 ending", run id, episode id and cause, and then each action as one byte.

    Args:
        run_id, episode_id: of what was played.
        cause: of the episode's end, such as "AGENT_FINISHED".
        actions: in order, from step 0; each 0 to 3.
    """
    fields = b"".join(map(_field, (_ENDING, run_id, episode_id, cause)))
    return hashlib.sha256(fields + bytes(actions)).digest()


def run_digest(run_id: str, heads: Iterable[tuple[str, bytes]]) -> bytes:
    """What stands for all actions of a run, 32 bytes.

    SHA-256 over the fields "arramon.v1 run" and run id, and then of each episode its id as a field and its head.

    Args:
        run_id: the run's.
        heads: id and head of each episode, in playing order.
    """
    digest = hashlib.sha256(_field(_RUN) + _field(run_id))
    for episode_id, head in heads:
        digest.update(_field(episode_id) + head)
    return digest.digest()


def _first(run_id: str, episode_id: str, data_hash: str) -> bytes:
    return hashlib.sha256(b"".join(map(_field, (_EPISODE, run_id, episode_id, data_hash)))).digest()


def _following(head: bytes, step: int, action: int) -> bytes:
    return hashlib.sha256(head + step.to_bytes(4, "big") + bytes((action,))).digest()


def _field(text: str) -> bytes:
    encoded = text.encode()
    return len(encoded).to_bytes(4, "big") + encoded
