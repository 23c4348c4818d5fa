"""Several episodes in one process, which write their rows of a batch: a vector environment, or a share of one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode

from arramon_client.agent import Observation
from arramon_client.environments.backend import PHASES, Images, Player
from arramon_client.environments.batches import Arrays
from arramon_client.environments.episodes import Episodes
from arramon_client.environments.options import Opened, Options, open_player
from arramon_client.environments.spaces import NO_ACTION, Dict, Translator

IMAGES = ("rgb", "depth", "segmentation")


@dataclass
class Told:
    """What a step or a reset of a group tells besides the arrays.

    Attributes:
        rewards, terminated: of each episode of the group, in order; empty after a reset.
        texts: instructions that changed, by number of the episode in the batch.
        infos: by number of the episode in the batch.
    """

    rewards: list[float] = field(default_factory=list)
    terminated: list[bool] = field(default_factory=list)
    texts: dict[int, str] = field(default_factory=dict)
    infos: dict[int, dict[str, Any]] = field(default_factory=dict)


class Group:
    """Episodes with the numbers `numbers` of a batch.

    Args:
        options: of all.
        numbers: which rows are theirs.
        autoreset: what happens at the end of an episode.
    """

    def __init__(self, options: Options, numbers: range, autoreset: AutoresetMode) -> None:
        self._numbers, self._autoreset = numbers, autoreset
        self._opened = [open_player(options) for _ in numbers]
        self._translator = Translator(self._opened[0].tokenizer)
        self._episodes = [Episodes(opened) for opened in self._opened]
        self._randoms: list[np.random.Generator | None] = [None] * len(numbers)
        self._texts = [""] * len(numbers)
        self._last_actions = [NO_ACTION] * len(numbers)
        self._images = tuple(name for name in IMAGES if name in options.sensors)

    @property
    def opened(self) -> Opened:
        """What the first episode plays with."""
        return self._opened[0]

    def begin(
        self,
        batch: Arrays,
        seeds: Sequence[int | None],
        options: Sequence[Mapping[str, Any] | None],
        mask: Sequence[bool],
    ) -> Told:
        """Begin episodes where the mask says so, and write all rows.

        Args:
            batch: whose rows are written.
            seeds, options, mask: of each episode of the group, in order.

        Raises:
            BadArgument: if there is no episode of a given id.
            gymnasium.error.ResetNeeded: if an episode is left out by the mask before its first one.
        """
        told = Told()
        for here, number in enumerate(self._numbers):
            if mask[here]:
                if seeds[here] is not None or self._randoms[here] is None:
                    self._randoms[here], _ = seeding.np_random(seeds[here])
                told.infos[number] = self._reset(here, batch, told, options[here])
            elif self._randoms[here] is None:
                raise gymnasium.error.ResetNeeded("the first reset() must begin all episodes, without a mask")
            else:
                self._repeat(here, batch, told)
        return told

    def step(self, batch: Arrays, actions: Sequence[int]) -> Told:
        """Apply the actions of the group, in order, and write all rows.

        Raises:
            gymnasium.error.ResetNeeded: if an episode has ended and is not begun anew by itself.
        """
        told = Told()
        for here, (episodes, action) in enumerate(zip(self._episodes, actions, strict=True)):
            number = self._numbers[here]
            if episodes.is_over and self._autoreset is AutoresetMode.NEXT_STEP and self._randoms[here] is not None:
                told.infos[number] = self._reset(here, batch, told, None)
                told.rewards.append(0.0)
                told.terminated.append(False)
                continue
            step, info = episodes.step(action, self._slots(batch, number))
            self._last_actions[here] = action
            told.rewards.append(step.reward)
            told.terminated.append(step.ending is not None)
            if step.observation is not None:
                self._write(here, batch, step.observation, told)
            elif self._autoreset is AutoresetMode.SAME_STEP:
                final = self._translator.observation(episodes.player.again(), action)
                info = {**self._reset(here, batch, told, None), "final_obs": final, "final_info": info}
            else:
                self._repeat(here, batch, told)
            if info:
                told.infos[number] = info
        return told

    def observation(self, here: int) -> Dict:
        """Return the latest observation of an episode of the group, for a picture."""
        return self._translator.observation(self._episodes[here].player.again(), self._last_actions[here])

    def player(self, here: int) -> Player:
        """Return what plays an episode of the group."""
        return self._episodes[here].player

    def heads(self, run_id: str) -> list[bytes]:
        """Return the heads of the hash chains over the actions of the present episodes, 32 bytes each."""
        return [episodes.player.chain_head(run_id) for episodes in self._episodes]

    def close(self) -> None:
        """Close all players."""
        for episodes in self._episodes:
            episodes.player.close()

    def _reset(self, here: int, batch: Arrays, told: Told, options: Mapping[str, Any] | None) -> dict[str, Any]:
        random = self._randoms[here]
        assert random is not None
        seen, info = self._episodes[here].begin(random, options, self._slots(batch, self._numbers[here]))
        self._last_actions[here] = NO_ACTION
        self._write(here, batch, seen, told)
        return info

    def _repeat(self, here: int, batch: Arrays, told: Told) -> None:
        seen = self._episodes[here].player.again(self._slots(batch, self._numbers[here]))
        self._write(here, batch, seen, told)

    def _slots(self, batch: Arrays, number: int) -> Images:
        return {name: batch[name][number] for name in self._images}

    def _write(self, here: int, batch: Arrays, seen: Observation, told: Told) -> None:
        """Write all of an observation but its images, which the player has written."""
        number = self._numbers[here]
        batch["turn"][number] = seen.turn
        batch["phase"][number] = PHASES.index(seen.phase)
        batch["steps_left"][number, 0] = seen.steps_left
        batch["last_action"][number] = self._last_actions[here]
        batch["instruction_tokens"][number] = self._translator.tokens(seen.instruction)
        if seen.pose is not None:
            batch["pose"][number] = seen.pose
        if seen.instruction != self._texts[here]:
            told.texts[number] = self._texts[here] = seen.instruction
