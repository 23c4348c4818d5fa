"""The vector environment: many episodes in this process, or in several with images in shared memory."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from arramon_client.agent import Label
from arramon_client.environments.arguments import seed_of, whole
from arramon_client.environments.batches import Arrays, Layout, Leases
from arramon_client.environments.episodes import checked
from arramon_client.environments.errors import BadArgument, CannotCopy
from arramon_client.environments.group import Group, Told
from arramon_client.environments.labels import FactoredLabels, factored
from arramon_client.environments.options import make_options
from arramon_client.environments.pictures import Picture
from arramon_client.environments.players import open_backend
from arramon_client.environments.registration import PlainSpec
from arramon_client.environments.single import RENDER_MODES, room_options
from arramon_client.environments.spaces import Dict, action_space
from arramon_client.environments.tokens import Tokenizer
from arramon_client.environments.worker import Worker, context_of

OWN = ("num_envs", "processes", "autoreset_mode", "context", "render_mode")
"""Arguments besides those of a single environment."""

VectorStep = tuple[Dict, npt.NDArray[np.float64], npt.NDArray[np.bool_], npt.NDArray[np.bool_], dict[str, Any]]


class ArraMonVectorEnv(PlainSpec, VectorEnv[Dict, npt.NDArray[np.int64], npt.NDArray[Any]]):
    """The benchmark as a vector environment; `gymnasium.make_vec("arramon/ArraMon-v0", num_envs=16)` makes one.

    Observations are those of `ArraMonEnv` in arrays of (num_envs, ...); `instruction` is a tuple of whole texts. Arrays
    that were returned are never written again: a block of memory is used again when no array over it is left.

    Args:
        num_envs: number of episodes that are played at once.
        processes: in which they are played, this one included; with 1 none is started.
        autoreset_mode: what happens at the end of an episode, as Gymnasium defines it.
        context: how processes are started: "fork", "spawn", "forkserver", or None for the system's default.
        render_mode: None or "rgb_array", for pictures of the episodes that this process plays.
        options: the fields of `arramon_client.environments.options.Options`.

    Raises:
        BadArgument: if an argument is wrong; the message says what would be right.
        NoBackend: if there is no host, and the server package is not installed.

    Attributes:
        tokenizer: of the instructions.
    """

    def __init__(
        self,
        num_envs: int = 1,
        processes: int = 1,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        context: str | None = None,
        render_mode: str | None = None,
        **options: object,
    ) -> None:
        if not _is_number(num_envs) or num_envs < 1:
            raise BadArgument(f"num_envs is {num_envs!r}, expected at least 1")
        if not _is_number(processes) or not 1 <= processes <= num_envs:
            raise BadArgument(f"processes is {processes!r}, expected 1 to num_envs, which is {num_envs}")
        if render_mode not in (None, "rgb_array"):
            raise BadArgument(f"render_mode is {render_mode!r}, expected None or 'rgb_array'")
        self._autoreset = _autoreset_mode(autoreset_mode)
        checked_options = make_options(OWN, **options)
        shares = _shares(num_envs, processes)
        if processes > 1:
            open_backend(checked_options).prepare()
        self._group = Group(checked_options, shares[0], self._autoreset)
        opened = self._group.opened
        self.num_envs, self.render_mode = num_envs, render_mode
        self.autoreset_mode = self._autoreset  # Where TorchRL looks for it.
        self.metadata = {"render_modes": list(RENDER_MODES), "render_fps": 10, "autoreset_mode": self._autoreset}
        self.tokenizer: Tokenizer = opened.tokenizer
        self.single_action_space = action_space()
        self.action_space = batch_space(self.single_action_space, num_envs)
        single = opened.observation_space()
        self._has_texts = "instruction" in single.spaces
        self.single_observation_space = single
        self.observation_space = batch_space(single, num_envs)
        self._layout = Layout(single, num_envs)
        started = context_of(context)
        self._leases = Leases(self._layout, started if processes > 1 else None)
        self._workers = [
            Worker(started, checked_options, numbers, self._autoreset, self._layout, self._leases.blocks)
            for numbers in shares[1:]
        ]
        self._scratch = self._layout.over(self._leases.blocks[-1])
        self._shares = shares
        self._texts = [""] * num_envs
        self._has_begun = False

    def __getstate__(self) -> dict[str, Any]:
        raise CannotCopy("a vector environment cannot be pickled or copied: make another, or copy single environments")

    @property
    def process_ids(self) -> list[int]:
        """Ids of the processes that were started, in the order of the episodes that they play."""
        return [worker.process_id for worker in self._workers]

    @property
    def labels(self) -> tuple[Label, ...]:
        """Meaning of a segmentation's values, by index; empty without that sensor."""
        return self._group.opened.player.labels

    @property
    def factored_labels(self) -> FactoredLabels:
        """The same as arrays: kind, colour and look of each label, as numbers."""
        return factored(self.labels)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Dict, dict[str, Any]]:
        """Begin episodes.

        Args:
            seed: of the random numbers that draw episodes: of the first, and the next number for each further; or one
                for each.
            options: `{"episode": ID}` or `{"episode": [ID, ...]}` names the episodes, `{"reset_mask": MASK}`, an array
                of (num_envs,) bool, begins only some.

        Raises:
            BadArgument: if there is no such episode, or seeds, ids or mask are not as many as the episodes.
        """
        seeds, mask, named = self._seeds(seed), self._mask(options), self._named(options)
        self._has_begun = self._has_begun and not all(mask)  # If it fails halfway, nothing may go on by itself.
        batch, told = self._all("begin", self._cut(seeds, named, mask))
        self._has_begun = True
        return self._observation(batch), self._infos(told)

    def step(self, actions: npt.NDArray[np.int64]) -> VectorStep:
        """Apply one action for each episode, and return observations, rewards, terminated, False and infos.

        Raises:
            gymnasium.error.ResetNeeded: if an episode has ended, in the mode DISABLED, or none has begun.
            gymnasium.error.InvalidAction: if an action is none of the four, or they are not as many as the episodes.
        """
        if not self._has_begun:
            raise gymnasium.error.ResetNeeded("no episodes have begun; call reset() before step()")
        if np.ndim(actions) == 0:
            raise gymnasium.error.InvalidAction(f"the actions are {actions!r}, expected {self.num_envs} in an array")
        if len(actions) != self.num_envs:
            raise gymnasium.error.InvalidAction(f"there are {len(actions)} actions, expected {self.num_envs}")
        numbers = [checked(action) for action in (actions.tolist() if _are_numbers(actions) else actions)]
        batch, told = self._all("step", self._cut(numbers))
        terminated = np.array(told.terminated, np.bool_)
        truncated = np.zeros(self.num_envs, np.bool_)
        rewards = np.array(told.rewards, np.float64)
        return self._observation(batch), rewards, terminated, truncated, self._infos(told)

    def heads(self, run_id: str) -> list[bytes]:
        """Return the head of the hash chain over the actions of each present episode, 32 bytes (`arramon.v1.chain`)."""
        for worker in self._workers:
            worker.ask("heads", run_id)
        return [head for heads in (self._group.heads(run_id), *(w.answer() for w in self._workers)) for head in heads]

    def render(self) -> tuple[npt.NDArray[np.uint8], ...] | None:
        """Return a picture of each episode that this process plays; None unless the mode is "rgb_array"."""
        if self.render_mode is None:
            return None
        picture = Picture()
        return tuple(
            picture.draw(self._group.observation(here), self._group.player(here))
            for here in range(len(self._shares[0]))
        )

    def close_extras(self, **_: Any) -> None:
        """End the processes, and close all players."""
        for worker in self._workers:
            worker.close()
        self._workers = []
        self._group.close()

    def _all(self, method: str, arguments: Sequence[tuple[Any, ...]]) -> tuple[Arrays, Told]:
        """Call a method of all shares, each with its arguments; return the batch and what all of them tell."""
        block, leased = self._leases.take()
        for worker, share in zip(self._workers, arguments[1:], strict=True):
            worker.write(method, block, *share)
        written = self._scratch if leased is None else leased
        answers: list[Told] = []
        errors: list[gymnasium.error.Error] = []
        # All have to answer before an error is raised, so that none answers the next question.
        own: Callable[[], Told] = partial(getattr(self._group, method), written, *arguments[0])
        for answer in (own, *(worker.answer for worker in self._workers)):
            try:
                answers.append(answer())
            except gymnasium.error.Error as error:
                errors.append(error)
        if errors:
            raise errors[0]
        told = Told(
            rewards=[reward for each in answers for reward in each.rewards],
            terminated=[end for each in answers for end in each.terminated],
            texts={number: text for each in answers for number, text in each.texts.items()},
            infos={number: info for each in answers for number, info in each.infos.items()},
        )
        self._update(told)
        if leased is None:
            return {name: array.copy() for name, array in written.items()}, told
        return leased, told

    def _infos(self, told: Told) -> dict[str, Any]:
        infos: dict[str, Any] = {}
        for number in sorted(told.infos):
            infos = self._add_info(infos, told.infos[number], number)
        return infos

    def _update(self, told: Told) -> None:
        for number, text in told.texts.items():
            self._texts[number] = text

    def _observation(self, batch: Arrays) -> Dict:
        whole: Dict = dict(batch)
        if self._has_texts:
            whole["instruction"] = tuple(self._texts)
        return whole

    def _cut(self, *lists: Sequence[Any]) -> list[tuple[Any, ...]]:
        """Return the parts of some lists that belong to each share."""
        return [tuple(each[share.start : share.stop] for each in lists) for share in self._shares]

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, Sequence | np.ndarray) and not isinstance(seed, str):
            if len(seed) != self.num_envs:
                raise BadArgument(f"there are {len(seed)} seeds, expected {self.num_envs}")
            return [seed_of(each) for each in seed]
        first = whole("seed", seed, "None, a whole number from 0, or one for each episode", 0)
        return [first + number for number in range(self.num_envs)]

    def _mask(self, options: Mapping[str, Any] | None) -> list[bool]:
        mask = (options or {}).get("reset_mask")
        if mask is None:
            return [True] * self.num_envs
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != (self.num_envs,):
            raise BadArgument(f"reset_mask is {mask!r}, expected an array of bool with the shape ({self.num_envs},)")
        if not mask.any():
            raise BadArgument("reset_mask is False everywhere, expected at least one episode to begin")
        return [bool(each) for each in mask]

    def _named(self, options: Mapping[str, Any] | None) -> list[dict[str, Any] | None]:
        named = (options or {}).get("episode")
        if named is None:
            return [None] * self.num_envs
        if np.ndim(named) == 0:
            return [{"episode": named}] * self.num_envs
        if len(named) != self.num_envs:
            raise BadArgument(f"there are {len(named)} episodes, expected {self.num_envs}")
        return [{"episode": each} for each in named]


