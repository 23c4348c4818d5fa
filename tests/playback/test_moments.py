"""Moments of recorded episodes: as they were played, what the rules answered, what stands out."""

import pytest

from arramon_client.world import Action
from arramon_server.episodes.episode import Episode
from arramon_server.playback.moments import MomentMark, Playback
from arramon_server.playback.outcomes import outcomes_of
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.scoring.turn_outcomes import TurnOutcome
from arramon_server.sim.city import city_scene
from arramon_server.sim.footprints import Footprints
from arramon_server.sim.rules import Blocked, Limits, Moved, PhaseEnded, PickedUp, Placed
from tests import tiny
from tests.tiny import F, L, P, R

GROUND = Footprints(city_scene(tiny.SECTION))
LIMITS = Limits(30)


def playback(*actions: Action, episode: Episode | None = None, limits: Limits = LIMITS) -> Playback:
    made = Playback(episode or tiny.episode("0"), GROUND, limits)
    made.extend(actions)
    return made


def marks(*actions: Action, limits: Limits = LIMITS) -> list[tuple[int, MomentMark]]:
    found = playback(*actions, limits=limits).moments
    return [(step, mark) for step, moment in enumerate(found) for mark in moment.marks]


def test_moments_are_those_of_the_session_that_was_scored() -> None:
    session = EpisodeSession(tiny.episode("0"), GROUND, LIMITS)
    played = list(session.replay(tiny.ACTIONS))
    found = playback(*tiny.ACTIONS).moments
    assert [(one.state, one.action) for one in found[:-1]] == played
    assert (found[-1].state, found[-1].action, found[-1].events) == (session.state, None, ())
    scores = session.scores().turns
    assert [found[4].ndtw, found[-1].ndtw] == pytest.approx([turn["nDTW"] for turn in scores], abs=1e-12)


def test_answers_of_the_rules() -> None:
    found = playback(*tiny.ACTIONS).moments
    assert [one.events for one in found[:5]] == [
        (Moved(),),
        (Moved(),),
        (PickedUp(0), PhaseEnded(1, found[2].state.phase, forced=False)),
        (Moved(),),
        (Placed(tiny.episode("0").turns[0].target_cell), PhaseEnded(1, found[3].state.phase, forced=False)),
    ]
    assert found[2].distance == pytest.approx((1.5**2 + 0.425**2) ** 0.5)
    assert [one.distance for one in found[3:5]] == [2.0, 1.0]  # cells


def test_an_episode_that_grows_has_the_moments_of_one_that_is_read_at_once() -> None:
    growing = playback()
    for count, action in enumerate(tiny.ACTIONS):
        assert growing.moments == playback(*tiny.ACTIONS[:count]).moments
        growing.extend([action])
    assert growing.moments == playback(*tiny.ACTIONS).moments
    assert growing.steps == len(tiny.ACTIONS)
    assert growing.is_finished
    with pytest.raises(IndexError, match="no step 14; expected 0 to 13"):
        growing.moment(14)


@pytest.mark.parametrize(
    ("actions", "expected"),
    [
        (tiny.ACTIONS[:5], [(2, MomentMark.PICKED_UP), (4, MomentMark.PLACED)]),
        ((P, L), []),
        ((F,) * 12, [(6, MomentMark.LEFT), (10, MomentMark.BLOCKED), (11, MomentMark.BLOCKED)]),
        (
            (L, L, L, F, F, F, F, R, R, R, R, R, R, F),
            [(7, MomentMark.LEFT), (13, MomentMark.ABOUT), (14, MomentMark.BACK)],
        ),
        ((L, F, R, R, R, R, R, F), [(7, MomentMark.ABOUT)]),
        ((F, L, L, L, F), []),
    ],
)
def test_marks(actions: tuple[Action, ...], expected: list[tuple[int, MomentMark]]) -> None:
    assert marks(*actions) == expected


def test_limits_are_marked() -> None:
    assert marks(L, L, limits=Limits(2)) == [(1, MomentMark.PICKED_UP), (1, MomentMark.FORCED)]
    ended = playback(F)
    ended.end_at_time_limit()
    assert ended.moments[-1].marks == (MomentMark.PICKED_UP, MomentMark.FORCED, MomentMark.PLACED)
    assert (ended.moments[-1].action, ended.steps) == (None, 1)


def test_walls_answer_blocked() -> None:
    assert playback(*(F,) * 12).moments[10].events == (Blocked(),)


@pytest.mark.parametrize(
    ("actions", "timed_out", "expected"),
    [
        (tiny.ACTIONS, False, (TurnOutcome.SOLVED, TurnOutcome.SOLVED)),
        (tiny.ACTIONS[:3], False, (TurnOutcome.NOT_PLACED, TurnOutcome.NOT_PLAYED)),
        ((), False, (TurnOutcome.NOT_PLAYED, TurnOutcome.NOT_PLAYED)),
        ((F, F, P, P), False, (TurnOutcome.ONE_CELL_OFF, TurnOutcome.NOT_PLAYED)),
        ((F, F), True, (TurnOutcome.NOT_PLACED, TurnOutcome.PASSED_TARGET)),
    ],
)
def test_outcomes(actions: tuple[Action, ...], timed_out: bool, expected: tuple[TurnOutcome, TurnOutcome]) -> None:
    assert outcomes_of(tiny.episode("0"), GROUND, LIMITS, actions, timed_out=timed_out) == expected
