"""Rule-based execution of a navigation instruction, step by step, on the agent's map and landmarks."""

import math
from dataclasses import replace

from arramon_agents.follower.map_walker import MapWalker
from arramon_agents.follower.referents import ORDINALS, Marks, Referents
from arramon_agents.follower.side_streets import SideStreets, find_middle, find_next_side_street
from arramon_agents.mapping.body import AgentBody, to_local_frame
from arramon_agents.mapping.landmark_memory import MappedLandmark, landmarks_ahead
from arramon_agents.mapping.motion import TURN, step_key, turns
from arramon_agents.mapping.notes import Intent, outline, place
from arramon_agents.mapping.target import (
    find_resembling,
    find_target,
    has_seen_reference,
    is_near_reference,
    is_reached,
)
from arramon_client.agent import Action
from arramon_client.world import HEADINGS
from arramon_lang.meaning import PLACES, Face, Navigation, Rotate, Step, Thing, Walk
from arramon_lang.street_words import (
    CROSSED_DISTANCE,
    DEGREES,
    PASSED_WITHIN,
    PAST_DISTANCE,
    REACHED_WITHIN,
    TURN_OFFSETS,
)

PASSED_DISTANCE = 0.5
"""Distance in units ahead at which a place counts as passed."""

MAX_ASIDE = 2.5
"""Maximum distance from the course of a walk past a place or to a side street, in units."""

MAX_OFF_COURSE = 1.0
"""Distance of a place from the course, beyond PASSED_WITHIN, from which the agent walks to it first, in units."""

NEAR_TARGET = 10.0
"""Distance in units below which a visible target is approached at once, skipping the remaining steps."""

LOOK_BOTH_SIDES = (Action.LEFT, Action.RIGHT, Action.RIGHT, Action.LEFT)
"""Actions that look to both sides."""

LOCK_DISTANCE = 4.0
"""Distance in units below which the referent of a step is no longer changed."""

SEEN_DISTANCE = 14.0
"""Maximum distance in units of a landmark for the step "walk until you see it" to end."""

MAX_DISTANCE_TO_BUILDING = 9.0
"""Maximum distance in units between a side street and the centre of the building where the instruction says to turn."""

SEEK_DISTANCE = 15.0
"""Distance in units to walk on in search of a landmark that has not been seen."""

ONWARD_DISTANCE = 25.0
"""Distance in units to walk on after the last step in search of the target, before searching elsewhere."""


