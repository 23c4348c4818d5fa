"""Handling of an agent's actions: each is checked, applied to its session and added to the batch for the journal."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from arramon_client.world import Action
from arramon_server.errors import MAX_QUOTE_LENGTH, quoted
from arramon_server.runs.play.events import EpisodeEnded, Event, Observed, PhaseOver, Problem
from arramon_server.runs.play.faults import EpisodeFault, contained
from arramon_server.runs.play.session import Session, ending
from arramon_server.runs.play.stream import MAX_TOGETHER, Act, Stream
from arramon_server.runs.play.timekeeper import Timekeeper
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import Batch, Claim


@dataclass(slots=True)
class Answers:
    """What follows from a stream's actions, valid once the batch is committed.

    Attributes:
        events: to be delivered to the stream.
        faulty: claims of the episodes on which the server itself failed.
    """

    events: list[Event] = field(default_factory=list)
    faulty: list[Claim] = field(default_factory=list)


class ActionHandler:
    """Applies actions in memory, and collects in a batch what the journal has to keep.

    Args:
        journal: counts the episodes that have ended.
        time: enforces the clocks.
    """

    def __init__(self, journal: Journal, time: Timekeeper) -> None:
        self._journal = journal
        self._time = time

    def handle(self, stream: Stream, batch: Batch) -> Answers:
        """Apply the messages of a stream that wait, oldest first, each as of the time at which it arrived.

        All of them share one commit and their observations are drawn together, so that a client that answers in many
        small messages costs no more for it. The first one is applied whatever its length.
        """
        answers, acts = Answers(), 0
        while stream.asked and (not acts or acts + len(stream.asked[0].acts) <= MAX_TOGETHER):
            asked = stream.take()
            acts += len(asked.acts) or 1
            self._check_clocks(stream, asked.at, batch, answers)
            for act in asked.acts:
                _collect(answers, partial(self._apply, stream, act, asked.at, batch))
        return answers

    def check_clocks(self, stream: Stream, at: float, batch: Batch) -> Answers:
        """Charge a stream for overdue steps at a time, and end its episodes that are out of time."""
        answers = Answers()
        self._check_clocks(stream, at, batch, answers)
        return answers

    def _check_clocks(self, stream: Stream, at: float, batch: Batch, answers: Answers) -> None:
        for session in [stream.sessions[episode_id] for episode_id in self._time.check(stream, at, batch)]:
            _collect(answers, partial(self._run_out, stream, session, batch))

    def _apply(self, stream: Stream, act: Act, at: float, batch: Batch) -> list[Event]:
        """Apply one action that arrived at a time, after the checks that the protocol asks for."""
        session = stream.sessions.get(act.episode_id)
        if session is None:
            if act.episode_id in stream.ended:
                return []  # A late answer; the stream was told once that the episode has ended.
            return [_problem(act, "NOT_YOUR_EPISODE", "this stream has no such open episode")]
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
        session.thinking.answer(act.step, at)
        batch.add_step(stream.run.run_id, act.episode_id, session.epoch, act.step, act.action)
        if stream.clock is not None:
            stream.clock.answer(act.episode_id, act.step)
        events: list[Event] = [PhaseOver(act.episode_id, phase) for phase in phases]
        if not session.state.finished:
            return [*events, observed(stream, session)]
        return [*events, self._end(stream, session, batch, session.cause)]

    def _run_out(self, stream: Stream, session: Session, batch: Batch) -> list[Event]:
        """End an episode that is out of time."""
        with contained(stream.run, stream.claim(session), "ending"):
            phases = session.run_out()
        over = [PhaseOver(session.episode.episode_id, phase) for phase in phases]
        return [*over, self._end(stream, session, batch, causes.TIME_LIMIT)]

    def _end(self, stream: Stream, session: Session, batch: Batch, cause: str, note: str = "") -> EpisodeEnded:
        """Score an episode as it stands, and take it from its stream."""
        run_id, episode_id = stream.run.run_id, session.episode.episode_id
        with contained(stream.run, stream.claim(session), "scoring"):
            batch.endings.append(ending(stream.run, session, cause, note))
        in_batch = sum(ending.run_id == run_id for ending in batch.endings)
        ended = EpisodeEnded(episode_id, cause, self._journal.count_ended(run_id) + in_batch)
        stream.ended.add(episode_id)
        stream.drop(episode_id)
        return ended


def observed(stream: Stream, session: Session) -> Observed:
    """Return the observation of a session's present state; its frame is drawn when it is delivered."""
    left = None if stream.clock is None else stream.clock.time_left(session.episode.episode_id)
    return Observed(stream.run, session.episode, session.state, session.steps_left(session.state), time_left=left)


def _collect(answers: Answers, function: Callable[[], list[Event]]) -> None:
    """Add what a function returns, or the episode on which it failed."""
    try:
        answers.events += function()
    except EpisodeFault as fault:
        answers.faulty.append(fault.claim)


def _problem(act: Act, code: str, message: str) -> Problem:
    text = f"episode {quoted(act.episode_id)}: {message}"
    return Problem(code, text, act.episode_id[:MAX_QUOTE_LENGTH], act.step)
