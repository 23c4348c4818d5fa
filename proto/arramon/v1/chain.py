"""The hash chain over a run's actions, with which a receipt commits to them; the same on server and client.

A field is a text in UTF-8, preceded by its length in bytes as a big-endian number of four bytes.
"""

import hashlib
from collections.abc import Iterable, Sequence

_EPISODE, _RUN, _ENDING = "arramon.v1 episode", "arramon.v1 run", "arramon.v1 ending"


def episode_head(run_id: str, episode_id: str, data_hash: str, actions: Iterable[int]) -> bytes:
    """Return the head of an episode's chain, 32 bytes.

    h(0) is SHA-256 over the fields "arramon.v1 episode", run id, episode id and data hash; h(n + 1) is SHA-256 over
    h(n), the step number n as a big-endian number of four bytes, and the action as one byte.

    Args:
        run_id, episode_id: ids of the run and the episode.
        data_hash: hash of the split's data, in hexadecimal.
        actions: actions in order, from step 0; each 0 to 3.
    """
    head = _first(run_id, episode_id, data_hash)
    for step, action in enumerate(actions):
        head = _following(head, step, action)
    return head


def steps_to(head: bytes, run_id: str, episode_id: str, data_hash: str, actions: Iterable[int]) -> int | None:
    """Return the number of steps after which the chain over the actions has a given head; None if it never has.

    Args:
        head: head of the chain, 32 bytes.
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
    """Return a commitment to the cause of an episode's end, 32 bytes, which only those who know the actions can check.

    SHA-256 over the fields "arramon.v1 ending", run id, episode id and cause, and then each action as one byte.

    Args:
        run_id, episode_id: ids of the run and the episode.
        cause: cause of the episode's end, for example "AGENT_FINISHED".
        actions: actions in order, from step 0; each 0 to 3.
    """
    fields = b"".join(map(_field, (_ENDING, run_id, episode_id, cause)))
    return hashlib.sha256(fields + bytes(actions)).digest()


def run_digest(run_id: str, heads: Iterable[tuple[str, bytes]]) -> bytes:
    """Return the digest over all actions of a run, 32 bytes.

    SHA-256 over the fields "arramon.v1 run" and run id, and then for each episode its id as a field and its head.

    Args:
        run_id: id of the run.
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
