"""Validation of generated episodes: the ground truth can be replayed, and objects cannot be confused."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from arramon_client.world import AGENT_RADIUS
from arramon_dataset.generation.draft import Draft
from arramon_dataset.generation.navigation_tasks import TWINS_APART
from arramon_dataset.layout.solids import Solids
from arramon_dataset.release.missing_objects import DECOYS
from arramon_server.episodes.episode import Episode, Turn
from arramon_server.sim import rules
from arramon_server.sim.catalogue import EXTENT
from arramon_server.sim.room import START, RoomCell
from arramon_server.sim.rules import (
    Blocked,
    CollisionCheck,
    Event,
    Limits,
    Moved,
    Phase,
    PhaseEnded,
    PickedUp,
    Placed,
    State,
)

PATH_TOLERANCE = 1e-5
"""Maximum distance between the stored path and the replayed positions, in units."""

MIN_SEPARATION = 0.5
"""Minimum distance between the centres of two objects in one street, in units."""


def faults_of_episode(episode: Draft | Episode, solids: Solids, ground: CollisionCheck) -> tuple[str, ...]:
    """Return descriptions of everything wrong with an episode; empty if it is valid.

    The ground truth is replayed with the rules and must match its paths, objects and cells. Nothing may lie or start
    inside a solid. No two objects of a street, or of the room on entry, may look the same, except one street object
    that looks like the target and is at least `TWINS_APART` away from it.

    Args:
        episode: with or without instructions; they are not checked.
        solids: of the episode's section.
        ground: of the episode's section: `GenerationSite.physics`, the authoritative collision check.
    """
    return (*_street_problems(episode, solids), *_room_problems(episode), *_replay_problems(episode, ground))


def _street_problems(episode: Draft | Episode, solids: Solids) -> Iterator[str]:
    if solids.distance(np.array([[episode.start.x, episode.start.z]]))[0] < AGENT_RADIUS:
        yield "the start is not on free ground"
    for number, turn in enumerate(episode.turns, start=1):
        places = np.array([(item.position.x, item.position.z) for item in turn.street])
        for item, distance in zip(turn.street, solids.distance(places), strict=True):
            if distance < EXTENT:
                yield f"turn {number}: the {item.type} lies inside something solid"
        for one, other in combinations(turn.street, 2):
            apart = np.hypot(one.position.x - other.position.x, one.position.z - other.position.z)
            if one.type == other.type and (one != turn.target or apart < TWINS_APART):
                yield f"turn {number}: two objects are a {one.type}"
            if apart < MIN_SEPARATION:
                yield f"turn {number}: the {one.type} and the {other.type} are too close to each other"


def _room_problems(episode: Draft | Episode) -> Iterator[str]:
    first, second = episode.turns
    cells = [RoomCell(decoy.placement.column, decoy.placement.row) for decoy in episode.decoys]
    types = [decoy.type for decoy in episode.decoys] + [turn.target.type for turn in episode.turns]
    if len(cells) != DECOYS:
        yield f"there are {len(cells)} decoys, expected {DECOYS}"
    if len(set(cells)) < len(cells) or any(decoy.placement.level != 1 for decoy in episode.decoys):
        yield "the decoys are not on the floor, each in a cell of its own"
    if len(set(types)) < len(types):
        yield "two of the decoys and the targets look the same"
    if START in cells or not all(cell.is_inside() for cell in cells):
        yield "a decoy is on the start tile or outside the room"
    stands = {RoomCell(turn.target_cell.column, turn.target_cell.row) for turn in (first, second)}
    for number, turn in enumerate(episode.turns, start=1):
        if (set(turn.room_path) - stands) & set(cells):
            yield f"turn {number}: a decoy blocks the path of the assembly"


def _replay_problems(episode: Draft | Episode, ground: CollisionCheck) -> Iterator[str]:
    state = rules.begin(episode.layout)
    for number, turn in enumerate(episode.turns, start=1):
        for phase, actions in ((Phase.NAVIGATION, turn.actions), (Phase.ASSEMBLY, turn.room_actions)):
            where = f"turn {number}, {phase.value}"
            walked = [_place(state)]
            events: list[Event] = []
            for action in actions:
                if state.finished or (state.turn, state.phase) != (number, phase):
                    yield f"{where}: ended before the ground truth's last action"
                    return
                state, happened = rules.step(state, action, episode.layout, ground, Limits())
                events += happened
                if Blocked() in happened:
                    yield f"{where}: blocked at step {state.phase_step}"
                    return
                walked += [_place(state)] * (Moved() in happened)
            ended = PhaseEnded(number, phase, forced=False)
            if not events or events[-1] != ended:
                yield f"{where}: not ended by the ground truth's last action"
                return
            done = PickedUp(0) if phase is Phase.NAVIGATION else Placed(turn.target_cell)
            if done not in events:
                yield f"{where}: does not end with {_aim(turn, phase)}"
            path = np.array(turn.path if phase is Phase.NAVIGATION else turn.room_path, dtype=float)
            if path.shape != (len(walked), 2) or np.abs(path - np.array(walked)).max() > PATH_TOLERANCE:
                yield f"{where}: the actions do not follow the path"
    if not state.finished:
        yield "the ground truth does not finish the episode"


def _place(state: State) -> tuple[float, float]:
    at = state.pose if state.phase is Phase.NAVIGATION else None
    return (at.x, at.z) if at is not None else (float(state.square.column), float(state.square.row))


def _aim(turn: Turn, phase: Phase) -> str:
    if phase is Phase.NAVIGATION:
        return f"the {turn.target.type} picked up"
    return f"the object on column, level and row {tuple(turn.target_cell)}"
