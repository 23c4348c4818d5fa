"""The environment for LeRobot by its documented protocol, without LeRobot: Gymnasium's vector environments alone."""

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from arramon_client.adapters.lerobot import LeRobotEnv
from arramon_client.errors import ArramonClientError, UsageError
from tests import ROOT, tiny
from tests.serving import Server


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    data = tmp_path_factory.mktemp("data")
    tiny.write(data)
    tiny.write(data, "secret", 3, hidden=True)
    server = Server(data, "127.0.0.1:0", "--steps", "8")
    yield server
    assert server.stop() == 0


@pytest.fixture
def hub_module() -> ModuleType:
    """The file as LeRobot loads it from a repository on the Hub."""
    spec = importlib.util.spec_from_file_location("hub_env", ROOT / "deploy" / "lerobot" / "env.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_rollout_as_lerobot_makes_it(server: Server, hub_module: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ARRAMON_SERVER", server.address)
    monkeypatch.setenv("ARRAMON_SPLIT", "tiny")
    ((suite, tasks),) = hub_module.make_env(n_envs=2, use_async_envs=False).items()
    assert (suite, list(tasks)) == ("arramon", [0])
    env = tasks[0]
    observation, _ = env.reset(seed=[0, 1])
    assert (observation["pixels"].shape, observation["pixels"].dtype) == ((2, 224, 224, 3), np.uint8)
    assert (observation["agent_pos"].shape, observation["agent_pos"].dtype) == ((2, 3), np.float32)
    assert env.call("_max_episode_steps") == (32, 32)
    assert env.call("task_description") == ("Go on to the striped red mug.",) * 2
    info: dict[str, Any] = {}
    for action in tiny.ACTIONS:
        assert "final_info" not in info
        _, _, terminated, _, info = env.step(np.eye(4, dtype=np.float32)[[action, action]])
    assert terminated.tolist() == info["final_info"]["is_success"].tolist() == [True, True]
    assert [picture.shape for picture in env.call("render")] == [(224, 224, 3)] * 2
    env.close()


@pytest.mark.filterwarnings("ignore:.*A Box observation space m.*:UserWarning")
def test_gymnasium_finds_no_fault(server: Server) -> None:
    env = LeRobotEnv(split="tiny", server=server.address, image_size=128)
    check_env(env, skip_render_check=True)
    with pytest.raises(UsageError, match=r"the action has the shape \(3,\), expected \(4,\)"):
        env.step(np.zeros(3, np.float32))
    env.close()


def test_hidden_splits_are_refused(server: Server, tmp_path: Path) -> None:
    with pytest.raises(ArramonClientError, match="split 'secret' is hidden and can only be played whole"):
        LeRobotEnv(split="secret", server=server.address)
