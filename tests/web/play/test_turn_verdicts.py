"""What came of an object, as a person is told."""

import pytest

from arramon_server.scoring.episode_scores import score_turn
from arramon_server.scoring.trajectory import TurnRecord
from arramon_server.sim.catalogue import ObjectType
from arramon_server.web.play.turn_verdicts import Picked, Put, turn_verdict

MUG, TV = ObjectType("striped", "red", "mug"), ObjectType("dotted", "blue", "tv")


def record(
    x: float = 1.0, *, target: bool = True, cell: tuple[int, int, int] | None = (2, 1, 2), limit: bool = False
) -> TurnRecord:
    """A turn that ended x units from its target, and placed the object in a cell."""
    return TurnRecord(
        ((0.0, 0.0), (1.0, 0.0)),
        (0.0, 0.1, 0.0),
        (2, 1, 2),
        path=((0.0, 0.0),),
        navigation_ended=True,
        final_position=(x, 0.525, 0.0),
        picked_target=target,
        placed_cell=cell,
        placement_forced=limit,
    )


@pytest.mark.parametrize(
    ("turn", "carried", "forced", "picked", "put", "is_right"),
    [
        (record(), MUG, False, Picked.RIGHT, Put.RIGHT, True),
        (record(cell=(2, 2, 2)), MUG, False, Picked.RIGHT, Put.ONE_OFF, False),
        (record(cell=(4, 1, 2)), MUG, False, Picked.RIGHT, Put.ELSEWHERE, False),
        (record(limit=True), MUG, False, Picked.RIGHT, Put.NOTHING, False),
        (record(cell=None), MUG, False, Picked.RIGHT, Put.NOTHING, False),
        (record(3.0), MUG, False, Picked.TOO_FAR, Put.RIGHT, False),
        (record(target=False), MUG, False, Picked.LOOK_ALIKE, Put.RIGHT, False),
        (record(9.0, target=False), TV, False, Picked.OTHER, Put.RIGHT, False),
        (record(), MUG, True, Picked.LIMIT_RIGHT, Put.RIGHT, True),
        (record(9.0), MUG, True, Picked.LIMIT_TOO_FAR, Put.RIGHT, False),
        (record(9.0, target=False), TV, True, Picked.LIMIT_OTHER, Put.RIGHT, False),
        (TurnRecord(((0.0, 0.0),), (0.0, 0.1, 0.0), (2, 1, 2)), None, False, Picked.NOTHING, Put.NOTHING, False),
    ],
)
def test_verdicts(
    turn: TurnRecord, carried: ObjectType | None, *, forced: bool, picked: Picked, put: Put, is_right: bool
) -> None:
    verdict = turn_verdict(score_turn(turn), MUG, carried, forced=forced)
    assert (verdict.picked, verdict.put, verdict.is_right) == (picked, put, is_right)


@pytest.mark.parametrize(
    ("turn", "put"),
    [(record(cell=None), Put.GIVEN_UP), (record(), Put.RIGHT), (record(cell=(4, 1, 2)), Put.ELSEWHERE)],
)
def test_who_gave_up_was_not_too_late(turn: TurnRecord, put: Put) -> None:
    assert turn_verdict(score_turn(turn), MUG, MUG, forced=False, gave_up=True).put is put
