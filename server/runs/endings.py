"""How an episode of a run ends, as the journal is to keep it."""

from server.episodes.episode import Episode
from server.runs.recorder import Recorder
from server.runs.records import Claim, Ending, Run
from server.runs.session import Session
from server.scoring.episode import score_episode


def ending(run: Run, session: Session, cause: str, note: str = "") -> Ending:
    """The end of an episode as it stands."""
    scores = [dict(turn) for turn in session.scores().turns]
    return Ending(run.run_id, session.episode.episode_id, cause, session.state.step, scores, note, session.epoch)


def unplayed(run: Run, episode: Episode, claim: Claim, cause: str, note: str = "") -> Ending:
    """The end of an episode of which nothing was played, or nothing can be counted: it scores zero."""
    scores = [dict(turn) for turn in score_episode(Recorder(episode).result()).turns]
    return Ending(run.run_id, claim.episode_id, cause, 0, scores, note, claim.epoch)
