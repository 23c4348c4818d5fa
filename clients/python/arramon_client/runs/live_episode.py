"""An episode that is being played: what was seen last, and the acts that follow, each step taken once."""

import operator
from collections.abc import Mapping, Sequence, Set
from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from arramon.v1 import types_pb2
from arramon_client.agent import Episode, Observation
from arramon_client.errors import EpisodeLostError, StepAheadError, StepSpentError, UsageError
from arramon_client.notes import note_fault, note_text
from arramon_client.observations import observation_of
from arramon_client.open_episode import OpenEpisode
from arramon_client.runs.waiting import Changes, Operation
from arramon_client.world import IMAGE_SENSORS, Action

if TYPE_CHECKING:
    from arramon_client.agent import Note
    from arramon_client.runs.live import LivePlayer, LiveRun

MAX_PLAN = 1000
"""Maximum number of actions in one act."""

UNKNOWN = "UNKNOWN"
"""Cause of an episode that ended while the stream was broken, or with the run; the report states it."""

BLOCKED, NO_PICK_UP, PHASE_OVER, EPISODE_OVER = "blocked", "no pick-up", "phase over", "episode over"
"""Why a plan stopped before its last action."""


class LiveEpisode:
    """An episode of a run that is being played. Its operations may be run by any thread; see `waiting`.

    Args:
        run: the run.
        player: the stream's player.
        open_episode: the player's state of the episode.

    Attributes:
        changes: announced when an observation arrives, when the episode ends, and on an error.
        cause: why the episode ended, such as "AGENT_FINISHED"; `UNKNOWN` if the server did not say; empty while open.
        lost: whether another player has taken over the episode.
        stop_reason: why the latest plan stopped before its last action; empty if it did not.
    """

    def __init__(self, run: "LiveRun", player: "LivePlayer", open_episode: OpenEpisode) -> None:
        self.changes = Changes()
        self.cause = ""
        self.cause_code: types_pb2.Cause.ValueType | None = None
        self.lost = False
        self.stop_reason = ""
        self._run, self._player, self._open = run, player, open_episode
        self._seen: Observation | None = None  # The latest observation that was handed out.
        self._is_acting = False
        self._reason: str | None = None  # Why the episode is being given up; None if it is not.

    @property
    def episode(self) -> Episode:
        """What an agent gets when the episode begins."""
        return self._open.episode

    @property
    def episode_id(self) -> str:
        """Id of the episode."""
        return self._open.episode.episode_id

    @property
    def recorded(self) -> tuple[int, ...]:
        """Actions sent or recorded so far, in order of their steps."""
        with self._run.lock:
            acts = [self._open.answers[step] for step in sorted(self._open.answers)]
            return tuple(act.action for act in acts if act.HasField("action"))

    # Called by the player, which holds the run's lock

    def receive(self) -> None:
        """Take note that an observation is in the inbox."""
        seen, message, arrived = self._seen, *self._open.inbox[-1]
        if seen is not None and seen.step == message.step and seen.step not in self._open.answers:
            # Repeated on a new stream: only the time that is left has changed.
            has_clocks = message.HasField("step_seconds_left")
            self._seen = replace(
                seen,
                step_seconds_left=message.step_seconds_left if has_clocks else None,
                bank_seconds_left=message.bank_seconds_left if has_clocks else None,
                arrived=arrived,
            )
            self._open.inbox.pop()
        if self._reason is not None and not message.HasField("taken"):
            self._player.send(self._player.forfeit(self._open, message.step, self._reason))
        self.changes.announce()

    def leave(self, cause: types_pb2.Cause.ValueType | None, *, taken_over: bool) -> None:
        """Take note that the episode has ended, or was taken over."""
        self.lost = taken_over
        if not taken_over:
            self.cause = UNKNOWN
            if cause is not None and cause in types_pb2.Cause.values():
                self.cause = types_pb2.Cause.Name(cause).removeprefix("CAUSE_")
            self.cause_code = cause
        self._open.inbox.clear()
        self.changes.announce()

    def lose(self) -> None:
        """Take note that the episode was assigned to another stream of this run."""
        self._player.lose(self.episode_id)

    # Operations

    def look(self) -> Operation[Observation]:
        """Return the observation that awaits an action; the last one if the episode has ended."""
        seen = yield from self.present()
        if seen is None:
            seen = self._seen
        if seen is None:
            raise UsageError(f"episode {self.episode_id} ended before its first observation ({self.cause})")
        return seen

    def act(self, step: int, actions: int | Sequence[int], note: "Note | None" = None) -> Operation[Observation | None]:
        """Take one step or several, and return the next observation; None if the episode has ended."""
        _check_step(step)
        plan = _checked_plan(actions)
        text = note_text(note)
        if fault := note_fault(text):
            raise UsageError(fault)
        yield from self._begin_acting()
        try:
            present = yield from self.present()
            if present is None or step < present.step:
                self._check_spent(step, plan, present)
                return present
            if step > present.step:
                raise StepAheadError(self.episode_id, step, present.step)
            return (yield from self._carry_out(present, plan, text))
        finally:
            with self._run.lock:
                self._is_acting = False
                self.changes.announce()

    def give_up(self, reason: str) -> Operation[None]:
        """Give up the episode, and wait until it has ended."""
        if not isinstance(reason, str):
            raise UsageError(f"the reason is {reason!r}, expected text")
        with self._run.lock:
            if not self.cause:
                self._check()
                self._reason = reason
                step = self._live_step()
                if step is not None:  # Otherwise the forfeit is sent when the observation arrives.
                    self._player.send(self._player.forfeit(self._open, step, reason))
        while True:
            with self._run.lock:
                if self.cause:
                    return
                self._check()
                changed = self.changes.next()
            yield changed

    def _live_step(self) -> int | None:
        """Return the first step that has not been recorded; None while it is not known, as history is replayed."""
        if self._open.inbox:
            message = self._open.inbox[-1].message
            return None if message.HasField("taken") else message.step
        seen = self._seen
        if seen is not None and seen.step not in self._open.answers:
            return None if seen.taken is not None else seen.step
        return None if self._player.is_rebuilding(self._open) else max(self._open.answers, default=-1) + 1

    def _begin_acting(self) -> Operation[None]:
        """Wait until no other thread acts in this episode."""
        while True:
            with self._run.lock:
                if not self._is_acting:
                    self._is_acting = True
                    self.stop_reason = ""
                    return
                changed = self.changes.next()
            yield changed

    def present(self) -> Operation[Observation | None]:
        """Return the observation that awaits an action; None if the episode has ended."""
        while True:
            with self._run.lock:
                if self.cause:
                    return None
                self._check()
                if self._seen is not None and self._seen.step not in self._open.answers:
                    return self._seen
                if self._open.inbox:
                    message, arrived = self._open.inbox.popleft()
                    # Under the lock: the server may change shared memory as soon as the observation is answered.
                    self._seen = observation_of(message, self._player.decoder, arrived)
                    return self._seen
                changed = self.changes.next()
            yield changed

    def _carry_out(self, seen: Observation, plan: Sequence[int], note: str) -> Operation[Observation | None]:
        """Take the steps of a plan until something unexpected happens."""
        for number, action in enumerate(plan):
            self._answer(seen, action, note if number == 0 else "")
            after = yield from self.present()
            reason = EPISODE_OVER if after is None else stop_reason(seen, action, after)
            if after is None or (reason and number + 1 < len(plan)):
                self.stop_reason = reason if number + 1 < len(plan) else ""
                return after
            seen = after
        return seen

    def _answer(self, seen: Observation, action: int, note: str) -> None:
        """Send the action for an observation, or pass a recorded step."""
        with self._run.lock:
            if self.cause or self.lost:
                return  # It ended in the meantime; the caller finds out.
            if seen.taken is None:
                self._player.send(self._player.act(self._open, seen.step, action, note))
            elif action == seen.taken:
                self._player.pass_recorded(self._open, seen.step, action)
            else:
                raise StepSpentError(self.episode_id, seen.step, seen.step, seen.taken)

    def _check_spent(self, step: int, plan: Sequence[int], present: Observation | None) -> None:
        """Check that spent steps were answered with the actions of a plan that begins with them.

        Raises:
            StepSpentError: if another action is recorded at one of them, or this client does not know which.
        """
        for number, action in enumerate(plan, step):
            if present is not None and number >= present.step:
                return
            act = self._open.answers.get(number)
            if present is None and (act is None or act.HasField("forfeit")):
                return  # The episode ended before this step was taken.
            recorded = act.action if act is not None else None
            if recorded != action:
                raise StepSpentError(self.episode_id, number, None if present is None else present.step, recorded)

    def _check(self) -> None:
        if self.lost:
            raise EpisodeLostError(f"another client or stream has taken over episode {self.episode_id}")
        self._run.check()


