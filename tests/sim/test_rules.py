"""The rules, on literal situations and on random play, without pybullet."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arramon_client.world import Action
from arramon_server.sim.catalogue import ALL_TYPES, ObjectType
from arramon_server.sim.geometry import Point, Pose
from arramon_server.sim.room import START, RoomCell, RoomPosition
from arramon_server.sim.rules import (
    Blocked,
    Collectible,
    EpisodeLayout,
    Limits,
    Moved,
    Phase,
    PhaseEnded,
    PickedUp,
    Placed,
    PlacedObject,
    State,
    begin,
    height_at,
    reachable,
    step,
    time_out,
)

F, L, R, P = Action.FORWARD, Action.LEFT, Action.RIGHT, Action.INTERACT
MUG = ObjectType("striped", "red", "mug")
TV = ObjectType("dotted", "blue", "tv")
BALL = ObjectType("dotted", "green", "ball")


class Fence:
    """Ground on which nothing with z above 2.5 can be reached."""

    def way_is_free(self, start: tuple[float, float], end: tuple[float, float]) -> bool:
        return max(start[1], end[1]) < 2.5


def item(kind: ObjectType, x: float, z: float) -> Collectible:
    return Collectible(kind, Point(x, 0.1, z))


LAYOUT = EpisodeLayout(
    start=Pose(0.0, 0.0, 0.0),
    streets=((item(MUG, 0.2, 2.0), item(TV, 5.0, 5.0)), (item(BALL, 0.0, 3.0),)),
    decoys=(PlacedObject(TV, RoomPosition(1, 1, 1)),),
)


def play(actions: list[Action], layout: EpisodeLayout = LAYOUT, limit: int = 150) -> tuple[State, list[object]]:
    state = begin(layout)
    happened: list[object] = []
    for action in actions:
        state, events = step(state, action, layout, Fence(), Limits(limit))
        happened.extend(events)
    return state, happened


def test_forward_moves_one_unit_along_the_heading() -> None:
    state, events = play([R, F])
    assert (state.pose.x, state.pose.z) == pytest.approx((0.5, 3**0.5 / 2))
    assert state.pose.heading == 30.0
    assert events == [Moved()]


def test_a_blocked_step_does_not_move_and_still_counts() -> None:
    state, events = play([F, F, F])
    assert state.pose == Pose(0.0, 2.0, 0.0)
    assert (state.step, state.phase_step) == (3, 3)
    assert events == [Moved(), Moved(), Blocked()]


def test_twelve_turns_are_a_full_circle() -> None:
    assert play([L] * 12)[0].pose == LAYOUT.start
    assert play([L])[0].pose.heading == 330.0


@pytest.mark.parametrize(
    ("right", "ahead", "reached"),
    [
        (0.0, 3.0, True),
        (0.5, 1.0, True),
        (-0.5, 1.0, True),
        (0.535, 1.9, True),  # the farthest to the side that a ground truth of the release picks up
        (0.6, 1.0, False),
        (-0.6, 1.0, False),
        (0.0, 3.1, False),
        (0.0, -0.1, False),
    ],
)
def test_pick_up_reaches_only_objects_inside_the_box(right: float, ahead: float, reached: bool) -> None:
    pose = Pose(3.0, -2.0, 90.0)  # facing +x: ahead is +x, to the right is -z
    assert (reachable(pose, [item(MUG, 3.0 + ahead, -2.0 - right)]) == 0) is reached


def test_the_nearest_of_several_objects_is_taken() -> None:
    street = [item(MUG, 0.0, 2.5), item(TV, 0.3, 1.0), item(BALL, 0.0, 1.5)]
    assert reachable(Pose(0.0, 0.0, 0.0), street) == 1


def test_pick_up_starts_the_assembly_with_the_object() -> None:
    state, events = play([P])
    assert events == [PickedUp(0), PhaseEnded(1, Phase.NAVIGATION, forced=False)]
    assert (state.phase, state.carried, state.square, state.phase_step) == (Phase.ASSEMBLY, MUG, START, 0)


def test_pick_up_with_nothing_in_reach_only_counts_a_step() -> None:
    state, events = play([R, R, R, P])
    assert events == []
    assert (state.phase, state.step) == (Phase.NAVIGATION, 4)


def test_a_distracter_can_be_picked_up() -> None:
    layout = replace(LAYOUT, streets=((item(MUG, 9.0, 9.0), item(TV, 0.0, 1.0)), LAYOUT.streets[1]))
    state, events = play([P], layout)
    assert PickedUp(1) in events
    assert state.carried == TV


@pytest.mark.parametrize(
    ("actions", "placement"),
    [
        ([P], RoomPosition(2, 1, 1)),
        ([F, P], RoomPosition(2, 1, 2)),
        ([R, R, R, P], RoomPosition(3, 1, 0)),
        ([F, L, L, L, P], RoomPosition(1, 2, 1)),  # on top of the decoy
    ],
)
def test_place_puts_the_object_one_cell_ahead(actions: list[Action], placement: RoomPosition) -> None:
    state, events = play([P, *actions])
    assert events[-2:] == [Placed(placement), PhaseEnded(1, Phase.ASSEMBLY, forced=False)]
    assert state.room[-1] == PlacedObject(MUG, placement)
    assert (state.turn, state.phase, state.carried) == (2, Phase.NAVIGATION, None)


@pytest.mark.parametrize(
    "actions",
    [
        [R, P],  # off the quarter turns
        [R, R, R, R, R, R, P],  # towards the wall behind the start
        [R, F],  # moving off the quarter turns
        [L, L, L, F, F, F],  # two cells to the left is the wall: the third step is blocked
    ],
)
def test_impossible_actions_in_the_room_only_count_a_step(actions: list[Action]) -> None:
    before, _ = play([P, *actions[:-1]])
    after, _ = play([P, *actions])
    assert after == replace(before, step=before.step + 1, phase_step=before.phase_step + 1)


def test_objects_in_the_room_do_not_block_the_agent() -> None:
    state, events = play([P, F, L, L, L, F])
    assert (state.square, events[-1]) == (RoomCell(1, 1), Moved())


def test_turn_two_starts_where_turn_one_ended() -> None:
    state, _ = play([F, R, L, P, P])
    assert (state.turn, state.pose) == (2, Pose(0.0, 1.0, 0.0))


def test_second_object_can_be_placed_on_the_first() -> None:
    state, _ = play([P, P, F, P, P])
    assert state.finished
    assert [o.placement for o in state.room[-2:]] == [RoomPosition(2, 1, 1), RoomPosition(2, 2, 1)]


def test_stepping_a_finished_episode_is_an_error() -> None:
    state, _ = play([P, P, F, P, P])
    with pytest.raises(ValueError, match="finished"):
        step(state, F, LAYOUT, Fence(), Limits())


def test_step_limit_forces_pick_up_of_the_nearest_object() -> None:
    state, events = play([R, R, R], limit=3)
    assert events == [PickedUp(0), PhaseEnded(1, Phase.NAVIGATION, forced=True)]
    assert (state.phase, state.phase_step) == (Phase.ASSEMBLY, 0)


def test_the_step_that_reaches_the_limit_still_acts() -> None:
    _, events = play([R, L, P], limit=3)
    assert events == [PickedUp(0), PhaseEnded(1, Phase.NAVIGATION, forced=False)]


@pytest.mark.parametrize(
    ("actions", "placement"),
    [
        ([L, R], RoomPosition(2, 1, 1)),  # one cell ahead
        ([L, L], RoomPosition(2, 1, 0)),  # oblique: at the agent's feet
        ([F, F], RoomPosition(2, 1, 3)),
        ([F, R], RoomPosition(2, 1, 1)),
    ],
)
def test_step_limit_forces_placement_of_the_object(actions: list[Action], placement: RoomPosition) -> None:
    _, events = play([R, P, *actions], limit=2)
    assert events[-2:] == [Placed(placement), PhaseEnded(1, Phase.ASSEMBLY, forced=True)]


def test_forced_placement_facing_a_wall_uses_the_agents_cell() -> None:
    _, events = play([P, R, R, R, R, R, R], limit=6)
    assert Placed(RoomPosition(2, 1, 0)) in events


LAYOUTS = st.builds(
    lambda xs, decoys: EpisodeLayout(
        Pose(0.0, 0.0, 28.8),
        (tuple(item(t, x, z) for t, x, z in xs), tuple(item(t, z, x) for t, x, z in xs)),
        tuple(PlacedObject(ALL_TYPES[i], RoomPosition(c, 1, r)) for i, (c, r) in enumerate(decoys)),
    ),
    st.lists(st.tuples(st.sampled_from(ALL_TYPES), st.floats(-5, 5), st.floats(-5, 5)), min_size=1, max_size=4),
    st.sets(st.tuples(st.integers(0, 4), st.integers(0, 3)).filter(lambda c: c != (2, 0)), max_size=8),
)


@settings(max_examples=60, deadline=None)
@given(layout=LAYOUTS, actions=st.lists(st.sampled_from(Action), max_size=60), limit=st.integers(1, 12))
def test_random_play_keeps_the_invariants(layout: EpisodeLayout, actions: list[Action], limit: int) -> None:
    state = begin(layout)
    for action in actions:
        if state.finished:
            break
        before = state
        state, _ = step(state, action, layout, Fence(), Limits(limit))
        assert state.step == before.step + 1
        assert state.phase_step < limit or state.finished
        assert state.square.is_inside()
        assert (state.carried is not None) == (state.phase is Phase.ASSEMBLY and not state.finished)
        for placed in state.room:
            square = RoomCell(placed.placement.column, placed.placement.row)
            assert square.is_inside()
            assert placed.placement.level <= height_at(state.room, square)


@settings(max_examples=20, deadline=None)
@given(layout=LAYOUTS, seed=st.integers(0, 10_000))
def test_step_limits_always_finish_an_episode(layout: EpisodeLayout, seed: int) -> None:
    state = begin(layout)
    for number in range(4 * 5):
        if not state.finished:
            state, _ = step(state, Action((seed * 7 + number * number) % 3), layout, Fence(), Limits(5))
    assert state.finished


def test_timeout_ends_all_remaining_phases() -> None:
    state, events = time_out(play([F])[0], LAYOUT)
    assert events == (
        PickedUp(0),
        PhaseEnded(1, Phase.NAVIGATION, forced=True),
        Placed(RoomPosition(2, 1, 1)),
        PhaseEnded(1, Phase.ASSEMBLY, forced=True),
        PickedUp(0),
        PhaseEnded(2, Phase.NAVIGATION, forced=True),
        Placed(RoomPosition(2, 2, 1)),
        PhaseEnded(2, Phase.ASSEMBLY, forced=True),
    )
    assert state.finished
    assert (state.step, state.pose) == (1, Pose(0.0, 1.0, 0.0))
    with pytest.raises(ValueError, match="the episode is finished; its time cannot run out"):
        time_out(state, LAYOUT)


def test_timeout_in_the_room_places_the_carried_object() -> None:
    state, events = time_out(play([P, F, R])[0], LAYOUT)  # oblique: onto the agent's own cell
    assert events[:2] == (Placed(RoomPosition(2, 1, 1)), PhaseEnded(1, Phase.ASSEMBLY, forced=True))
    assert [event.turn for event in events if isinstance(event, PhaseEnded)] == [1, 2, 2]
    assert state.step == 3


@given(st.lists(st.sampled_from(Action), max_size=30))
def test_timeout_finishes_any_episode_without_moving_the_agent(actions: list[Action]) -> None:
    state, ended = begin(LAYOUT), 0
    for action in actions:
        if not state.finished:
            state, events = step(state, action, LAYOUT, Fence(), Limits())
            ended += sum(isinstance(event, PhaseEnded) for event in events)
    if not state.finished:
        after, events = time_out(state, LAYOUT)
        assert after.finished
        assert (after.step, after.pose) == (state.step, state.pose)
        assert len(after.room) == len(LAYOUT.decoys) + 2
        forced = [event.forced for event in events if isinstance(event, PhaseEnded)]
        assert forced == [True] * (4 - ended)
