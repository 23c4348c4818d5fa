"""A group of a vector environment's episodes, played in one process and written to their rows of a batch."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode

from arramon_client.agent import Observation
from arramon_client.environments.batches import Arrays, VectorBatch
from arramon_client.environments.episodes import Episodes
from arramon_client.environments.members import Member
from arramon_client.environments.options import Options
from arramon_client.environments.players import PlayerSet, open_players
from arramon_client.environments.spaces import NO_ACTION
from arramon_client.world import IMAGE_SENSORS, PHASES


@dataclass(frozen=True)
class VectorSettings:
    """Settings of a vector environment that apply to each of its episodes.

    Attributes:
        autoreset: Gymnasium's autoreset mode.
        max_episode_steps: number of actions after which an episode is truncated; None for no limit.
        render_mode: "rgb_array" or None.
    """

    autoreset: AutoresetMode
    max_episode_steps: int | None = None
    render_mode: str | None = None


@dataclass
class EpisodeUpdates:
    """Results of a step or reset that are not in the arrays of a batch.

    Attributes:
        texts: instructions that changed, by episode number.
        infos: infos that are not empty, by episode number.
    """

    texts: dict[int, str] = field(default_factory=dict)
    infos: dict[int, dict[str, Any]] = field(default_factory=dict)

    def add(self, other: "EpisodeUpdates") -> "EpisodeUpdates":
        """Merge another object's updates into this one, and return it."""
        self.texts.update(other.texts)
        self.infos.update(other.infos)
        return self


@dataclass(frozen=True)
class EpisodeStart:
    """A request to begin an episode.

    Attributes:
        seed: seed of the generator that draws the episodes from now on; None to keep the current generator.
        options: reset options, as for `ArraMonEnv.reset`.
    """

    seed: int | None = None
    options: Mapping[str, Any] | None = None


Call = int | EpisodeStart
"""An action, or a request to begin an episode."""