def stop_reason(before: Observation, action: int, after: Observation) -> str:
    """Return what a plan did not expect in the observation after one of its actions; empty if all is as expected.

    Returns:
        PHASE_OVER: the phase or turn has changed.
        NO_PICK_UP: INTERACT did not end the phase: nothing was in reach.
        BLOCKED: FORWARD did not move the agent: position and heading are the same or, without the sensor "pose", all
            images are identical. Without any of these sensors this is not detected.
    """
    if (before.turn, before.phase) != (after.turn, after.phase):
        return PHASE_OVER
    if action == Action.INTERACT:
        return NO_PICK_UP
    if action != Action.FORWARD:
        return ""
    if before.pose is not None and after.pose is not None:
        return BLOCKED if before.pose == after.pose else ""
    pairs = [(getattr(before, name), getattr(after, name)) for name in IMAGE_SENSORS]
    images = [(old, new) for old, new in pairs if old is not None and new is not None]
    return BLOCKED if images and all(np.array_equal(old, new) for old, new in images) else ""


def _check_step(step: object) -> None:
    """Raise UsageError unless a step is a whole number from 0."""
    if isinstance(step, bool) or not isinstance(step, int | np.integer) or step < 0:
        raise UsageError(f"the step is {step!r}, expected a whole number from 0, such as Observation.step")


def _checked_plan(actions: int | Sequence[int]) -> tuple[int, ...]:
    """Return the actions of an act as numbers.

    Raises:
        UsageError: if it is neither an action nor a sequence of 1 to MAX_PLAN of them.
    """
    expected = f"expected an action from 0 to {len(Action) - 1}, or a sequence of 1 to {MAX_PLAN} actions"
    if isinstance(actions, str | bytes | bool | Mapping | Set):  # A set has no order.
        raise UsageError(f"the act is {actions!r}, {expected}")
    try:
        items = list(islice(actions, MAX_PLAN + 1))  # type: ignore[arg-type]
    except TypeError:
        items = [actions]  # type: ignore[list-item]
    if not 1 <= len(items) <= MAX_PLAN:
        raise UsageError(f"the act has {f'more than {MAX_PLAN}' if items else 'no'} actions, {expected}")
    return tuple(_checked_action(item, expected) for item in items)


def _checked_action(item: object, expected: str) -> int:
    try:
        number = operator.index(item)  # type: ignore[arg-type]
    except TypeError:
        number = -1
    if isinstance(item, bool | np.bool_) or not 0 <= number < len(Action):
        raise UsageError(f"the act has the action {item!r}, {expected}")
    return number
