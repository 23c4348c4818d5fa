"""One open episode: its state and what was recorded of it. A cache of the journal, which can always rebuild it."""

from collections.abc import Iterable, Iterator

from server.episodes.episode import Episode
from server.runs.recorder import Recorder
from server.scoring.episode import EpisodeScores, score_episode
from server.scoring.trajectory import EpisodeRecord
from server.sim import rules
from server.sim.rules import Action, Ground, Limits, PhaseEnded, State


class Session:
    """An episode as far as it was played.

    Args:
        episode: what is played.
        ground: of its section.
        limits: of its run.
        epoch: of the claim under which it is open.

    Attributes:
        state: where it stands.
        actions: all that were applied, in order.
    """

    def __init__(self, episode: Episode, ground: Ground, limits: Limits, epoch: int = 0) -> None:
        self.episode = episode
        self.limits = limits
        self.epoch = epoch
        self.state: State = rules.begin(episode.layout)
        self.actions: list[Action] = []
        self._ground = ground
        self._layout = episode.layout
        self._recorder = Recorder(episode)

    def apply(self, action: Action) -> list[PhaseEnded]:
        """One step; returns the phases that ended with it.

        Raises:
            ValueError: if the episode is finished.
        """
        self.state, events = rules.step(self.state, action, self._layout, self._ground, self.limits)
        self.actions.append(action)
        self._recorder.record(self.state, events)
        return [event for event in events if isinstance(event, PhaseEnded)]

    def run_out(self) -> list[PhaseEnded]:
        """The time is up: every phase that is left ends as at the step limit, and none of it counts as a step.

        The journal keeps no action for it: an episode that ended by TIME_LIMIT is its recorded actions, and then this.

        Raises:
            ValueError: if the episode is finished.
        """
        self.state, events = rules.time_out(self.state, self._layout)
        self._recorder.record(self.state, events)
        return [event for event in events if isinstance(event, PhaseEnded)]

    def replay(self, actions: Iterable[int]) -> Iterator[tuple[State, Action]]:
        """Applies recorded actions, one with each turn of the iterator: gives the state before, and the action."""
        for number in actions:
            before, action = self.state, Action(number)
            self.apply(action)
            yield before, action

    def steps_left(self, state: State) -> int:
        """In the phase of a state, the present one or one before it."""
        return self.limits.steps_per_phase - state.phase_step

    @property
    def was_forced(self) -> bool:
        """Whether the step limit or a clock ended any phase."""
        return self._recorder.forced

    def record(self) -> EpisodeRecord:
        """What was recorded so far."""
        return self._recorder.result()

    def scores(self) -> EpisodeScores:
        """What it is worth as it stands."""
        return score_episode(self.record())
