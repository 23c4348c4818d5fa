"""State of one episode: the plan being carried out, and the exchanges of the phase."""

import hashlib
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from arramon_agents.vlm.messages import ModelExchange
from arramon_agents.vlm.prompt_texts import Prompts
from arramon_agents.vlm.replies import ModelDecision, Reply
from arramon_client.agent import Action, Episode, Observation

HARMLESS = Action.RIGHT
"""The action in place of an unusable reply. A turn leaves place, objects and phase as they are, which neither `forward`
nor `interact` does, and another turn undoes it; and the next frame is another one, so that a model whose replies do not
vary is not asked the very same thing again."""


@dataclass
class StepsOutcome:
    """What happened since the model's last answer.

    Attributes:
        done: actions taken.
        dropped: planned actions that were dropped.
        blocked: whether the last one was a forward move without effect.
        nothing: whether the last one was an interaction without effect.
        was_noop: whether the last replies were unusable.
    """

    done: list[Action] = field(default_factory=list)
    dropped: list[Action] = field(default_factory=list)
    blocked: bool = False
    nothing: bool = False
    was_noop: bool = False


class EpisodeState:
    """State of one episode.

    Args:
        episode: the episode.
        prompts: prompts in its language.
        window: number of exchanges to keep.

    Attributes:
        plan: planned actions that are still to be taken.
        exchanges: the last exchanges of the phase, oldest first.
        outcome: what happened since the last answer.
    """

    def __init__(self, episode: Episode, prompts: Prompts, window: int) -> None:
        self.episode = episode
        self.prompts = prompts
        self.plan: deque[Action] = deque()
        self.exchanges: deque[ModelExchange] = deque(maxlen=window)
        self.outcome = StepsOutcome()
        self._phase: tuple[int, str] | None = None
        self._step = -1
        self._seen: object = None
        self._last: Action | None = None

    def observe(self, observation: Observation) -> None:
        """Judge the last action by what is seen now; the same observation may come again, and then changes nothing."""
        if observation.step == self._step:
            return
        seen = _view(observation)
        phase = (observation.turn, observation.phase)
        if phase != self._phase:  # The instruction is another one: what was said before concerns it no more.
            self.plan.clear()
            self.exchanges.clear()
            self.outcome = StepsOutcome()
        else:
            self.outcome.nothing = self._last is Action.INTERACT  # It would have ended the phase.
            self.outcome.blocked = self._last is Action.FORWARD and seen is not None and seen == self._seen
            if self.outcome.blocked or self.outcome.nothing:
                self.outcome.dropped += self.plan
                self.plan.clear()
        self._phase, self._step, self._seen = phase, observation.step, seen

    def question(self, observation: Observation, scene: str) -> ModelExchange:
        """Return the question to ask before a step.

        Args:
            observation: before the step.
            scene: what is in view, in words; empty to show the frame.
        """
        prompts, outcome = self.prompts, self.outcome
        lines = []
        if outcome.was_noop:
            lines.append(prompts.text("observation.noop"))
        elif outcome.done:
            lines.append(prompts.text("observation.done", actions=_listed(outcome.done)))
        if outcome.blocked:
            lines.append(prompts.text("observation.blocked"))
        if outcome.nothing:
            lines.append(prompts.text("observation.nothing"))
        if outcome.dropped:
            lines.append(prompts.text("observation.dropped", actions=_listed(outcome.dropped)))
        numbers = {"phase_step": observation.phase_step, "steps_left": observation.steps_left}
        lines += [prompts.text("observation.now", **numbers), scene or prompts.text("observation.frame")]
        rgb = None if scene else observation.rgb
        return ModelExchange("\n".join(lines), rgb, f"{observation.episode_id}/{observation.step}")

    def decide(self, exchange: ModelExchange, reply: Reply | None, decision: ModelDecision | None) -> None:
        """Start the plan of a decision.

        Args:
            exchange: the question.
            reply: the answer as it came.
            decision: what it decides; None if it could not be used, for one harmless action.
        """
        self.outcome = StepsOutcome(was_noop=decision is None)
        self.plan = deque(decision.plan if decision is not None else (HARMLESS,))
        if reply is not None and decision is not None:
            exchange.reply = reply
            self.exchanges.append(exchange)

    def take(self) -> Action:
        """Return the next planned action, and count it as taken."""
        self._last = action = self.plan.popleft()
        self.outcome.done.append(action)
        return action


def _view(observation: Observation) -> object:
    """Return what tells whether the agent has moved: the pose, else a hash of the first image; None without both."""
    if observation.pose is not None:
        return observation.pose
    for image in (observation.rgb, observation.depth, observation.segmentation):
        if image is not None:
            return hashlib.blake2b(np.ascontiguousarray(image).tobytes(), digest_size=16).digest()
    return None


def _listed(actions: Sequence[Action]) -> str:
    return ", ".join(action.name.lower() for action in actions)


def task_text(observation: Observation, prompts: Prompts) -> str:
    """Return the instruction with its turn and phase."""
    values: dict[str, Any] = {"turn": observation.turn, "instruction": observation.instruction}
    return prompts.text(f"task.{observation.phase}", **values)
