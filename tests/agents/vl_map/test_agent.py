"""The agent: arguments, weights, and an episode with each kind of perception."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from arramon_agents.vl_map.network import MASKED_LOGIT, PolicyNetwork, PolicySizes, batch_of, sizes_of  # noqa: E402
from arramon_agents.vl_map.options import WAYPOINTS  # noqa: E402
from arramon_agents.vl_map.placement_network import PlacementNetwork  # noqa: E402
from arramon_agents.vl_map.policy import MapPolicy, Networks, read_policy, write_policy  # noqa: E402
from arramon_agents.weights import CARD, BadWeights, find_weights, write_tensors  # noqa: E402
from arramon_client import load_agent  # noqa: E402
from arramon_client.agent import Answer, Episode, Observation, actions_of  # noqa: E402
from arramon_client.environments.backend import PlayerSettings  # noqa: E402
from arramon_client.environments.options import Options  # noqa: E402
from arramon_client.environments.players import open_backend  # noqa: E402
from arramon_client.errors import AgentLoadError  # noqa: E402
from arramon_client.notes import note_fault, note_text  # noqa: E402
from tests import tiny  # noqa: E402
from tests.agents.vl_map.test_features import sample  # noqa: E402


@pytest.fixture(scope="module")
def weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Untrained."""
    torch.set_num_threads(1)
    torch.manual_seed(1)
    path = tmp_path_factory.mktemp("weights") / "policy.safetensors"
    write_policy(path, Networks([PolicyNetwork(PolicySizes())], PlacementNetwork()), {"known": "nothing"})
    return path


def test_weights_are_what_was_written(weights: Path) -> None:
    networks, about = read_policy(weights)
    torch.manual_seed(1)
    written = PolicyNetwork(PolicySizes()).eval()
    given = batch_of([sample()[0]])
    torch.testing.assert_close(networks.policies[0](given), written(given), rtol=0.02, atol=0.02)  # Half precision.
    assert about == {"known": "nothing"}
    assert weights.stat().st_size < 400_000


def test_the_policies_of_a_file_are_averaged(tmp_path: Path) -> None:
    torch.manual_seed(1)
    written = [PolicyNetwork(sizes).eval() for sizes in (PolicySizes(), PolicySizes(), sizes_of(32, 2))]
    write_policy(tmp_path / "three.safetensors", Networks(written, PlacementNetwork()), {})
    policies = read_policy(tmp_path / "three.safetensors")[0].policies
    given, beliefs = sample()
    alone = [MapPolicy([policy]).option_values(given, beliefs) for policy in policies]
    averaged = MapPolicy(policies).option_values(given, beliefs)
    np.testing.assert_allclose(averaged, np.mean(alone, 0), rtol=1e-4, atol=1e-4)
    assert np.abs(averaged - alone[0]).max() > 1e-3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"sensor": "lidar"}, "agents.vl_map has no sensor 'lidar'; expected one of rgb, segmentation"),
        ({"weights": "nowhere.safetensors"}, "agents.vl_map: there are no weights 'nowhere.safetensors'"),
    ],
)
def test_what_is_wrong_is_told(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(AgentLoadError, match=message):
        load_agent("agents.vl_map", arguments)


def test_other_files_are_refused(tmp_path: Path) -> None:
    tensors = {"go.weight": torch.zeros(5, 64)}
    for header, message in (
        ({"format": 1}, "has the format 1, expected 'vl_map 2'"),
        (
            {"format": "vl_map 2", "sizes": {}, "about": {}},
            "the weights of agents.vl_map: it has no tensor policy",
        ),
        (
            {"format": "vl_map 2", "sizes": {}, "policies": 17, "about": {}},
            "its header has 17 policies, expected 1 to 16",
        ),
    ):
        write_tensors(tmp_path / "w.safetensors", tensors, header)
        with pytest.raises(BadWeights, match=message):
            read_policy(tmp_path / "w.safetensors")


@pytest.mark.parametrize(("sensor", "language"), [("rgb", "en"), ("rgb", "hi"), ("segmentation", "en")])
def test_an_episode(sensor: str, language: str, weights: Path, tmp_path: Path) -> None:
    tiny.write(tmp_path, "trial", 2)
    agent = load_agent("agents.vl_map", {"weights": str(weights), "sensor": sensor})
    sensors = ("rgb", "depth") if sensor == "rgb" else ("depth", "segmentation")
    backend = open_backend(Options(data=tmp_path))
    player = backend.player(PlayerSettings(language, "trial", sensors, 224, steps_per_phase=30))
    observation: Observation | None = player.begin("1", 0)
    agent.begin(Episode("1", language, "trial", labels=player.labels))
    phases, actions, notes = set(), [], list[Any]()
    while observation is not None:
        phases.add((observation.turn, observation.phase))
        (answer,) = agent.act([observation])
        if isinstance(answer, Answer):
            notes.append(answer.note)
        (action,) = actions_of([answer])
        actions.append(action)
        step = player.step(action)
        observation = step.observation
    assert step.ending is not None
    assert phases == {(turn, phase) for turn in (1, 2) for phase in ("navigation", "assembly")}
    assert actions[:12] == [2] * 12  # It looks around.
    assert 0 in actions
    read = [note["read"].keys() & {"target", "thing"} for note in notes if "read" in note]
    assert read == 2 * [{"target"}, {"thing"}]
    assert any(len(note.get("goal", ())) == 2 for note in notes)
    assert all(not note_fault(note_text(note)) for note in notes)


def test_weights_come_along() -> None:
    networks, about = read_policy(find_weights("vl_map"))
    assert about["recipe"]["languages"] == ["en", "hi"]
    given, beliefs = sample()
    values = networks.policies[0](batch_of([given]))[0]
    assert values[WAYPOINTS + [each.mark.label.kind for each in beliefs].index("mug")] > MASKED_LOGIT
    card = find_weights("vl_map").with_name(CARD).read_text(encoding="utf-8")
    assert f"{about['parameters']:,} parameters" in card
    assert about["data_hash"][:12] in card


def test_missing_sensors_are_named(weights: Path) -> None:
    agent = load_agent("agents.vl_map", {"weights": str(weights)})
    agent.begin(Episode("one", "en", "trial"))
    with pytest.raises(ValueError, match="requires the sensors rgb and depth"):
        agent.act([Observation("one", 1, "navigation", 0, "Turn left and take the red mug.", 0, 150)])
    agent = load_agent("agents.vl_map", {"weights": str(weights), "sensor": "segmentation"})
    with pytest.raises(ValueError, match="requires the sensor segmentation"):
        agent.begin(Episode("one", "en", "trial"))
