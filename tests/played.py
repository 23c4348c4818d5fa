"""Runs played without a server, by the server's own session and journal."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime

from arramon_client.world import Action
from arramon_server.episodes.splits import Split
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.worlds import Worlds
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import COMPLETE, RUNNING, CommitBatch, EpisodeEnding, Run
from arramon_server.sim.rules import Limits
from tests import tiny

STEPS = 8
"""The step limit: enough for `tiny.ACTIONS`."""

BEGUN = datetime(2026, 1, 2, 3, 4, 5, 678901, tzinfo=UTC)


def play(
    database: Database,
    split: Split,
    run_id: str = "r",
    actions: Mapping[str, Sequence[int]] | None = None,
    *,
    account: str | None = None,
    ended: Mapping[str, str] | None = None,
    over: bool = True,
) -> Run:
    """A run in the journal.

    Args:
        actions: by episode; by default the ground truth of every episode with instructions in English.
        account: whose it is.
        ended: by episode the cause with which it was cut short, where the actions do not finish it.
        over: whether the run is.
    """
    actions = dict.fromkeys(split.episodes, tiny.ACTIONS) if actions is None else actions
    journal, worlds = Journal(database), Worlds({split.name: split})
    run = Run(
        run_id, account or "lab", "walker", split.name, "en", ("rgb",), STEPS, split.data_hash, "0.1.0", RUNNING, BEGUN,
        account=account,
    )  # fmt: skip
    journal.create(run, list(actions))
    for claim in journal.claim(run_id, journal.pending(run_id), "player", "worker"):
        episode = split.episodes[claim.episode_id]
        session = EpisodeSession(episode, worlds.world(split.name, episode), Limits(STEPS))
        batch = CommitBatch()
        for step, action in enumerate(actions[claim.episode_id]):
            session.apply(Action(action))
            batch.add_step(run_id, claim.episode_id, claim.fence, step, action)
        cause = (ended or {}).get(claim.episode_id)
        if session.state.finished:
            cause = causes.STEP_LIMIT if session.was_forced else causes.AGENT_FINISHED
        elif cause == causes.TIME_LIMIT:
            session.end_at_time_limit()
        if cause is not None:
            scores = [dict(turn) for turn in session.scores().turns]
            taken = len(actions[claim.episode_id])
            batch.endings.append(EpisodeEnding(run_id, claim.episode_id, cause, taken, scores, "", claim.fence))
        journal.commit(batch)
    worlds.close()
    if over:
        journal.set_state(run_id, COMPLETE)
    return journal.run(run_id)
