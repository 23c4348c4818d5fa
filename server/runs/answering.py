"""What a stream's acts do: each is applied to its episode in memory, goes into a batch, and gives what to tell."""

from collections.abc import Callable
from functools import partial

from server.runs import causes
from server.runs.endings import ending
from server.runs.events import EpisodeEnded, Event, Observed, PhaseOver, Problem
from server.runs.faults import EpisodeFault, contained
from server.runs.journal import Journal
from server.runs.records import Batch, Claim
from server.runs.session import Session
from server.runs.stream import Act, Stream
from server.runs.timekeeping import Timekeeper
from server.sim.rules import Action


class Answering:
    """Applies acts. What it says is to be told after the batch is committed.

    Args:
        journal: counts what has ended.
        time: holds streams to their clocks.

    Attributes:
        faulty: episodes over which the server broke down, to be taken from their streams after the commit.
    """

    def __init__(self, journal: Journal, time: Timekeeper) -> None:
        self.faulty: list[tuple[Stream, Claim]] = []
        self._journal = journal
        self._time = time

    def answers(self, stream: Stream, batch: Batch) -> list[Event]:
        """Applies the acts that a stream sent first, as of the time at which they came in."""
        asked = stream.take()
        events = self.timed(stream, asked.at, batch)
        for act in asked.acts:
            events += self._tried(stream, partial(self._answer, stream, act, batch))
        return events

    def timed(self, stream: Stream, at: float, batch: Batch) -> list[Event]:
        """Charges what a stream is overdue at a time, and ends its episodes that are then out of time."""
        out = [stream.sessions[episode_id] for episode_id in self._time.check(stream, at, batch)]
        return [
            event for session in out for event in self._tried(stream, partial(self._run_out, stream, session, batch))
        ]

    def _tried(self, stream: Stream, function: Callable[[], list[Event]]) -> list[Event]:
        try:
            return function()
        except EpisodeFault as fault:
            self.faulty.append((stream, fault.claim))
            return []

    def _answer(self, stream: Stream, act: Act, batch: Batch) -> list[Event]:
        """Applies one act in memory; what it writes goes into the batch."""
        session = stream.sessions.get(act.episode_id)
        if session is None:
            ended = stream.ended.get(act.episode_id)
            return [ended] if ended else [_problem(act, "NOT_YOUR_EPISODE", "this stream has no such open episode")]
        if act.forfeit is not None:
            return [self._end(stream, session, batch, causes.FORFEITED, act.forfeit[:500])]
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
        with contained(stream.run, stream.claim(session), "playing"):
            phases = session.apply(Action(act.action))
        batch.add_step(stream.run.run_id, act.episode_id, session.epoch, act.step, act.action)
        if stream.clock is not None:
            stream.clock.answer(act.episode_id, act.step)
        events: list[Event] = [PhaseOver(act.episode_id, phase) for phase in phases]
        if not session.state.finished:
            return [*events, observed(stream, session)]
        cause = causes.STEP_LIMIT if session.was_forced else causes.AGENT_FINISHED
        return [*events, self._end(stream, session, batch, cause)]

    def _run_out(self, stream: Stream, session: Session, batch: Batch) -> list[Event]:
        """Ends an episode whose time is up."""
        with contained(stream.run, stream.claim(session), "ending"):
            phases = session.run_out()
        over = [PhaseOver(session.episode.episode_id, phase) for phase in phases]
        return [*over, self._end(stream, session, batch, causes.TIME_LIMIT)]

    def _end(self, stream: Stream, session: Session, batch: Batch, cause: str, note: str = "") -> EpisodeEnded:
        run_id, episode_id = stream.run.run_id, session.episode.episode_id
        with contained(stream.run, stream.claim(session), "scoring"):
            batch.endings.append(ending(stream.run, session, cause, note))
        in_batch = sum(ending.run_id == run_id for ending in batch.endings)
        ended = EpisodeEnded(episode_id, cause, self._journal.count_ended(run_id) + in_batch)
        stream.ended[episode_id] = ended
        stream.drop(episode_id)
        return ended


def observed(stream: Stream, session: Session) -> Observed:
    """What the agent is told of where an episode stands; its frame is drawn later."""
    left = None if stream.clock is None else stream.clock.time_left(session.episode.episode_id)
    return Observed(stream.run, session.episode, session.state, session.steps_left(session.state), time_left=left)


def _problem(act: Act, code: str, message: str) -> Problem:
    return Problem(code, f"episode {act.episode_id!r}: {message}", act.episode_id, act.step)
