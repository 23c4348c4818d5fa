"""Several episodes in one process, which write their rows of a batch: a vector environment, or a share of one."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode

from arramon_client.agent import Observation
from arramon_client.environments.batches import Arrays, Batch
from arramon_client.environments.episodes import Episodes
from arramon_client.environments.members import Member
from arramon_client.environments.options import Options
from arramon_client.environments.players import Opened, open_player
from arramon_client.environments.spaces import NO_ACTION
from arramon_client.world import PHASES

IMAGES = ("rgb", "depth", "segmentation")


@dataclass(frozen=True)
class Rules:
    """What a vector environment asks of each of its episodes.

    Attributes:
        autoreset: what happens at the end of an episode.
        max_episode_steps: actions after which an episode is truncated; None for no such limit.
        render_mode: "rgb_array" or None.
    """

    autoreset: AutoresetMode
    max_episode_steps: int | None = None
    render_mode: str | None = None


@dataclass
class News:
    """What a step or a reset tells of episodes besides the arrays of a batch.

    Attributes:
        texts: instructions that changed, by number of the episode.
        infos: those that are not empty, by number of the episode.
    """

    texts: dict[int, str] = field(default_factory=dict)
    infos: dict[int, dict[str, Any]] = field(default_factory=dict)

    def add(self, other: "News") -> "News":
        """Take over what another one tells, and return this."""
        self.texts.update(other.texts)
        self.infos.update(other.infos)
        return self


@dataclass(frozen=True)
class Beginning:
    """A call that begins an episode.

    Attributes:
        seed: of the random numbers that draw episodes from now on; None to go on with the present ones.
        options: as for `ArraMonEnv.reset`.
    """

    seed: int | None = None
    options: Mapping[str, Any] | None = None


Call = int | Beginning
"""An action, or the beginning of an episode."""


class Group:
    """Episodes with the numbers `numbers` of a vector environment.

    What is called by `apply` is drawn by `draw`, in any order: neither the rules of all nor the frames of all leave
    much of the other in the processor's caches.

    Args:
        options: of all.
        numbers: of the episodes.
        rules: what is asked of each.
    """

    def __init__(self, options: Options, numbers: range, rules: Rules) -> None:
        self._numbers, self._rules = numbers, rules
        self._opened = [open_player(options) for _ in numbers]
        self._translator = self._opened[0].translator()
        self._episodes = [Episodes(opened) for opened in self._opened]
        count = len(numbers)
        self._randoms: list[np.random.Generator | None] = [None] * count
        self._texts = [""] * count
        self._infos: list[dict[str, Any]] = [{} for _ in numbers]
        self._steps = [0] * count
        self._order: list[int] = []
        self._facts = _no_facts(count, self._opened[0])
        self._rewards = np.zeros(count)
        self._terminated, self._truncated = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
        self._images = tuple(name for name in IMAGES if name in options.sensors)
        self._has_pose = "pose" in options.sensors
        self._pairs_of: dict[int, tuple[Batch, list[tuple[npt.NDArray[Any], npt.NDArray[Any]]]]] = {}
        """By the identity of a batch, with the batch itself, so that no other gets its identity."""
        self._said = list(self._texts)
        """Instructions as `draw` has last told them."""
        self._members = [Member(episodes, rules.max_episode_steps, rules.render_mode) for episodes in self._episodes]

    @property
    def opened(self) -> Opened:
        """What the first episode plays with."""
        return self._opened[0]

    def begin(self, batch: Batch, calls: Sequence[Beginning | None]) -> News | None:
        """Begin the episodes whose call is not None, and write all rows.

        Raises:
            BadArgument: if there is no episode of a given id.
            gymnasium.error.ResetNeeded: if an episode without a call has not begun.
        """
        for here, call in enumerate(calls):
            if call is None and self._randoms[here] is None:
                raise gymnasium.error.ResetNeeded("the first reset() must begin all episodes, without a mask")
        self.apply((here, call) for here, call in zip(self._numbers, calls, strict=True) if call is not None)
        return self._write(batch)

    def step(self, batch: Batch, actions: Sequence[int]) -> News | None:
        """Apply the actions of all episodes of the group, in order, and write all rows.

        Raises:
            gymnasium.error.ResetNeeded: if an episode has ended and is not begun anew by itself.
        """
        self.apply(zip(self._numbers, actions, strict=True))
        return self._write(batch)

    def apply(self, calls: Iterable[tuple[int, Call]]) -> list[int]:
        """Apply calls, each with the number of its episode, by the rules alone.

        Returns:
            The numbers of the episodes in the order in which they are drawn fastest: those in one place together.

        Raises:
            gymnasium.error.ResetNeeded: if an episode has terminated and is not begun anew by itself.
            BadArgument: if there is no episode of a given id.
        """
        applied = []
        for number, call in calls:
            here = number - self._numbers.start
            if isinstance(call, Beginning):
                if call.seed is not None or self._randoms[here] is None:
                    self._randoms[here], _ = seeding.np_random(call.seed)
                self._infos[here] = self._reset(here, call.options)
            else:
                self._infos[here] = self._advance(here, call)
            applied.append(number)
        if len(applied) == len(self._numbers):
            return [self._numbers[here] for here in self._in_order()]
        return sorted(applied, key=lambda number: self._episodes[number - self._numbers.start].player.place)

    def draw(self, number: int, batch: Batch, row: int) -> News | None:
        """Write the observation of an episode to a row of any batch, with its rewards and ends.

        Returns:
            What is new besides; None if nothing is.
        """
        here = number - self._numbers.start
        self._draw(here, batch.observation, row)
        for array, values in self._pairs(batch):
            array[row] = values[here]
        return self._news(here) if self._has_news(here) else None

    def heads(self, run_id: str) -> list[bytes]:
        """Return the heads of the hash chains over the actions of the present episodes, 32 bytes each."""
        return [episodes.player.chain_head(run_id) for episodes in self._episodes]

    def pictures(self) -> list[npt.NDArray[np.uint8]]:
        """Return a picture of each episode, (height, width, 3) uint8.

        Raises:
            gymnasium.error.ResetNeeded: if none has begun.
        """
        pictures = [member.render() for member in self._members]
        return [picture for picture in pictures if picture is not None]

    def call(self, name: str, *arguments: Any, **named: Any) -> list[Any]:
        """Return an attribute of each episode's `Member`, or what it returns if it can be called.

        Raises:
            AttributeError: if there is none.
        """
        found = [getattr(member, name) for member in self._members]
        return [each(*arguments, **named) if callable(each) else each for each in found]

    def set_attr(self, name: str, values: Sequence[Any]) -> None:
        """Set an attribute of each episode's `Member`.

        Raises:
            AttributeError: if it cannot be set.
        """
        for member, value in zip(self._members, values, strict=True):
            setattr(member, name, value)

    def close(self) -> None:
        """Close all players."""
        for episodes in self._episodes:
            episodes.close()

    def _in_order(self) -> list[int]:
        """Return the episodes by place: what is drawn there is then still in the processor's caches."""
        if not self._order:
            self._order = sorted(range(len(self._numbers)), key=lambda here: self._episodes[here].player.place)
        return self._order

    def _reset(self, here: int, options: Mapping[str, Any] | None) -> dict[str, Any]:
        random = self._randoms[here]
        assert random is not None
        seen, info = self._episodes[here].begin(random, options, draws=False)
        self._facts["last_action"][here], self._order, self._steps[here] = NO_ACTION, [], 0
        self._rewards[here], self._terminated[here], self._truncated[here] = 0.0, False, False
        self._note(here, seen)
        return info

    def _advance(self, here: int, action: int) -> dict[str, Any]:
        """Apply an action, and return its info."""
        episodes, autoreset = self._episodes[here], self._rules.autoreset
        if autoreset is AutoresetMode.NEXT_STEP and (self._terminated[here] or self._truncated[here]):
            return self._reset(here, None)
        step, info = episodes.advance(action)
        self._steps[here] += 1
        terminated = step.ending is not None
        truncated = self._steps[here] == self._rules.max_episode_steps
        self._facts["last_action"][here] = action
        if step.phases_ended and not terminated:
            self._order = []
            self._note(here, episodes.player.facts())
        elif not terminated:  # Or else the latest observation is repeated.
            self._facts["steps_left"][here, 0] = step.steps_left
        if (terminated or truncated) and autoreset is AutoresetMode.SAME_STEP:
            final = self._translator.observation(episodes.player.again(), action)
            info = {**self._reset(here, None), "final_obs": final, "final_info": info}
        self._rewards[here], self._terminated[here], self._truncated[here] = step.reward, terminated, truncated
        return info

    def _write(self, batch: Batch) -> News | None:
        """Write all rows of the group, and return what is new; None if nothing is."""
        observation, first = batch.observation, self._numbers.start
        for here in self._in_order():
            self._draw(here, observation, first + here)
        rows = slice(first, self._numbers.stop)
        for array, values in self._pairs(batch):
            array[rows] = values
        news = None
        for here in range(len(self._numbers)):
            if self._has_news(here):
                news = self._news(here) if news is None else news.add(self._news(here))
        return news

    def _pairs(self, batch: Batch) -> list[tuple[npt.NDArray[Any], npt.NDArray[Any]]]:
        """Return the arrays of a batch but its images, each with that of this group which is written to it."""
        found = self._pairs_of.get(id(batch))
        if found is None:
            observation = batch.observation
            pairs = [(observation[name], values) for name, values in self._facts.items() if name in observation]
            pairs += [(batch.rewards, self._rewards), (batch.terminated, self._terminated)]
            found = self._pairs_of[id(batch)] = (batch, [*pairs, (batch.truncated, self._truncated)])
        return found[1]

    def _has_news(self, here: int) -> bool:
        return bool(self._infos[here]) or self._said[here] is not self._texts[here]

    def _draw(self, here: int, observation: Arrays, row: int) -> None:
        """Write the images of the latest observation, and keep its pose."""
        player = self._episodes[here].player
        if self._has_pose:
            self._facts["pose"][here] = player.facts().pose
        if self._images:
            player.draw({name: observation[name][row] for name in self._images})

    def _note(self, here: int, seen: Observation) -> None:
        """Keep all of a new observation but its images and pose."""
        facts = self._facts
        facts["turn"][here] = seen.turn
        facts["phase"][here] = PHASES.index(seen.phase)
        facts["steps_left"][here, 0] = seen.steps_left
        if seen.instruction != self._texts[here]:
            self._texts[here] = seen.instruction
            facts["instruction_tokens"][here] = self._translator.tokens(seen.instruction)

    def _news(self, here: int) -> News:
        """Return what is new of an episode, once."""
        number, news = self._numbers[here], News()
        if self._said[here] is not self._texts[here]:
            news.texts[number] = self._said[here] = self._texts[here]
        if self._infos[here]:
            news.infos[number], self._infos[here] = self._infos[here], {}
        return news


def _no_facts(count: int, opened: Opened) -> Arrays:
    """Return all of a batch but its images, before the first observation."""
    facts: Arrays = {
        "turn": np.ones(count, np.int64),
        "phase": np.zeros(count, np.int64),
        "steps_left": np.zeros((count, 1), np.int32),
        "last_action": np.full(count, NO_ACTION, np.int64),
        "instruction_tokens": np.zeros((count, opened.tokenizer.length), np.int32),
    }
    if "pose" in opened.settings.sensors:
        facts["pose"] = np.zeros((count, 3), np.float64)
    return facts
