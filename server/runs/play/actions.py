"""Handler of agents' actions: checks each one, applies it to its episode, and adds it to the journal's commit batch."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from arramon_client.world import Action
from arramon_server.errors import MAX_QUOTE_LENGTH, quoted
from arramon_server.runs.play.events import ActionProblem, EpisodeEnded, Event, Observed, PhaseFinished
from arramon_server.runs.play.faults import EpisodeFault, fault_boundary
from arramon_server.runs.play.notes import NoteTaker
from arramon_server.runs.play.session import EpisodeSession, ending_of
from arramon_server.runs.play.stream import MAX_BATCH, Act, Stream
from arramon_server.runs.play.timekeeper import Timekeeper
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import Claim, CommitBatch


@dataclass(slots=True)
class ActionResults:
    """Result of applying a stream's actions, valid once the batch is committed.

    Attributes:
        events: events to deliver to the stream.
        faulty: claims of the episodes on which the server itself failed.
    """

    events: list[Event] = field(default_factory=list)
    faulty: list[Claim] = field(default_factory=list)


class ActionHandler:
    """Applies actions in memory, and collects the resulting journal rows in a batch.

    Args:
        journal: counts the episodes that have ended.
        time: enforces the clocks.
        notes: checks the notes that come with actions.
    """

    def __init__(self, journal: Journal, time: Timekeeper, notes: NoteTaker) -> None:
        self._journal = journal
        self._time = time
        self._notes = notes

    def handle(self, stream: Stream, batch: CommitBatch) -> ActionResults:
        """Apply a stream's waiting messages, oldest first, each as of its time of arrival.

        They share one commit, and their observations are drawn in one batch, so that many small messages cost no more
        than a large one. The first message is always applied, whatever its length.
        """
        results, acts = ActionResults(), 0
        while stream.inbox and (not acts or acts + len(stream.inbox[0].acts) <= MAX_BATCH):
            message = stream.next_actions()
            acts += len(message.acts) or 1
            self._check_clocks(stream, message.at, batch, results)
            for act in message.acts:
                _collect(results, partial(self._apply, stream, act, message.at, batch))
        return results

    def check_clocks(self, stream: Stream, at: float, batch: CommitBatch) -> ActionResults:
        """Charge a stream for its overdue steps as of a time, and end its episodes that are out of time."""
        results = ActionResults()
        self._check_clocks(stream, at, batch, results)
        return results

    def _check_clocks(self, stream: Stream, at: float, batch: CommitBatch, results: ActionResults) -> None:
        for session in [stream.sessions[episode_id] for episode_id in self._time.check(stream, at, batch)]:
            _collect(results, partial(self._end_out_of_time, stream, session, batch))

    def _apply(self, stream: Stream, act: Act, at: float, batch: CommitBatch) -> list[Event]:
        """Check an action as the protocol requires, and apply it as of its time of arrival."""
        session = stream.sessions.get(act.episode_id)
        if session is None:
            if act.episode_id in stream.ended:
                return []  # A late answer: the client already got the end of the episode.
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
            again = observation_of(stream, session)
            if first == act.action:
                return [again]
            return [
                _problem(act, "STEP_BEHIND", f"step {act.step} was answered with {first:d}; the first answer counts"),
                again,
            ]
        with fault_boundary(stream.run, stream.claim(session), "playing"):
            phases = session.apply(Action(act.action))
        session.thinking.answer(act.step, at)
        batch.add_step(stream.run.run_id, act.episode_id, session.fence, act.step, act.action)
        if stream.clock is not None:
            stream.clock.answer(act.episode_id, act.step)
        events: list[Event] = [PhaseFinished(act.episode_id, phase) for phase in phases]
        if act.note and (refusal := self._notes.add(batch, stream.run.run_id, act.episode_id, act.step, act.note)):
            events.insert(0, _problem(act, "NOTE_REFUSED", f"the action was taken, but its note not stored: {refusal}"))
        if not session.state.finished:
            return [*events, observation_of(stream, session)]
        return [*events, self._end(stream, session, batch, session.cause)]

    def _end_out_of_time(self, stream: Stream, session: EpisodeSession, batch: CommitBatch) -> list[Event]:
        """End an episode that is out of time."""
        with fault_boundary(stream.run, stream.claim(session), "ending"):
            phases = session.end_at_time_limit()
        over = [PhaseFinished(session.episode.episode_id, phase) for phase in phases]
        return [*over, self._end(stream, session, batch, causes.TIME_LIMIT)]

    def _end(
        self, stream: Stream, session: EpisodeSession, batch: CommitBatch, cause: str, note: str = ""
    ) -> EpisodeEnded:
        """Score an episode as far as it was played, and remove it from its stream."""
        run_id, episode_id = stream.run.run_id, session.episode.episode_id
        with fault_boundary(stream.run, stream.claim(session), "scoring"):
            batch.endings.append(ending_of(stream.run, session, cause, note))
        in_batch = sum(ending.run_id == run_id for ending in batch.endings)
        ended = EpisodeEnded(episode_id, cause, self._journal.count_ended(run_id) + in_batch)
        stream.note_end(episode_id)
        stream.drop(episode_id)
        return ended


def observation_of(stream: Stream, session: EpisodeSession) -> Observed:
    """Return the observation of an episode's current state; its frame is drawn when it is delivered."""
    left = None if stream.clock is None else stream.clock.time_left(session.episode.episode_id)
    world = stream.worlds[session.episode.episode_id]
    steps_left = session.steps_left(session.state)
    return Observed(stream.run, session.episode, world, session.state, steps_left, time_left=left)


def _collect(results: ActionResults, function: Callable[[], list[Event]]) -> None:
    """Add the events that a function returns, or the claim of the episode on which it fails."""
    try:
        results.events += function()
    except EpisodeFault as fault:
        results.faulty.append(fault.claim)


def _problem(act: Act, code: str, message: str) -> ActionProblem:
    text = f"episode {quoted(act.episode_id)}: {message}"
    return ActionProblem(code, text, act.episode_id[:MAX_QUOTE_LENGTH], act.step)
