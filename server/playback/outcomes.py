"""Outcomes of the turns of recorded episodes: what failed first, by `arramon_server.scoring.turn_outcomes`."""

from collections.abc import Iterable

from arramon_client.world import Action
from arramon_server.episodes.episode import Episode
from arramon_server.runs.play.session import TrajectoryRecorder
from arramon_server.scoring.turn_outcomes import TurnOutcome, turn_outcome
from arramon_server.sim import rules
from arramon_server.sim.rules import CollisionCheck, Limits, PickedUp


def outcomes_of(
    episode: Episode, collisions: CollisionCheck, limits: Limits, actions: Iterable[int], *, timed_out: bool = False
) -> tuple[TurnOutcome, TurnOutcome]:
    """Return the outcomes of both turns of a recorded episode.

    Args:
        episode: the episode.
        collisions: collision check of its scene.
        limits: limits of its run.
        actions: its recorded actions.
        timed_out: whether the time limit ended it.
    """
    recorder, layout = TrajectoryRecorder(episode), episode.layout
    state = rules.begin(layout)
    alike = [False, False]

    def note(turn: int, events: Iterable[rules.Event]) -> None:
        for event in events:
            if isinstance(event, PickedUp):
                street = episode.turns[turn - 1].street
                alike[turn - 1] = street[event.index].type == street[0].type

    for number in actions:
        turn = state.turn
        state, events = rules.step(state, Action(number), layout, collisions, limits)
        recorder.record(state, events)
        note(turn, events)
    if timed_out and not state.finished:
        recorder.record(*rules.time_out(state, layout))
    first, second = recorder.result().turns
    return turn_outcome(first, took_look_alike=alike[0]), turn_outcome(second, took_look_alike=alike[1])
