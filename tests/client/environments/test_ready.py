"""Batches of the first episodes that are ready: the same observations as in lockstep, and clear errors."""

import multiprocessing
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from arramon_client.environments import BadArgument
from arramon_client.environments.vector import ArraMonVectorEnv
from arramon_client.environments.worker import WorkerDied
from arramon_dataset.environments.player import LocalPlayer

COUNT, ROWS = 5, 2


@pytest.fixture(params=[1, 2, 3])
def processes(request: pytest.FixtureRequest) -> int:
    return int(request.param)


@pytest.fixture
def opened(data: Path) -> Iterator[Any]:
    """Makes environments, and closes them in the end."""
    made: list[ArraMonVectorEnv] = []

    def make(processes: int = 1, batch_size: int | None = ROWS, mode: str = "NextStep", **more: Any) -> Any:
        arguments = {"data": data, "split": "tiny", "image_size": 16, "steps_per_phase": 3, **more}
        env = gymnasium.make_vec(
            "arramon/ArraMon-v0", COUNT, processes=processes, batch_size=batch_size, autoreset_mode=mode, **arguments
        )
        assert isinstance(env, ArraMonVectorEnv)
        made.append(env)
        return env

    yield make
    for env in made:
        env.close()


def chosen(number: int, step: int) -> int:
    """The action of an episode in its own step: the same in whatever order the episodes come."""
    return (7 * number + 3 * step + step // 4) % 4


def seen_of(outcome: Any, row: int, number: int) -> dict[str, Any]:
    """All that an episode is given in a row, and in a batch in lockstep."""
    values, rewards, terminated, truncated, infos = outcome
    told = {name: value[row] for name, value in infos.items() if name != "env_id" and not name.startswith("_")
            and infos[f"_{name}"][row] and not isinstance(value, dict)}  # fmt: skip
    assert number >= 0
    images = {name: value[row].tobytes() for name, value in values.items() if isinstance(value, np.ndarray)}
    return {
        **images,
        "instruction": values["instruction"][row],
        "outcome": (rewards[row], terminated[row], truncated[row]),
        "told": {name: value for name, value in told.items() if name != "final_obs"},
    }


def play_on(env: Any) -> None:
    """Play without an end."""
    while True:
        *_, infos = env.recv()
        env.send([0] * len(infos["env_id"]), infos["env_id"])


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
@pytest.mark.parametrize(
    "more", [{}, {"lang": "hi", "sensors": ("rgb", "segmentation", "pose"), "expert": "reference"}]
)
def test_each_episode_is_the_same_as_in_lockstep(opened: Any, processes: int, mode: str, more: dict[str, Any]) -> None:
    """Observations, rewards, ends and infos, by episode, through several ends of episodes."""
    steps = 30
    lockstep = opened(1, None, mode, reward="progress", **more)
    lockstep.reset(seed=3)
    expected: dict[int, list[Any]] = {number: [] for number in range(COUNT)}
    for step in range(steps):
        outcome = lockstep.step(np.array([chosen(number, step) for number in range(COUNT)]))
        for number in range(COUNT):
            expected[number].append(seen_of(outcome, number, number))
    env = opened(processes, ROWS, mode, reward="progress", **more)
    env.async_reset(seed=3)
    found: dict[int, list[Any]] = {number: [] for number in range(COUNT)}
    while min(map(len, found.values())) < 12:
        outcome = env.recv()
        numbers = outcome[4]["env_id"]
        assert numbers.shape == (ROWS,)
        assert len(set(numbers)) == ROWS
        for row, number in enumerate(numbers.tolist()):
            found[number].append(seen_of(outcome, row, number))
        env.send(np.array([chosen(number, len(found[number]) - 1) for number in numbers.tolist()]), numbers)
    ends = 0
    for number in range(COUNT):
        first, *later = found[number]
        assert first["outcome"] == (0.0, False, False)
        count = min(len(later), steps)
        assert later[:count] == expected[number][:count]
        ends += sum(bool(each["outcome"][1]) for each in later)
    assert ends >= 1


def test_no_episode_is_left_behind(opened: Any, processes: int) -> None:
    env = opened(processes)
    env.async_reset(seed=0)
    taken = np.zeros(COUNT, int)
    while taken.min() < 5:  # It comes to that however fast the processes are.
        *_, infos = env.recv()
        taken[infos["env_id"]] += 1
        env.send(np.ones(ROWS, int), infos["env_id"])


def test_what_was_received_never_changes(opened: Any, processes: int) -> None:
    env = opened(processes)
    env.async_reset(seed=0)
    kept, copies = [], []
    for _ in range(12):
        values, *_, infos = env.recv()
        kept.append(values["depth"])
        copies.append(values["depth"].copy())
        env.send(np.zeros(ROWS, int), infos["env_id"])
    for one, other in zip(kept, copies, strict=True):
        assert (one == other).all()


def test_a_slow_episode_holds_up_no_batch(opened: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where one begins anew, which may take long, the others come first."""
    env = opened(1, ROWS, "Disabled")
    env.reset(seed=0)
    env.send([0] * COUNT)
    order: list[int] = []
    original = LocalPlayer.draw

    def draw(self: LocalPlayer, into: Any) -> None:
        order.append(1)
        original(self, into)

    monkeypatch.setattr(LocalPlayer, "draw", draw)
    env.recv()
    assert len(order) == ROWS  # No more than the batch needs.


def test_disabled_resets_those_of_the_mask(opened: Any, processes: int) -> None:
    env = opened(processes, 1, "Disabled", steps_per_phase=1)
    env.async_reset(seed=0)
    over = None
    while over is None:
        _, _, terminated, _, infos = env.recv()
        if terminated[0]:
            over = int(infos["env_id"][0])
        else:
            env.send([1], infos["env_id"])
    with pytest.raises(gymnasium.error.ResetNeeded, match=rf"the episodes of \[{over}\] have ended"):
        env.send([1], [over])
    mask = np.arange(COUNT) == over
    with pytest.raises(gymnasium.error.AlreadyPendingCallError, match="reset"):
        env.reset(options={"reset_mask": mask})
    with pytest.raises(gymnasium.error.AlreadyPendingCallError, match="are to be received"):
        env.async_reset(options={"reset_mask": ~mask})
    env.async_reset(options={"reset_mask": mask, "episode": "4"})
    while True:
        *_, infos = env.recv()
        if infos["env_id"][0] == over:
            break
    assert infos["episode_id"].tolist() == ["4"]


def test_calls_in_a_wrong_order(opened: Any, processes: int) -> None:
    env = opened(processes)
    with pytest.raises(gymnasium.error.NoAsyncCallError, match="waits for 2 episodes"):
        env.recv()
    with pytest.raises(gymnasium.error.ResetNeeded, match="no episodes have begun"):
        env.send([0], [0])
    with pytest.raises(gymnasium.error.ResetNeeded, match="must begin all episodes"):
        env.async_reset(options={"reset_mask": np.arange(COUNT) == 1})
    env.reset(seed=0)
    env.send([0], [3])
    with pytest.raises(gymnasium.error.NoAsyncCallError, match="but 1 have a call"):
        env.recv()
    with pytest.raises(gymnasium.error.AlreadyPendingCallError, match=r"\[3\]"):
        env.send([0, 1], [2, 3])
    with pytest.raises(
        gymnasium.error.AlreadyPendingCallError, match=r"step\(\) was called while the results of \[3\]"
    ):
        env.step(np.zeros(COUNT, int))
    env.send([0], [2])
    *_, infos = env.recv()
    assert sorted(infos["env_id"]) == [2, 3]
    assert env.step(np.zeros(COUNT, int))[0]["steps_left"][:, 0].tolist() == [2, 2, 1, 1, 2]
    env.send([0] * COUNT)
    values, infos = env.reset(seed=0)  # What was to be received is dropped.
    assert values["steps_left"][:, 0].tolist() == [3] * COUNT
    env.send([0] * COUNT)
    assert env.get_attr("task") == ("navigation",) * COUNT  # Waits until all are ready, though not received.
    env.close()
    for method, arguments in (("recv", ()), ("send", ([0], [0])), ("async_reset", ())):
        with pytest.raises(gymnasium.error.ClosedEnvironmentError, match=rf"{method}\(\) was called after close\(\)"):
            getattr(env, method)(*arguments)


@pytest.mark.parametrize(
    ("actions", "numbers", "message"),
    [
        ([0], [5], "there is no episode 5 in env_id; there are 0 to 4"),
        ([0], [-1], "there is no episode -1"),
        ([0], [True], "there is no episode True"),
        ([0], [0.5], r"there is no episode 0\.5"),
        ([0], 1, "env_id is 1, expected numbers"),
        ([0, 1], [2, 2], "expected each episode once"),
        ([0, 1], [2], "there are 2 actions, expected 1"),
        ([4], [2], "the action is 4"),
        (0, [2], "the actions are 0"),
        ([0], None, "there are 1 actions, expected 5"),
    ],
)
def test_wrong_actions_and_numbers(opened: Any, actions: Any, numbers: Any, message: str) -> None:
    env = opened()
    env.reset(seed=0)
    with pytest.raises((BadArgument, gymnasium.error.InvalidAction), match=message):
        env.send(actions, numbers)
    assert not env._pool.ready.pending


def test_an_episode_that_there_is_not(opened: Any, processes: int) -> None:
    env = opened(processes)
    env.async_reset(options={"episode": ["0", "1", "0", "1", "99"]})
    with pytest.raises(BadArgument, match="there is no episode '99'"):
        play_on(env)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.send([0], [0])
    env.async_reset(seed=0)  # It goes on.
    assert env.recv()[4]["env_id"].shape == (ROWS,)


def test_a_process_that_dies_is_an_error(opened: Any) -> None:
    env = opened(2, COUNT)
    env.reset(seed=0)
    os.kill(env.process_ids[0], signal.SIGKILL)
    env.send([0] * COUNT)
    with pytest.raises(WorkerDied, match="ended with status -9"):
        play_on(env)


@pytest.mark.parametrize("context", multiprocessing.get_all_start_methods())
def test_processes_end_by_themselves_in_the_middle_of_a_batch(
    opened: Any, context: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also one that waits for a reader, as what it tells is larger than its pipe: here the last observations."""
    monkeypatch.setattr("arramon_client.environments.worker.JOIN_SECONDS", 100.0)  # On a busy machine, too.
    env = opened(3, 1, "SameStep", context=context, image_size=224, sensors=("rgb", "depth"), max_episode_steps=1)
    env.reset(seed=0)
    env.send([0] * COUNT)
    processes = [worker._process for worker in env._pool.workers]
    env.close()
    assert [process.exitcode for process in processes] == [0, 0]  # None was killed.


@pytest.mark.parametrize("size", [0, 6, 1.5, True, "2"])
def test_wrong_sizes(opened: Any, size: Any) -> None:
    with pytest.raises(BadArgument, match=r"batch_size is .*, expected None or 1 to num_envs, which is 5"):
        opened(1, size)


def test_without_batch_size(opened: Any) -> None:
    env = opened(1, None)
    env.reset(seed=0)
    with pytest.raises(BadArgument, match=r"send\(\) needs batch_size"):
        env.send([0], [0])
