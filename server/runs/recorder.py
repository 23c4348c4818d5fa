"""From rules to scores: what happened in an episode, written down as the record that scoring reads."""

from dataclasses import dataclass, field, replace

from server.episodes.episode import Episode
from server.scoring.trajectory import EpisodeRecord, TurnRecord
from server.sim.geometry import EYE_HEIGHT
from server.sim.rules import Event, Moved, Phase, PhaseEnded, PickedUp, Placed, State


@dataclass
class Recorder:
    """Collects one episode's trajectory, step by step."""

    episode: Episode
    _turns: list[TurnRecord] = field(init=False)
    forced: bool = field(default=False, init=False)
    """Whether the step limit or a clock has ended any phase."""

    def __post_init__(self) -> None:
        self._turns = [TurnRecord(turn.path, turn.target.position, turn.target_cell) for turn in self.episode.turns]
        self._visit(0, self.episode.start.x, self.episode.start.z)

    def record(self, after: State, events: tuple[Event, ...]) -> None:
        """Writes down what a step did, or the end of the time, and the state that it left."""
        picked: PickedUp | None = None
        placed: Placed | None = None
        for event in events:
            match event:
                case Moved() if after.phase is Phase.NAVIGATION:
                    self._visit(after.turn - 1, after.pose.x, after.pose.z)
                case PickedUp():
                    picked = event
                case Placed():
                    placed = event
                case PhaseEnded(turn, phase, forced):
                    self.forced |= forced
                    self._end(turn - 1, phase, forced, after, picked, placed)

    def result(self) -> EpisodeRecord:
        """The record as it stands; phases that have not ended count as not played."""
        return EpisodeRecord(self.episode.episode_id, self.episode.section, (self._turns[0], self._turns[1]))

    def _visit(self, turn: int, x: float, z: float) -> None:
        self._turns[turn] = replace(self._turns[turn], path=(*self._turns[turn].path, (x, z)))

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
                self._visit(turn + 1, after.pose.x, after.pose.z)
