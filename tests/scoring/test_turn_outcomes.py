"""Outcomes of turns, from how far the path followed the reference to the cell of the object."""

from dataclasses import replace

import pytest

from arramon_server.scoring.trajectory import TurnRecord
from arramon_server.scoring.turn_outcomes import PathOutcome, TurnOutcome, followed_share, path_outcome, turn_outcome

REFERENCE = tuple((0.0, float(z)) for z in range(21))
SOLVED = TurnRecord(
    reference_path=REFERENCE,
    target_position=(0.0, 0.5, 22.0),
    target_cell=(2, 1, 2),
    path=REFERENCE,
    navigation_ended=True,
    final_position=(0.0, 0.525, 20.0),
    picked_target=True,
    placed_cell=(2, 1, 2),
)
FAR = (0.0, 0.525, 10.0)


@pytest.mark.parametrize(
    ("path", "share", "outcome"),
    [
        (REFERENCE, 1.0, PathOutcome.REACHED_END),
        (REFERENCE[:11], 0.6, PathOutcome.LEFT_ON_THE_WAY),
        (((0.0, 0.0), (0.0, -5.0)), 0.1, PathOutcome.LEFT_AT_START),
        (((-6.0, -8.0),), 0.0, PathOutcome.BEGAN_ELSEWHERE),
    ],
)
def test_paths(path: tuple[tuple[float, float], ...], share: float, outcome: PathOutcome) -> None:
    assert followed_share(path, REFERENCE) == pytest.approx(share)
    assert path_outcome(path, REFERENCE) is outcome


@pytest.mark.parametrize(
    ("changed", "alike", "outcome"),
    [
        ({}, True, TurnOutcome.SOLVED),
        ({"navigation_ended": False, "path": ()}, False, TurnOutcome.NOT_PLAYED),
        ({"final_position": FAR, "path": ((9.0, 9.0),)}, False, TurnOutcome.BEGAN_ELSEWHERE),
        ({"final_position": FAR, "path": REFERENCE[:2]}, False, TurnOutcome.LEFT_AT_START),
        ({"final_position": FAR, "path": REFERENCE[:11]}, False, TurnOutcome.LEFT_ON_THE_WAY),
        ({"final_position": FAR}, True, TurnOutcome.PASSED_TARGET),
        ({"picked_target": False}, True, TurnOutcome.LOOK_ALIKE),
        ({"picked_target": False}, False, TurnOutcome.OTHER_OBJECT),
        ({"picked_target": False, "pickup_forced": True}, False, TurnOutcome.NOT_TAKEN),
        ({"placed_cell": None}, True, TurnOutcome.NOT_PLACED),
        ({"placement_forced": True}, True, TurnOutcome.NOT_PLACED),
        ({"placed_cell": (2, 2, 2)}, True, TurnOutcome.ONE_CELL_OFF),
        ({"placed_cell": (1, 1, 2)}, True, TurnOutcome.ONE_CELL_OFF),
        ({"placed_cell": (1, 1, 3)}, True, TurnOutcome.OTHER_CELL),
    ],
)
def test_turns(changed: dict[str, object], alike: bool, outcome: TurnOutcome) -> None:
    assert turn_outcome(replace(SOLVED, **changed), took_look_alike=alike) is outcome  # type: ignore[arg-type]
