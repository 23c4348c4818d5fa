"""The agent: arguments, weights, perfect perception, and an episode with each kind of perception."""

from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from arramon_agents.perception.eyes.encoder import load as load_eyes  # noqa: E402
from arramon_agents.perception.eyes.grid import CHANNEL_NAMES  # noqa: E402
from arramon_agents.reading.tokenizers import PolicyWordTokenizer  # noqa: E402
from arramon_agents.vl_grounded.network import (  # noqa: E402
    Grounded,
    GroundedWeights,
    read_weights,
    write_weights,
)
from arramon_agents.vl_grounded.perception import true_features  # noqa: E402
from arramon_agents.weights import BadWeights, find_weights, write_tensors  # noqa: E402
from arramon_client import load_agent  # noqa: E402
from arramon_client.agent import Episode, Label, Observation, actions_of  # noqa: E402
from arramon_client.environments.backend import PlayerSettings  # noqa: E402
from arramon_client.environments.options import Options  # noqa: E402
from arramon_client.environments.players import open_backend  # noqa: E402
from arramon_client.errors import AgentLoadError  # noqa: E402
from tests import tiny  # noqa: E402

WORDS = PolicyWordTokenizer(["go", "mug", "बाएँ"])


def made(eyes: str) -> GroundedWeights:
    torch.set_num_threads(1)
    torch.manual_seed(1)
    return GroundedWeights(Grounded(WORDS.size).eval(), WORDS, eyes, {"known": "nothing"})


@pytest.fixture(scope="module")
def weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Untrained."""
    path = tmp_path_factory.mktemp("weights") / "grounded.safetensors"
    write_weights(path, made(load_eyes().fingerprint))
    return path


def test_weights_are_what_was_written(weights: Path) -> None:
    again, written = read_weights(weights), made("")
    tokens = torch.tensor([again.tokenizer.encode("बाएँ mug go")])
    assert tokens.tolist() == [WORDS.encode("बाएँ mug go")]
    torch.testing.assert_close(again.network.reading(tokens), written.network.reading(tokens), rtol=0.02, atol=0.02)
    assert again.about == {"known": "nothing"}
    assert weights.stat().st_size < 3_500_000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"sensor": "lidar"}, "agents.vl_grounded has no sensor 'lidar'; expected one of rgb, segmentation"),
        ({"weights": "nowhere.safetensors"}, "agents.vl_grounded: there are no weights 'nowhere.safetensors'"),
    ],
)
def test_what_is_wrong_is_told(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(AgentLoadError, match=message):
        load_agent("agents.vl_grounded", arguments)


def test_other_files_are_refused(tmp_path: Path) -> None:
    tokenizer = {"tokenizer": torch.zeros(1, dtype=torch.uint8)}
    header = {"format": "vl_grounded 1", "tokenizer": "word", "vocabulary": 9, "eyes": "", "about": {}}
    for given, message in (
        ({"format": 1}, "has the format 1, expected 'vl_grounded 1'"),
        (header, "does not hold the weights of agents.vl_grounded: it has no tensor reading"),
    ):
        write_tensors(tmp_path / "w.safetensors", tokenizer, given)
        with pytest.raises(BadWeights, match=message):
            read_weights(tmp_path / "w.safetensors")


def test_weights_of_another_encoder_are_refused(tmp_path: Path) -> None:
    write_weights(tmp_path / "w.safetensors", made("eyes-0"))
    with pytest.raises(AgentLoadError, match="were trained on the visual encoder eyes-0, but eyes-"):
        load_agent("agents.vl_grounded", {"weights": str(tmp_path / "w.safetensors")})


def test_what_perfect_eyes_see() -> None:
    labels = (Label("nothing"), Label("mug", "red", "dotted"), Label("building", "", "brick"))
    segmentation = np.zeros((112, 112), np.uint16)
    depth = np.zeros((112, 112), np.float32)
    segmentation[64:80, 48:64], depth[64:80, 48:64] = 1, 3.0
    segmentation[:16, :16], depth[:16, :16] = 2, 9.0
    found = true_features(depth, segmentation, labels)
    shown = {
        (row, column): {CHANNEL_NAMES[number]: round(float(found[row, column, number]), 2) for number in numbers}
        for row, column in ((4, 3), (0, 0))
        for numbers in [np.flatnonzero(found[row, column])]
    }
    assert shown[4, 3] == {
        "kind:mug": 1, "colour:red": 1, "pattern:dotted": 1, "collectible": 1, "nearness of collectible": 0.25,
        "nearness": 0.25, "mean nearness": 0.25,
    }  # fmt: skip
    assert shown[0, 0] == {"facade:brick": 1, "nearness": 0.1, "mean nearness": 0.1}


@pytest.mark.parametrize(("sensor", "language"), [("rgb", "hi"), ("segmentation", "en")])
def test_an_episode(sensor: str, language: str, weights: Path, tmp_path: Path) -> None:
    tiny.write(tmp_path, "trial", 2)
    agent = load_agent("agents.vl_grounded", {"weights": str(weights), "sensor": sensor})
    sensors = ("rgb", "depth") if sensor == "rgb" else ("depth", "segmentation")
    assert getattr(agent, "sensors", None) == sensors
    player = open_backend(Options(data=tmp_path)).player(
        PlayerSettings(language, "trial", sensors, 224, steps_per_phase=30)
    )
    observation: Observation | None = player.begin("1", 0)
    agent.begin(Episode("1", language, "trial", labels=player.labels))
    placed = set()
    while observation is not None:
        (action,) = actions_of(agent.act([observation]))
        if (observation.phase, action) == ("assembly", 3):
            placed.add(observation.turn)
        observation = player.step(action).observation
    assert placed == {1, 2}


def test_without_a_sensor_it_says_which(weights: Path) -> None:
    agent = load_agent("agents.vl_grounded", {"weights": str(weights)})
    agent.begin(Episode("1", "en", "trial"))
    with pytest.raises(ValueError, match="requires the sensors rgb and depth; this run does not have rgb"):
        agent.act([Observation("1", 1, "navigation", 0, "go", 0, 150)])


def test_the_weights_that_come_along_are_of_the_eyes_that_come_along() -> None:
    agent = load_agent("agents.vl_grounded")
    assert getattr(agent, "sensors", None) == ("rgb", "depth")
    found = read_weights(find_weights("vl_grounded"))
    unknown = found.tokenizer.encode("xyzzy")[0]
    for text in ("pick up the dotted red mug", "बिंदीदार लाल मग उठाएँ"):
        assert unknown not in found.tokenizer.encode(text)
