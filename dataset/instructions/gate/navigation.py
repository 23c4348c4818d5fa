"""Gate checks of navigation instructions: every step and every named thing against the path and the world."""

from dataclasses import replace

from arramon_dataset.instructions.gate.progress import GateProgress, nearest_index
from arramon_dataset.instructions.gate.streets import faults_of_place, faults_of_turn_on_the_way
from arramon_dataset.instructions.gate.texts import faults_of_names
from arramon_dataset.instructions.gate.things import (
    faults_of_confusable_things,
    faults_of_description,
    faults_of_group,
    faults_of_relations,
    faults_of_target,
    faults_of_visibility,
)
from arramon_dataset.instructions.gate.turns import check_turn, faults_of_bends, faults_of_face
from arramon_dataset.instructions.gate.walks import check_walk
from arramon_dataset.instructions.gate.world import GateWorld
from arramon_dataset.path_tolerances import ACCEPTED_AT
from arramon_lang.coreference import things_of
from arramon_lang.meaning import PLACES, Face, Navigation, Rotate, Step, Thing, Walk

NOT_FIRST = ("intersection", "t_junction", "corner", "building_corner")
"""Kinds of places that refer to the first one on the path; so does a square that marks a turn."""

UNREACHED = ("towards", "until", "ahead")
"""Ways of walking that do not end at the thing they refer to."""

SHORT_OF = 2
"""Maximum number of places by which a turn may precede the place nearest to the thing just walked to."""


def faults_of_navigation(meaning: Navigation, world: GateWorld) -> tuple[str, ...]:
    """Return the false statements of an instruction; () if all of it is true.

    Args:
        meaning: with identities of all things that it names.
        world: the gate's view of the turn.
    """
    check = NavigationCheck(world)
    faults = [*faults_of_names(meaning), *(fault for step in meaning.steps for fault in check.add(step))]
    return (*faults, *check.end(meaning.target))


class NavigationCheck:
    """Checks an instruction step by step while it advances along the path; a `navigation.plan.PlanCheck`.

    Args:
        world: the gate's view of the turn.
    """

    def __init__(self, world: GateWorld) -> None:
        self._world = world
        self._progress = GateProgress()
        self._last: Step | None = None

    def after(self, steps: tuple[Step, ...]) -> "NavigationCheck | None":
        """Return the check after further steps; None if they are false or omit a bend of the path."""
        check = NavigationCheck(self._world)
        check._progress, check._last = self._progress, self._last
        if any(check.add(step) for step in steps):
            return None
        return None if any(faults_of_bends(self._world, check._progress, is_end=False)) else check

    def may_end(self, target: Thing) -> bool:
        """Return whether the target's description is true and every bend was mentioned."""
        return not self.end(target)

    def end(self, target: Thing) -> list[str]:
        """Return the false statements about the target, and the bends that no step mentions."""
        world, progress = self._world, self._progress
        return [
            *faults_of_bends(world, progress, is_end=True),
            *faults_of_description(world, progress, target),
            *faults_of_relations(world, progress, target),
            *faults_of_target(world, target),
        ]

    def add(self, step: Step) -> list[str]:
        """Advance by a step, and return its false statements."""
        world, before, things = self._world, self._progress, things_of(step)
        faults: list[str] = []
        if isinstance(self._last, Face) and isinstance(step, Rotate) and step.at == "after":
            faults.append(f"there is no walk between facing {self._last.thing.identity} and the turn")
        for thing in things:
            faults += faults_of_description(world, before, thing)
            if thing.kind in NOT_FIRST or (thing.kind == "square" and isinstance(step, Rotate)):
                faults += faults_of_place(world, before.first_alternative, thing, step)
            faults += faults_of_relations(world, before, thing)
            faults += faults_of_group(world, before, thing)
        self._advance(step, faults)
        self._last = step
        named = before.named.union(thing.identity for thing in things)
        self._progress = progress = replace(
            self._progress, named=named, since=before.at, earlier=frozenset(before.mentioned_turns)
        )
        for thing in things if world.poses else ():
            faults += faults_of_visibility(world, progress, thing)
            faults += faults_of_confusable_things(world, progress, thing, is_faced=isinstance(step, Face))
        return faults

    def _advance(self, step: Step, faults: list[str]) -> None:
        world, before = self._world, self._progress
        if isinstance(step, Rotate):
            self._progress = check_turn(world, before, step, faults)
            if step.thing is None and isinstance(self._last, Walk) and self._last.way in UNREACHED:
                faults += faults_of_turn_on_the_way(world, before.since, step.direction, self._progress.at)
            if self._is_short(step, self._progress.turned[len(before.turned) :]):
                faults.append(f"the path turns {step.direction} before it reaches the thing to walk to")
        elif isinstance(step, Face):
            faults += faults_of_face(world, before, step.thing)
            self._progress = replace(before, faced=(*before.faced, before.at))
        else:
            self._progress = check_walk(world, before, step, faults)

    def _is_short(self, step: Rotate, turned: tuple[int, ...]) -> bool:
        """Return whether a turn without a landmark lies well before the thing that the last step walked to."""
        last = self._last
        if step.thing is not None or not isinstance(last, Walk) or last.way != "to" or last.things[0].kind in PLACES:
            return False
        near = nearest_index(self._world, last.things, self._progress.since, ACCEPTED_AT)
        return near is not None and any(index < near - SHORT_OF for index in turned)