class Navigator:
    """Executor of one navigation instruction.

    Args:
        body: the agent's pose, map and landmarks, which persist between instructions.
        meaning: the meaning of the instruction.
        heading: heading from which its first directions are meant, in multiples of 30 degrees: the agent turns to it
            before the first step. None for the agent's own.
    """

    def __init__(self, body: AgentBody, meaning: Navigation, heading: int | None = None) -> None:
        self._body = body
        self._meaning = meaning
        self._number = 0
        self._course = body.angle if heading is None else heading * TURN
        self._first_turns = [] if heading is None else turns(body.heading, heading)
        self._walker = MapWalker(body)
        self._committed = False
        self._missed: set[tuple[float, float]] = set()
        self._interacted: MappedLandmark | None = None
        self._looks: list[Action] = []
        self._visited: list[tuple[float, float]] = []
        self._referents = Referents(body.landmarks)
        self._searched = not meaning.target.where
        self._searches = [self._to_surroundings, self._onward, self._to_surroundings, self._to_resembling]
        self._begin_step()

    def act(self, steps_left: int = 0) -> Action:  # noqa: ARG002 - the rules do not depend on it
        """Return the next action; call it after the body has perceived the observation."""
        if self._first_turns:
            return self._first_turns.pop(0)
        self._body.taken = None
        if self._interacted is not None:
            self._missed.add((self._interacted.x, self._interacted.z))
            self._interacted = None
        action = self._go_for_target()
        while action is None and self._number < len(self._meaning.steps):
            action = self._do(self._meaning.steps[self._number])
            if action is None:
                self._number += 1
                self._begin_step()
        return self._explore() if action is None else action

    def intent(self) -> Intent:
        """Return the number of the step that is carried out, and the place that the agent walks to."""
        goal = {"goal": place(*self._walker.goal)} if self._walker.is_walking else {}
        if self._committed:
            return {"take": outline(self._meaning.target), **goal}
        is_done = self._number >= len(self._meaning.steps)
        return {**({"search": True} if is_done else {"step": self._number + 1}), **goal}

    def _begin_step(self) -> None:
        for thing, marks in getattr(self, "_locks", {}).items():
            self._referents.store(thing, marks)
        self._locks: dict[Thing, Marks] = {}
        self._side_streets = SideStreets(self._body.x, self._body.z, self._course)
        self._place: tuple[float, float] | None = None
        self._turned_to: float | None = None
        self._start = self._body.x, self._body.z
        self._start_course = self._course
        self._looked = False
        self._looks = []
        self._walker.stop()

    # The target

    def _go_for_target(self) -> Action | None:
        target = find_target(self._body, self._meaning.target, self._missed)
        if target is None or not (self._committed or self._is_worth_going_for(target)):
            return None
        self._committed = True
        return self._take(target)

    def _take(self, target: MappedLandmark) -> Action | None:
        """Return the next action towards an object, and the pick-up if it is reached; None if there is no way."""
        body = self._body
        if is_reached(body, target, *body.pose):
            self._interacted = target
            body.taken = target.x, target.z
            return Action.INTERACT
        return self._walker.go_for(target)

    def _is_worth_going_for(self, target: MappedLandmark) -> bool:
        """Return whether to approach a candidate for the target now.

        Before the last step is done, only if it is near, visible, and next to the target's reference object. Afterwards
        other candidates are left for the end of the search, before what only resembles the target, unless they are
        straight ahead and no reference object has been seen.
        """
        body, wanted = self._body, self._meaning.target
        is_sure = is_near_reference(body, wanted, target)
        is_near = body.distance(target.x, target.z) <= NEAR_TARGET
        is_near = is_near and body.ground.has_line_of_sight(body.x, body.z, target.x, target.z)
        if self._number < len(self._meaning.steps):
            return is_sure and is_near
        if is_sure or len(self._searches) <= 1:
            return True
        right, ahead = to_local_frame(target.x - body.x, target.z - body.z, self._course)
        has_looked = self._looked and not self._looks
        return is_near and has_looked and ahead > abs(right) and not has_seen_reference(body, wanted)

    # The steps

    def _do(self, step: Step) -> Action | None:
        """Return the next action of a step; None if the step is done."""
        if isinstance(step, Rotate):
            return self._turn(step)
        if isinstance(step, Face):
            return self._face(step.thing)
        return self._walk(step)

    def _turn(self, step: Rotate) -> Action | None:
        if self._turned_to is None:
            if step.at and step.thing is not None:
                action = self._approach(step)
                if action is not None:
                    return action
            self._turned_to = self._course + math.radians(DEGREES[step.direction])
        return self._turn_to(self._turned_to)

    def _turn_to(self, course: float) -> Action | None:
        body = self._body
        rotation = turns(body.heading, round(course / TURN) % HEADINGS)
        if rotation:
            return rotation[0]
        self._course = course
        return None

    def _face(self, thing: Thing) -> Action | None:
        marks = self._body.landmarks.matching(thing)
        if self._turned_to is None:
            if not marks and len(self._visited) < HEADINGS:
                self._visited.append((self._body.x, self._body.z))
                return Action.RIGHT
            self._visited.clear()
            if not marks:
                return None
            mark = min(marks, key=lambda m: (self._body.distance(m.x, m.z), m.x))
            self._turned_to = math.atan2(mark.x - self._body.x, mark.z - self._body.z)
        return self._turn_to(self._turned_to)

    def _walk(self, step: Walk) -> Action | None:
        if step.way in ("ahead", "along"):
            return self._walk_ahead(step)
        if step.way == "until":
            return None if self._is_seen(step.things[0]) else self._walker.go_ahead(self._course)
        if step.things[0].kind in PLACES:
            return self._to_place(step.things[0], 0, CROSSED_DISTANCE if step.way == "past" else 0.0)
        marks = self._resolve(step.things)
        if marks is None:
            return self._seek()
        body = self._body
        if step.way in ("to", "towards"):
            near = REACHED_WITHIN[step.way]
            if body.distance(marks[0], marks[1]) <= near:
                self._course = self._aim(marks, self._start)
                return None
            return self._walker.go_to(marks, near - 0.2)
        beyond = {"past": PAST_DISTANCE, "beside": 0.0}.get(step.way, 0.3)
        if step.way == "past" and (step.things[0].number or step.things[0].kind == "building"):
            marks = self._farthest(step.things[0])
        if step.things[0].kind == "building":
            return self._walk_along(marks, beyond)
        return self._pass(marks, beyond)

    def _farthest(self, thing: Thing) -> tuple[float, float]:
        """Return the place of the last landmark of a group along the walk."""
        sin, cos = math.sin(self._start_course), math.cos(self._start_course)
        last = max(self._locks[thing], key=lambda mark: (mark.x * sin + mark.z * cos, mark.x))
        return last.x, last.z

    def _is_seen(self, thing: Thing) -> bool:
        """Return whether a matching landmark is ahead within SEEN_DISTANCE."""
        body = self._body
        marks = landmarks_ahead(body.landmarks.matching(thing), body.x, body.z, self._course)
        return any(body.distance(mark.x, mark.z) <= SEEN_DISTANCE for mark in marks)

    def _walk_ahead(self, step: Walk) -> Action | None:
        following = self._meaning.steps[self._number + 1 :]
        if step.count:
            done = math.hypot(self._body.x - self._start[0], self._body.z - self._start[1]) >= step.count
            return None if done else self._walker.go_ahead(self._course)
        if following and not (isinstance(following[0], Rotate) and not following[0].at):
            return None
        return self._walker.go_ahead(self._course)

    def _approach(self, step: Rotate) -> Action | None:
        """Return the next action towards the place of a turn; None if the agent is there."""
        thing = step.thing
        assert thing is not None
        if thing.kind in PLACES or thing.kind == "building":
            return self._to_place(thing, -1 if "left" in step.direction else 1, TURN_OFFSETS[step.at])
        marks = self._resolve((thing,))
        if marks is None:
            return self._seek()
        return self._pass(marks, TURN_OFFSETS[step.at])

    def _to_place(self, thing: Thing, side: int, beyond: float) -> Action | None:
        """Return the next action towards a place of the street, or the side street at a building; None if there.

        `side` is the side of the side street: -1 for left, 1 for right, 0 for any.
        """
        if thing.kind in ("street_end", "t_junction"):
            return self._walker.go_ahead(self._course)
        body = self._body
        if self._place is None:
            self._side_streets.add(body.ground, body.x, body.z, self._course)
            self._place = self._find_place(thing, side)
            if self._place is None:
                return self._walker.go_ahead(self._course)
        x, z = find_middle(body.ground, self._place, self._course, side) if side else self._place
        left = to_local_frame(x - body.x, z - body.z, self._course)[1] + beyond
        if left <= PASSED_DISTANCE:
            return None
        return self._walker.go_along(self._course, left - PASSED_DISTANCE, MAX_ASIDE)

    def _find_place(self, thing: Thing, side: int) -> tuple[float, float] | None:
        building = thing if thing.kind == "building" else next((t for w in thing.where for t in w.things), None)
        if building is not None:
            marks = self._resolve((building,))
            place = None if marks is None else self._side_streets.nearest(side, *marks)
            near = place is not None and marks is not None and math.dist(place, marks) < MAX_DISTANCE_TO_BUILDING
            return place if near else None
        number = max(ORDINALS.get(thing.which, 0), 0)
        if number or side == 0:
            return self._side_streets.find(side, number)
        return find_next_side_street(self._body.ground, self._body.x, self._body.z, self._course, side)

    def _pass(self, place: tuple[float, float], beyond: float) -> Action | None:
        """Return the next action along the course to `beyond` units past a place; None if the agent is there."""
        body = self._body
        if self._place is None:
            self._place = place
            right, ahead = to_local_frame(place[0] - body.x, place[1] - body.z, self._course)
            self._course += math.atan2(right - min(max(right, -PASSED_WITHIN), PASSED_WITHIN), max(ahead, 0.5))
        course = self._course
        right, ahead = to_local_frame(place[0] - body.x, place[1] - body.z, course)
        left = ahead + beyond
        if left <= PASSED_DISTANCE:
            return None
        aside = right - min(max(right, -PASSED_WITHIN), PASSED_WITHIN)
        if abs(aside) <= MAX_OFF_COURSE:
            return self._walker.go_along(course, left - PASSED_DISTANCE, MAX_ASIDE)
        sin, cos = math.sin(course), math.cos(course)
        goal = body.x + left * sin + aside * cos, body.z + left * cos - aside * sin
        return self._walker.go_to(body.ground.nearest_free(*goal), 0.6)

    def _walk_along(self, place: tuple[float, float], beyond: float) -> Action | None:
        """Return the next action along the street to `beyond` units past a building, however far aside it stands."""
        if self._place is None:
            self._place = place
        _, ahead = to_local_frame(self._place[0] - self._body.x, self._place[1] - self._body.z, self._course)
        return None if ahead + beyond <= PASSED_DISTANCE else self._walker.go_ahead(self._course)

    def _aim(self, place: tuple[float, float], start: tuple[float, float]) -> float:
        if math.hypot(place[0] - start[0], place[1] - start[1]) < 1.5:
            return self._course
        return math.atan2(place[0] - start[0], place[1] - start[1])

    def _resolve(self, things: tuple[Thing, ...]) -> tuple[float, float] | None:
        """Return the place of the things (the centre of several); None if one has not been seen yet."""
        found: list[MappedLandmark] = []
        for thing in things:
            locked = self._locks.get(thing)
            if not locked or self._body.distance(locked[0].x, locked[0].z) > LOCK_DISTANCE:
                locked = self._referents.find(thing, *self._start, self._start_course)
                if locked is None:
                    return None
                self._locks[thing] = locked
            found += locked if len(things) == 1 else locked[:1]
        if len(things) == 2 and things[0] == things[1]:
            return self._resolve((replace(things[0], number="two"),))
        xs, zs = [mark.x for mark in found], [mark.z for mark in found]
        return sum(xs) / len(xs), sum(zs) / len(zs)

    def _seek(self) -> Action | None:
        """Look to both sides for a landmark not seen yet, then walk on; None if blocked or after SEEK_DISTANCE."""
        if not self._looked:
            self._looked = True
            self._looks = list(LOOK_BOTH_SIDES)
        if self._looks:
            return self._looks.pop(0)
        return self._walker.go_ahead(self._course) if self._body.distance(*self._start) < SEEK_DISTANCE else None

    def _explore(self) -> Action:
        """Search for the target after the last step: at its reference object, along the street, then anywhere.

        Before searching anywhere, take an object near the end of the walk that resembles the target.
        """
        if not self._looked:
            self._looked = True
            self._looks = list(LOOK_BOTH_SIDES)
        while self._searches:
            if self._looks:
                return self._looks.pop(0)
            action = self._searches[0]()
            if action is not None:
                return action
            self._searches.pop(0)
            self._walker.stop()
        return self._wander()

    def _to_surroundings(self) -> Action | None:
        """Go to the target's reference object, and look around there."""
        if self._searched:
            return None
        marks = self._resolve(tuple(thing for where in self._meaning.target.where[:1] for thing in where.things))
        action = None if marks is None else self._walker.go_to(marks, 2.0)
        if action is None and marks is not None:
            self._searched = True
            self._looks = [Action.RIGHT] * (HEADINGS - 1)
            return self._looks.pop(0)
        return action

    def _to_resembling(self) -> Action | None:
        """Take an object near the end of the walk that resembles the target."""
        mark = find_resembling(self._body, self._meaning.target, self._missed, self._start)
        return None if mark is None else self._take(mark)

    def _onward(self) -> Action | None:
        return self._walker.go_ahead(self._course) if self._body.distance(*self._start) < ONWARD_DISTANCE else None

    def _wander(self) -> Action:
        """Explore: look around, go to the frontier of the known ground, and repeat."""
        body = self._body
        if (
            not self._looks
            and not self._walker.is_walking
            and all(body.distance(*place) > 2.0 for place in self._visited)
        ):
            self._visited.append((body.x, body.z))
            self._looks = [Action.RIGHT] * (HEADINGS - 1)
        if self._looks:
            return self._looks.pop(0)
        if self._walker.is_walking:
            action = self._walker.go_to(self._walker.goal, 0.8)
            if action is not None:
                return action
        edge = body.ground.frontier()
        if len(edge):
            ahead = body.x + 3.0 * math.sin(self._course), body.z + 3.0 * math.cos(self._course)
            far = ((edge - ahead) ** 2).sum(axis=1)
            for place in self._visited:
                far[((edge - place) ** 2).sum(axis=1) < 4.0] += 1e4
            x, z = edge[int(far.argmin())].tolist()
            action = self._walker.go_to((x, z), 0.8)
            if action is not None:
                return action
        # Nowhere to go on the map: it may be wrong, so try steps that it forbids.
        return Action.RIGHT if step_key(*body.pose) in body.closed_steps else Action.FORWARD
