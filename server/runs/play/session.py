"""The state and recorded trajectory of one open episode, which can always be rebuilt from the journal."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

from arramon_client.world import EYE_HEIGHT, Action
from arramon_server.episodes.episode import Episode
from arramon_server.runs.play.response_times import ResponseTimes
from arramon_server.runs.storage.causes import AGENT_FINISHED, SERVER_FAULT, STEP_LIMIT
from arramon_server.runs.storage.records import Claim, EpisodeEnding, Run
from arramon_server.scoring.episode_scores import METRICS, EpisodeScores, score_episode
from arramon_server.scoring.trajectory import EpisodeRecord, Point2, TurnRecord
from arramon_server.sim import rules
from arramon_server.sim.rules import CollisionCheck, Event, Limits, Moved, Phase, PhaseEnded, PickedUp, Placed, State


class EpisodeSession:
    """An episode in play: its current state, actions and trajectory.

    Args:
        episode: the episode.
        collisions: collision check of its scene.
        limits: limits of its run.
        fence: fence of the claim under which it is open.

    Attributes:
        state: the current state.
        actions: all actions applied so far, in order.
        thinking: time that the agent takes for its answers, as far as this process saw it.
    """

    def __init__(self, episode: Episode, collisions: CollisionCheck, limits: Limits, fence: int = 0) -> None:
        self.episode = episode
        self.limits = limits
        self.fence = fence
        self.state: State = rules.begin(episode.layout)
        self.actions: list[Action] = []
        self.thinking = ResponseTimes()
        self._collisions = collisions
        self._layout = episode.layout
        self._recorder = TrajectoryRecorder(episode)

    def apply(self, action: Action) -> list[PhaseEnded]:
        """Apply one action, and return the phases that ended with it.

        Raises:
            ValueError: if the episode is finished.
        """
        self.state, events = rules.step(self.state, action, self._layout, self._collisions, self.limits)
        self.actions.append(action)
        self._recorder.record(self.state, events)
        return [event for event in events if isinstance(event, PhaseEnded)]

    def end_at_time_limit(self) -> list[PhaseEnded]:
        """End all remaining phases as at the step limit, because the time limit was reached, and return them.

        It counts no step and records no action: to replay an episode with the cause TIME_LIMIT, apply its recorded
        actions, then call this.

        Raises:
            ValueError: if the episode is finished.
        """
        self.state, events = rules.time_out(self.state, self._layout)
        self._recorder.record(self.state, events)
        return [event for event in events if isinstance(event, PhaseEnded)]

    def replay(self, actions: Iterable[int]) -> Iterator[tuple[State, Action]]:
        """Apply recorded actions, and yield each with the state before it."""
        for number in actions:
            before, action = self.state, Action(number)
            self.apply(action)
            yield before, action

    def steps_left(self, state: State) -> int:
        """Return the steps left in the phase of a state, current or earlier."""
        return self.limits.steps_per_phase - state.phase_step

    @property
    def was_forced(self) -> bool:
        """Whether the step limit or a time limit ended any phase."""
        return self._recorder.forced

    @property
    def cause(self) -> str:
        """The cause of the end, for an episode that was played to its end."""
        return STEP_LIMIT if self.was_forced else AGENT_FINISHED

    def record(self) -> EpisodeRecord:
        """Return the trajectory so far."""
        return self._recorder.result()

    def scores(self) -> EpisodeScores:
        """Return the scores of the trajectory so far."""
        return score_episode(self.record())


def ending_of(run: Run, session: EpisodeSession, cause: str, note: str = "") -> EpisodeEnding:
    """Return the end of an episode, scored as far as it was played."""
    scores = [dict(turn) for turn in session.scores().turns]
    thinking = session.thinking
    return EpisodeEnding(
        run.run_id,
        session.episode.episode_id,
        cause,
        session.state.step,
        scores,
        note,
        session.fence,
        thinking.seconds,
        thinking.steps,
    )


def unplayed_ending(run: Run, episode: Episode, claim: Claim, cause: str, note: str = "") -> EpisodeEnding:
    """Return the end, with zero scores, of an episode that was not played, or whose steps cannot count."""
    scores = [dict(turn) for turn in score_episode(TrajectoryRecorder(episode).result()).turns]
    return EpisodeEnding(run.run_id, claim.episode_id, cause, 0, scores, note, claim.fence)


def lost_ending(run: Run, claim: Claim, note: str) -> EpisodeEnding:
    """Return the end, with zero scores, of an episode whose data is missing: a server fault."""
    scores = [dict.fromkeys(METRICS, 0.0) for _ in range(2)]
    return EpisodeEnding(
        run.run_id, claim.episode_id, SERVER_FAULT, 0, scores, f"{note}; its data was gone", claim.fence
    )


@dataclass
class TrajectoryRecorder:
    """Records the trajectory of an episode step by step, as the input of `arramon_server.scoring`."""

    episode: Episode
    _turns: list[TurnRecord] = field(init=False)
    """Both turns, without the paths."""
    _paths: tuple[list[Point2], list[Point2]] = field(init=False)
    forced: bool = field(default=False, init=False)
    """Whether the step limit or a clock has ended any phase."""

    def __post_init__(self) -> None:
        self._turns = [TurnRecord(turn.path, turn.target.position, turn.target_cell) for turn in self.episode.turns]
        self._paths = [(self.episode.start.x, self.episode.start.z)], []

    def record(self, after: State, events: tuple[Event, ...]) -> None:
        """Record the events of a step or of the time limit, and the state after it."""
        picked: PickedUp | None = None
        placed: Placed | None = None
        for event in events:
            match event:
                case Moved() if after.phase is Phase.NAVIGATION:
                    self._paths[after.turn - 1].append((after.pose.x, after.pose.z))
                case PickedUp():
                    picked = event
                case Placed():
                    placed = event
                case PhaseEnded(turn, phase, forced):
                    self.forced |= forced
                    self._end(turn - 1, phase, forced, after, picked, placed)

    def result(self) -> EpisodeRecord:
        """Return the record so far; a phase that has not ended counts as not played."""
        first, second = (replace(turn, path=tuple(path)) for turn, path in zip(self._turns, self._paths, strict=True))
        return EpisodeRecord(self.episode.episode_id, self.episode.section, (first, second))

    def _end(
        self, turn: int, phase: Phase, forced: bool, after: State, picked: PickedUp | None, placed: Placed | None
    ) -> None:
        record = self._turns[turn]
        if phase is Phase.NAVIGATION and picked is not None:
            self._turns[turn] = replace(
                record,
                navigation_ended=True,
                final_position=(after.pose.x, EYE_HEIGHT, after.pose.z),
                picked_target=picked.index == 0,
                pickup_forced=forced,
            )
        elif placed is not None:
            self._turns[turn] = replace(record, placed_cell=placed.placement, placement_forced=forced)
            if turn + 1 < len(self._turns):
                self._paths[turn + 1].append((after.pose.x, after.pose.z))
