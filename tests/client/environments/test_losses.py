"""Batches of which rows are lost, by an error or an interrupt: nothing waits for them, and all episodes begin anew."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from arramon_client.environments import BadArgument

COUNT, ROWS = 5, 2

WORKER = "arramon_client.environments.worker.Worker."


@pytest.fixture(params=[1, 2, 3])
def processes(request: pytest.FixtureRequest) -> int:
    return int(request.param)


@pytest.fixture
def opened(data: Path) -> Iterator[Callable[[int], Any]]:
    """Makes environments in a number of processes, and closes them in the end."""
    made: list[Any] = []

    def make(processes: int) -> Any:
        arguments: dict[str, Any] = {"data": data, "split": "tiny", "image_size": 16, "steps_per_phase": 3}
        arguments |= {"processes": processes, "batch_size": ROWS, "render_mode": "rgb_array"}
        made.append(gymnasium.make_vec("arramon/ArraMon-v0", COUNT, **arguments))
        return made[-1]

    yield make
    for env in made:
        env.close()


def play_on(env: Any) -> None:
    """Play without an end."""
    while True:
        *_, infos = env.recv()
        env.send([0] * len(infos["env_id"]), infos["env_id"])


def check_begins_anew(env: Any) -> None:
    """Nothing is waited for, nothing goes on, and all episodes can begin."""
    with pytest.raises(gymnasium.error.NoAsyncCallError, match="but 0 have a call"):
        env.recv()
    assert env.get_attr("render_mode") == ("rgb_array",) * COUNT  # Not what was left in a pipe.
    masked = {"options": {"reset_mask": np.arange(COUNT) == 1}}
    for name, arguments in (
        ("send", {"actions": [0], "env_id": [0]}),
        ("step", {"actions": [0] * COUNT}),
        ("reset", masked),
        ("async_reset", masked),
    ):
        with pytest.raises(gymnasium.error.ResetNeeded):
            getattr(env, name)(**arguments)
    env.async_reset(seed=0)
    assert env.recv()[4]["env_id"].shape == (ROWS,)
    assert env.reset(seed=0)[0]["steps_left"][:, 0].tolist() == [3] * COUNT


@pytest.mark.timeout(300)
@pytest.mark.parametrize("wrong", [0, COUNT - 1])
@pytest.mark.parametrize(
    "method",
    [
        play_on,
        lambda env: env.call("task"),
        lambda env: env.heads("run"),
        lambda env: env.render(),
        lambda env: env.set_attr("colour", 1),
    ],
    ids=["recv", "call", "heads", "render", "set_attr"],
)
def test_an_error(opened: Any, processes: int, method: Callable[[Any], None], wrong: int) -> None:
    """Whoever finds it, in whichever process it was."""
    env = opened(processes)
    env.async_reset(options={"episode": ["99" if number == wrong else "0" for number in range(COUNT)]})
    with pytest.raises(BadArgument, match="there is no episode '99'"):
        method(env)
    check_begins_anew(env)


@pytest.mark.timeout(300)
@pytest.mark.parametrize("place", ["arramon_dataset.environments.player.LocalPlayer.draw", WORKER + "play"])
def test_an_interrupt(opened: Any, place: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """While this process draws, or before all have been sent their calls."""
    env = opened(2)
    env.reset(seed=0)

    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    def send_and_play_on() -> None:
        env.send([0] * COUNT)
        play_on(env)  # The other process may be ready first, so that this one does not draw for the first batches.

    with monkeypatch.context() as patch:
        patch.setattr(place, interrupt)
        with pytest.raises(KeyboardInterrupt):
            send_and_play_on()
    check_begins_anew(env)


@pytest.mark.timeout(300)
def test_an_interrupt_while_the_losses_are_dropped(opened: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was not read then is no answer to what is asked later."""
    env = opened(2)
    env.async_reset(seed=0)

    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(WORKER + "_receive", interrupt)
        with pytest.raises(KeyboardInterrupt):
            env.async_reset(seed=0)
    check_begins_anew(env)
    assert env.get_attr("task") == ("navigation",) * COUNT