def make_vector(num_envs: int = 1, **arguments: Any) -> ArraMonVectorEnv:
    """Return the vector environment, for `gymnasium.make_vec`."""
    return ArraMonVectorEnv(num_envs, **arguments)


def make_room_vector(
    num_envs: int = 1,
    processes: int = 1,
    autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
    context: str | None = None,
    render_mode: str | None = None,
    **options: object,
) -> ArraMonVectorEnv:
    """Return the vector environment of tasks in the room alone, for `gymnasium.make_vec`."""
    return ArraMonVectorEnv(num_envs, processes, autoreset_mode, context, render_mode, **room_options(options, OWN))


def _is_number(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def _are_numbers(actions: object) -> bool:
    return isinstance(actions, np.ndarray) and actions.dtype.kind in "iu"


def _autoreset_mode(mode: AutoresetMode | str) -> AutoresetMode:
    if isinstance(mode, AutoresetMode):
        return mode
    try:
        return AutoresetMode(mode)
    except ValueError:
        there = ", ".join(repr(each.value) for each in AutoresetMode)
        raise BadArgument(f"autoreset_mode is {mode!r}, expected {there}") from None


def _shares(count: int, processes: int) -> list[range]:
    """Return which episodes each process plays, as equally as can be."""
    ends = [count * number // processes for number in range(processes + 1)]
    return [range(start, end) for start, end in pairwise(ends)]
