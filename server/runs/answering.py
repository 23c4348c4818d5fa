"""What a stream's acts do: each is applied to its episode in memory, goes into a batch, and gives what to tell."""

from server.runs import causes
from server.runs.events import EpisodeEnded, Event, Observed, PhaseOver, Problem
from server.runs.journal import Journal
from server.runs.records import Batch, Ending, Run
from server.runs.session import Session
from server.runs.stream import Act, Stream
from server.sim.rules import Action


class Answering:
    """Applies acts. What it says is to be told after the batch is committed.

    Args:
        journal: counts what has ended.
    """

    def __init__(self, journal: Journal) -> None:
        self._journal = journal

    def answer(self, stream: Stream, act: Act, batch: Batch) -> list[Event]:
        """Applies one act in memory; what it writes goes into the batch."""
        session = stream.sessions.get(act.episode_id)
        if session is None:
            ended = stream.ended.get(act.episode_id)
            return [ended] if ended else [_problem(act, "NOT_YOUR_EPISODE", "this stream has no such open episode")]
        if act.forfeit is not None:
            return [self.end(stream, session, batch, causes.FORFEITED, act.forfeit[:500])]
        if act.action is None or not 0 <= act.action < len(Action):
            given = "none" if act.action is None else act.action
            return [_problem(act, "BAD_ACTION", f"the action is {given}, expected 0, 1, 2 or 3")]
        step = session.state.step
        if act.step > step:
            return [_problem(act, "STEP_AHEAD", f"step {act.step} is ahead of its turn, expected {step}")]
        if act.step < step:
            first = session.actions[act.step]
            again = observed(stream, session)
            if first == act.action:
                return [again]
            return [_problem(act, "STEP_BEHIND", f"step {act.step} was answered with {first:d}; that stands"), again]
        phases = session.apply(Action(act.action))
        batch.add_step(stream.run.run_id, act.episode_id, session.epoch, act.step, act.action)
        events: list[Event] = [PhaseOver(act.episode_id, phase) for phase in phases]
        if not session.state.finished:
            return [*events, observed(stream, session)]
        cause = causes.STEP_LIMIT if session.was_forced else causes.AGENT_FINISHED
        return [*events, self.end(stream, session, batch, cause)]

    def end(self, stream: Stream, session: Session, batch: Batch, cause: str, note: str = "") -> EpisodeEnded:
        """Ends an episode of a stream."""
        run_id, episode_id = stream.run.run_id, session.episode.episode_id
        batch.endings.append(ending(stream.run, session, cause, note))
        in_batch = sum(ending.run_id == run_id for ending in batch.endings)
        ended = EpisodeEnded(episode_id, cause, self._journal.count_ended(run_id) + in_batch)
        stream.ended[episode_id] = ended
        del stream.sessions[episode_id]
        return ended


def observed(stream: Stream, session: Session) -> Observed:
    """What the agent is told of where an episode stands; its frame is drawn later."""
    return Observed(stream.run, session.episode, session.state, session.steps_left(session.state))


def ending(run: Run, session: Session, cause: str, note: str = "") -> Ending:
    """The end of an episode as it stands."""
    scores = [dict(turn) for turn in session.scores().turns]
    return Ending(run.run_id, session.episode.episode_id, cause, session.state.step, scores, note, session.epoch)


def _problem(act: Act, code: str, message: str) -> Problem:
    return Problem(code, f"episode {act.episode_id!r}: {message}", act.episode_id, act.step)
