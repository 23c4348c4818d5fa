"""Play digests: equal for runs with the same actions, independent of player, server and time."""

import hashlib
from collections.abc import Callable, Iterable, Sequence

from arramon_server.runs.storage.records import EpisodeEnding, Run


def play_digest(run: Run, endings: Iterable[EpisodeEnding], actions_of: Callable[[str, str], Sequence[int]]) -> str:
    """Return the SHA-256 of everything besides its split that determines a run's scores, in hexadecimal.

    That is the step limit, and for each episode the recorded actions and the cause of its end. The digest depends
    neither on the run's id nor on the order of its episodes, nor on the scores themselves: figures of hidden splits
    are rounded by it (see `arramon_server.scoring.masking`), and must not show whether two plays scored alike.

    Args:
        run: run that has ended.
        endings: endings of all its episodes.
        actions_of: returns the actions of a run's episode, given the ids of both.
    """
    digest = hashlib.sha256(f"arramon play 1\n{run.steps_per_phase}\n".encode())
    for ending in sorted(endings, key=lambda ending: ending.episode_id):
        actions = "".join(map(str, actions_of(run.run_id, ending.episode_id)))
        digest.update(f"{(ending.episode_id, ending.cause, actions)!r}\n".encode())
    return digest.hexdigest()
