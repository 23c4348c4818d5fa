"""What the play page is told of a state: what every agent gets, and what the run's aids add."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from arramon_client.world import Action
from arramon_server.runs.play.events import Observed
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.room import RoomCell
from arramon_server.sim.rules import Phase, State, reachable
from arramon_server.web.named_things import object_name, thing_name
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.play.aids import Aids
from arramon_server.web.play.obstacles import find_obstacle
from arramon_server.web.play.outcomes import Outcome, relative_heading
from arramon_server.web.play.scene_words import visible_things

NameOf = Callable[[ObjectType], str]
"""Returns an object's name in the run's language."""


def person_state(
    event: Observed,
    aids: Aids,
    actions: Sequence[Action],
    outcome: str,
    *,
    texts: PageTexts,
    is_hidden: bool,
) -> dict[str, Any]:
    """Return the message that describes a state.

    Args:
        event: the observation of the state.
        aids: aids of the run.
        actions: all actions of the episode so far.
        outcome: what the last action did.
        texts: texts in the run's language.
        is_hidden: whether the split is hidden: then no collectible is named.
    """
    state, episode = event.state, event.episode
    # A hidden split tells no agent what it picked up, either.
    name_of = _no_name if is_hidden else partial(object_name, texts)
    message: dict[str, Any] = {
        "type": "state",
        "episode": episode.episode_id,
        "step": state.step,
        "turn": state.turn,
        "phase": state.phase.value,
        "instruction": episode.instruction(event.run.language, state.turn, state.phase.value),
        "phase_step": state.phase_step,
        "steps_left": event.steps_left,
        "carries": state.carried is not None,
        "carried": "" if state.carried is None else name_of(state.carried),
        "outcome": outcome,
    }
    if outcome in (Outcome.BLOCKED.value, Outcome.CANNOT_PLACE.value):
        message["why"] = _why_not(event, texts, is_hidden=is_hidden)
    if event.time_left is not None:
        message["seconds_left"] = round(event.time_left.step_seconds, 1)
        message["bank_left"] = round(event.time_left.bank_seconds, 1)
    if aids.compass:
        message["heading"] = relative_heading(actions, state.phase_step)
    if aids.landing_diagram and state.phase is Phase.ASSEMBLY:
        message["landing"] = _landing(state)
    if aids.ahead:
        message["ahead"] = cell_ahead(state, name_of) if state.phase is Phase.ASSEMBLY else _in_reach(event, name_of)
    if aids.scene_words and event.frame is not None and event.frame.segmentation is not None:
        message["scene"] = [
            {"side": thing.side, "name": name, "steps": thing.steps}
            for thing in visible_things(event.frame, is_room=state.phase is Phase.ASSEMBLY)
            if (name := thing_name(texts, thing.label))
        ]
    return message


def _no_name(_type: ObjectType) -> str:
    return ""


def _why_not(event: Observed, texts: PageTexts, *, is_hidden: bool) -> dict[str, str]:
    """Return what kept a person from stepping or placing.

    In the room the reason, which an agent knows from its turns. In the street the thing in the way and its side, unless
    the split is hidden: its agents have no segmentation, which names things.
    """
    state = event.state
    if state.phase is Phase.ASSEMBLY:
        return {"reason": "oblique" if state.room_heading % 90.0 else "wall"}
    found = None if is_hidden else find_obstacle(event.world.scene.bodies, state.pose)
    name = "" if found is None else thing_name(texts, found.label)
    return {"reason": "thing", "side": found.side, "name": name} if found is not None and name else {"reason": "street"}


def _in_reach(event: Observed, name_of: NameOf) -> dict[str, Any]:
    """Return whether a pick-up would take something, and its name."""
    street = event.episode.layout.streets[event.state.turn - 1]
    index = reachable(event.state.pose, street)
    return {"in_reach": index is not None, "object": "" if index is None else name_of(street[index].type)}


def cell_ahead(state: State, name_of: NameOf) -> dict[str, Any]:
    """Return the cell ahead in the room with the objects on it, bottom up; None with the reason if there is none."""
    if state.room_heading % 90.0:
        return {"cell": None, "why": "oblique"}
    cell = state.square.ahead(state.room_heading)
    if not cell.is_inside():
        return {"cell": None, "why": "wall"}
    there = [item for item in state.room if (item.placement.column, item.placement.row) == cell]
    there.sort(key=lambda item: item.placement.level)
    return {"cell": list(cell), "objects": [name_of(item.type) for item in there]}


def _landing(state: State) -> dict[str, Any]:
    """Return the person's cell and heading in the room, and the cell in which the object would be placed, if any."""
    cell: RoomCell | None = state.square.ahead(state.room_heading) if state.room_heading % 90.0 == 0.0 else None
    return {
        "cell": list(state.square),
        "heading": round(state.room_heading) % 360,
        "landing": list(cell) if cell is not None and cell.is_inside() else None,
    }
