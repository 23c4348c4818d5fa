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
from arramon_client.environments.options import Options
from arramon_client.environments.players import Opened, open_player
from arramon_client.environments.spaces import NO_ACTION, Dict

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
        self._translator = self._opened[0].translator()
        self._episodes = [Episodes(opened) for opened in self._opened]
        count = len(numbers)
        self._randoms: list[np.random.Generator | None] = [None] * count
        self._texts = [""] * count
        self._images = tuple(name for name in IMAGES if name in options.sensors)
        self._order: list[int] = []
        self._drawn: set[int] = set()
        """Episodes whose rows of the batch have their images already."""
        self._facts = _no_facts(count, self._opened[0])

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
                self._draw(here, batch, told)
        self._write_facts(batch)
        return told

    def step(self, batch: Arrays, actions: Sequence[int]) -> Told:
        """Apply the actions of the group, in order, and write all rows.

        Raises:
            gymnasium.error.ResetNeeded: if an episode has ended and is not begun anew by itself.
        """
        count = len(self._numbers)
        told = Told(rewards=[0.0] * count, terminated=[False] * count)
        self._drawn.clear()
        # The rules of all, then the frames of all: neither leaves much of the other in the processor's caches.
        for here, (episodes, action) in enumerate(zip(self._episodes, actions, strict=True)):
            if episodes.is_over and self._autoreset is AutoresetMode.NEXT_STEP and self._randoms[here] is not None:
                info = self._reset(here, batch, told, None)
            else:
                info = self._advance(here, batch, action, told)
            if info:
                told.infos[self._numbers[here]] = info
        for here in self._in_order():
            if here not in self._drawn:
                self._draw(here, batch, told)
        self._write_facts(batch)
        return told

    def observation(self, here: int) -> Dict:
        """Return the latest observation of an episode of the group, for a picture."""
        last_action = int(self._facts["last_action"][here])
        return self._translator.whole(self._episodes[here].player.again(), last_action)

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

    def _in_order(self) -> list[int]:
        """Return the episodes by place: what is drawn there is then still in the processor's caches."""
        if not self._order:
            self._order = sorted(range(len(self._numbers)), key=lambda here: self._episodes[here].player.place)
        return self._order

    def _reset(self, here: int, batch: Arrays, told: Told, options: Mapping[str, Any] | None) -> dict[str, Any]:
        random = self._randoms[here]
        assert random is not None
        seen, info = self._episodes[here].begin(random, options, self._slots(batch, self._numbers[here]))
        self._facts["last_action"][here], self._order = NO_ACTION, []
        self._drawn.add(here)
        self._note(here, seen, told)
        return info

    def _advance(self, here: int, batch: Arrays, action: int, told: Told) -> dict[str, Any]:
        """Apply an action, and return its info; draw only where a phase or an episode begins."""
        episodes = self._episodes[here]
        step, info = episodes.advance(action)
        self._facts["last_action"][here] = action
        told.rewards[here], told.terminated[here] = step.reward, step.ending is not None
        if step.ending is None and not step.phases_ended:
            self._facts["steps_left"][here, 0] = step.steps_left
        elif step.ending is None:
            self._order = []
            self._note(here, episodes.player.again(self._slots(batch, self._numbers[here])), told)
            self._drawn.add(here)
        elif self._autoreset is AutoresetMode.SAME_STEP:
            final = self._translator.observation(episodes.player.again(), action)
            return {**self._reset(here, batch, told, None), "final_obs": final, "final_info": info}
        return info

    def _draw(self, here: int, batch: Arrays, told: Told) -> None:
        """Write the images of the latest observation, and keep its pose, which may be new."""
        player, slots = self._episodes[here].player, self._slots(batch, self._numbers[here])
        if "pose" in self._facts:
            self._note(here, player.again(slots), told)
        else:
            player.draw(slots)

    def _slots(self, batch: Arrays, number: int) -> Images:
        return {name: batch[name][number] for name in self._images}

    def _note(self, here: int, seen: Observation, told: Told) -> None:
        """Keep all of a new observation but its images, which the player has written."""
        facts = self._facts
        facts["turn"][here] = seen.turn
        facts["phase"][here] = PHASES.index(seen.phase)
        facts["steps_left"][here, 0] = seen.steps_left
        if seen.pose is not None:
            facts["pose"][here] = seen.pose
        if seen.instruction != self._texts[here]:
            told.texts[self._numbers[here]] = self._texts[here] = seen.instruction
            facts["instruction_tokens"][here] = self._translator.tokens(seen.instruction)

    def _write_facts(self, batch: Arrays) -> None:
        """Write all of the latest observations but their images."""
        rows = slice(self._numbers.start, self._numbers.stop)
        for name, values in self._facts.items():
            if name in batch:
                batch[name][rows] = values


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
