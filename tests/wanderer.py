"""A program that generates three episodes, plays them, and prints digests: `python -m tests.wanderer DIR [plane]`.

With `plane` pybullet cannot be imported. Where it can, it checks the collisions.
"""

import hashlib
import json
import sys
from contextlib import closing
from dataclasses import astuple
from pathlib import Path

RUN = "0" * 32
"""Id of the run, which the hash chains begin with."""


def main(data: Path) -> None:
    from arramon.v1.chain import episode_head, run_digest
    from arramon_client.world import Action
    from arramon_dataset.instruction_writer import generate_splits
    from arramon_server.runs.play.session import EpisodeSession
    from arramon_server.runs.play.worlds import Worlds
    from arramon_server.sim.rules import Limits

    (split,) = generate_splits(data, ["val_unseen"], scale=3 / 1155, seed=1, jobs=1, write_line=lambda _: None)
    heads, scores, places, blocked = [], [], hashlib.sha256(), 0
    with closing(Worlds({split.name: split})) as worlds:
        for episode in split.episodes.values():
            session, step = EpisodeSession(episode, worlds.world(split.name, episode), Limits(60)), 0
            while not session.state.finished:
                # Ahead while that is possible, otherwise a turn to a side that changes now and then.
                before = session.state
                session.apply(Action.FORWARD)
                if session.state.pose == before.pose and not session.state.finished:
                    blocked += 1
                    session.apply(Action.LEFT if step // 25 % 2 else Action.RIGHT)
                places.update(json.dumps(astuple(session.state), default=lambda phase: phase.value).encode())
                step += 1
            heads.append((episode.episode_id, episode_head(RUN, episode.episode_id, split.data_hash, session.actions)))
            scores.append([dict(turn) for turn in session.scores().turns])
    found = {
        "pybullet": "pybullet" in sys.modules and sys.modules["pybullet"] is not None,
        "data": split.data_hash,
        "digest": run_digest(RUN, heads).hex(),
        "places": places.hexdigest(),
        "scores": hashlib.sha256(json.dumps(scores).encode()).hexdigest(),
        "blocked": blocked,
    }
    sys.stdout.write(json.dumps(found) + "\n")


if __name__ == "__main__":
    if sys.argv[2:] == ["plane"]:
        sys.modules["pybullet"] = None  # type: ignore[assignment]
    main(Path(sys.argv[1]))