class EpisodeGroup:
    """Consecutive episodes of a vector environment, played in one process.

    `apply` takes steps without rendering, and `draw` renders their frames: keeping the two apart uses the processor's
    caches better.

    Args:
        options: options of the environment.
        numbers: numbers of the episodes.
        settings: settings of the vector environment.
    """

    def __init__(self, options: Options, numbers: range, settings: VectorSettings) -> None:
        self._numbers, self._settings = numbers, settings
        self._opened = [open_players(options) for _ in numbers]
        self._translator = self._opened[0].translator()
        self._episodes = [Episodes(opened) for opened in self._opened]
        count = len(numbers)
        self._randoms: list[np.random.Generator | None] = [None] * count
        self._texts = [""] * count
        self._infos: list[dict[str, Any]] = [{} for _ in numbers]
        self._steps = [0] * count
        self._order: list[int] = []
        self._values = _initial_values(count, self._opened[0])
        self._rewards = np.zeros(count)
        self._terminated, self._truncated = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
        self._images = tuple(name for name in IMAGE_SENSORS if name in options.sensors)
        self._has_pose = "pose" in options.sensors
        self._pairs_by_batch: dict[int, tuple[VectorBatch, list[tuple[npt.NDArray[Any], npt.NDArray[Any]]]]] = {}
        """By the id of a batch, together with the batch, so that the id cannot be reused."""
        self._sent_texts = list(self._texts)
        """The instructions last reported in updates."""
        limit, mode = settings.max_episode_steps, settings.render_mode
        self._members = [Member(episodes, limit, mode) for episodes in self._episodes]

    @property
    def opened(self) -> PlayerSet:
        """The players of the first episode."""
        return self._opened[0]

    def begin(self, batch: VectorBatch, calls: Sequence[EpisodeStart | None]) -> EpisodeUpdates | None:
        """Begin the episodes whose call is not None, and write all rows.

        Raises:
            BadArgument: if a call names an unknown episode or language.
            gymnasium.error.ResetNeeded: if an episode without a call has not begun.
        """
        for index, call in enumerate(calls):
            if call is None and self._randoms[index] is None:
                raise gymnasium.error.ResetNeeded("the first reset() must begin all episodes, without a mask")
        self.apply((index, call) for index, call in zip(self._numbers, calls, strict=True) if call is not None)
        return self._write(batch)

    def step(self, batch: VectorBatch, actions: Sequence[int]) -> EpisodeUpdates | None:
        """Apply one action to each episode of the group, in order, and write all rows.

        Raises:
            gymnasium.error.ResetNeeded: if an episode has ended, and the autoreset mode does not begin the next one.
        """
        self.apply(zip(self._numbers, actions, strict=True))
        return self._write(batch)

    def apply(self, calls: Iterable[tuple[int, Call]]) -> list[int]:
        """Apply calls, each with the number of its episode, without rendering.

        Returns:
            The numbers of the episodes in the order in which they are rendered fastest: grouped by scene.

        Raises:
            gymnasium.error.ResetNeeded: if an episode has ended, and the autoreset mode does not begin the next one.
            BadArgument: if a call names an unknown episode or language.
        """
        applied = []
        for number, call in calls:
            index = number - self._numbers.start
            if isinstance(call, EpisodeStart):
                if call.seed is not None or self._randoms[index] is None:
                    self._randoms[index], _ = seeding.np_random(call.seed)
                self._infos[index] = self._reset(index, call.options)
            else:
                self._infos[index] = self._advance(index, call)
            applied.append(number)
        if len(applied) == len(self._numbers):
            return [self._numbers[index] for index in self._drawing_order()]
        return sorted(applied, key=lambda number: self._episodes[number - self._numbers.start].player.place)

    def draw(self, number: int, batch: VectorBatch, row: int) -> EpisodeUpdates | None:
        """Write an episode's observation, reward and end flags to a row of a batch.

        Returns:
            The episode's updates; None if there are none.
        """
        index = number - self._numbers.start
        self._draw(index, batch.observation, row)
        for array, values in self._array_pairs(batch):
            array[row] = values[index]
        return self._take_updates(index) if self._has_updates(index) else None

    def heads(self, run_id: str) -> list[bytes]:
        """Return the heads of the hash chains over the current episodes' actions, 32 bytes each."""
        return [episodes.player.chain_head(run_id) for episodes in self._episodes]

    def pictures(self) -> list[npt.NDArray[np.uint8]]:
        """Return a picture of each episode, (height, width, 3) uint8.

        Raises:
            gymnasium.error.ResetNeeded: if no episode has begun.
        """
        pictures = [member.render() for member in self._members]
        return [picture for picture in pictures if picture is not None]

    def call(self, name: str, *arguments: Any, **named: Any) -> list[Any]:
        """Return an attribute of each episode's `Member`; if it is callable, the result of calling it.

        Raises:
            AttributeError: if there is no such attribute.
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

    def _drawing_order(self) -> list[int]:
        """Return the indices of the episodes ordered by scene, whose data then stays in the processor's caches."""
        if not self._order:
            self._order = sorted(range(len(self._numbers)), key=lambda index: self._episodes[index].player.place)
        return self._order

    def _reset(self, index: int, options: Mapping[str, Any] | None) -> dict[str, Any]:
        random = self._randoms[index]
        assert random is not None
        seen, info = self._episodes[index].begin(random, options, with_images=False)
        self._values["last_action"][index], self._order, self._steps[index] = NO_ACTION, [], 0
        self._rewards[index], self._terminated[index], self._truncated[index] = 0.0, False, False
        self._store(index, seen)
        return info

    def _advance(self, index: int, action: int) -> dict[str, Any]:
        """Apply an action, and return its info."""
        episodes, autoreset = self._episodes[index], self._settings.autoreset
        if autoreset is AutoresetMode.NEXT_STEP and (self._terminated[index] or self._truncated[index]):
            return self._reset(index, None)
        step, info = episodes.advance(action)
        self._steps[index] += 1
        terminated = step.ending is not None
        truncated = self._steps[index] == self._settings.max_episode_steps
        self._values["last_action"][index] = action
        if step.phases_ended and not terminated:
            self._order = []
            self._store(index, episodes.player.latest_without_images())
        elif not terminated:  # Otherwise the latest observation is repeated.
            self._values["steps_left"][index, 0] = step.steps_left
        if (terminated or truncated) and autoreset is AutoresetMode.SAME_STEP:
            final = self._translator.observation(episodes.player.latest(), action)
            info = {**self._reset(index, None), "final_obs": final, "final_info": info}
        self._rewards[index], self._terminated[index], self._truncated[index] = step.reward, terminated, truncated
        return info

    def _write(self, batch: VectorBatch) -> EpisodeUpdates | None:
        """Write all rows of the group, and return the updates; None if there are none."""
        observation, first = batch.observation, self._numbers.start
        for index in self._drawing_order():
            self._draw(index, observation, first + index)
        rows = slice(first, self._numbers.stop)
        for array, values in self._array_pairs(batch):
            array[rows] = values
        updates = None
        for index in range(len(self._numbers)):
            if self._has_updates(index):
                updates = self._take_updates(index) if updates is None else updates.add(self._take_updates(index))
        return updates

    def _array_pairs(self, batch: VectorBatch) -> list[tuple[npt.NDArray[Any], npt.NDArray[Any]]]:
        """Return pairs of a batch's array, except images, and the group's array that is copied to it."""
        found = self._pairs_by_batch.get(id(batch))
        if found is None:
            observation = batch.observation
            pairs = [(observation[name], values) for name, values in self._values.items() if name in observation]
            pairs += [(batch.rewards, self._rewards), (batch.terminated, self._terminated)]
            found = self._pairs_by_batch[id(batch)] = (batch, [*pairs, (batch.truncated, self._truncated)])
        return found[1]

    def _has_updates(self, index: int) -> bool:
        return bool(self._infos[index]) or self._sent_texts[index] is not self._texts[index]

    def _draw(self, index: int, observation: Arrays, row: int) -> None:
        """Write the images of the latest observation, and store its pose."""
        player = self._episodes[index].player
        if self._has_pose:
            self._values["pose"][index] = player.latest_without_images().pose
        if self._images:
            player.draw({name: observation[name][row] for name in self._images})

    def _store(self, index: int, seen: Observation) -> None:
        """Store a new observation without its images and pose."""
        values = self._values
        values["turn"][index] = seen.turn
        values["phase"][index] = PHASES.index(seen.phase)
        values["steps_left"][index, 0] = seen.steps_left
        if seen.instruction != self._texts[index]:
            self._texts[index] = seen.instruction
            values["instruction_tokens"][index] = self._translator.tokens(seen.instruction)

    def _take_updates(self, index: int) -> EpisodeUpdates:
        """Return an episode's updates, and mark them as reported."""
        number, updates = self._numbers[index], EpisodeUpdates()
        if self._sent_texts[index] is not self._texts[index]:
            updates.texts[number] = self._sent_texts[index] = self._texts[index]
        if self._infos[index]:
            updates.infos[number], self._infos[index] = self._infos[index], {}
        return updates


def _initial_values(count: int, opened: PlayerSet) -> Arrays:
    """Return a batch's arrays, except images, before the first observation."""
    values: Arrays = {
        "turn": np.ones(count, np.int64),
        "phase": np.zeros(count, np.int64),
        "steps_left": np.zeros((count, 1), np.int32),
        "last_action": np.full(count, NO_ACTION, np.int64),
        "instruction_tokens": np.zeros((count, opened.tokenizer.length), np.int32),
    }
    if "pose" in opened.settings.sensors:
        values["pose"] = np.zeros((count, 3), np.float64)
    return values
