"""Imitation learning: it learns, resumes exactly after a kill, and keeps the best weights of each phase."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from arramon_agents.training import precision
from arramon_agents.training.checkpoint import CheckpointMismatch
from arramon_agents.training.precision import has_bfloat16
from arramon_agents.training.rollouts import RolloutPlan
from arramon_agents.vl import train as imitation
from arramon_agents.vl.agent import LearnedAgent
from arramon_agents.vl.policy import load_policy
from arramon_agents.vl.train import Imitation, demonstrations_of
from tests import tiny
from tests.agents.training_fixtures import demonstrations, place, recipe


@pytest.mark.parametrize(("sees", "reads"), [(True, True), (True, False), (False, True)])
def test_it_learns(tmp_path: Path, sees: bool, reads: bool) -> None:
    made = Imitation(recipe(sees=sees, reads=reads, passes=40), place(tmp_path), demonstrations())
    made.run()
    assert len(made.trainer.losses) == made.trainer.settings.steps == 120
    assert sum(made.trainer.losses[-5:]) < sum(made.trainer.losses[:5]) / 3


def test_after_a_kill_the_losses_are_as_undisturbed(tmp_path: Path) -> None:
    shown = demonstrations()
    undisturbed = Imitation(recipe(), place(tmp_path / "one", checkpoint_steps=2), shown)
    undisturbed.run()
    killed = Imitation(recipe(), place(tmp_path / "two", checkpoint_steps=2), shown)
    for _ in range(4):
        killed.trainer.update()
    killed.trainer.save()
    killed.trainer.update()  # Lost: it was not in the checkpoint.
    torch.manual_seed(99)
    resumed = Imitation(recipe(), place(tmp_path / "two", checkpoint_steps=2), shown)
    resumed.run()
    assert resumed.trainer.losses == undisturbed.trainer.losses
    for one, other in zip(undisturbed.policy.model.parameters(), resumed.policy.model.parameters(), strict=True):
        assert torch.equal(one, other)


def test_another_recipe_does_not_go_on(tmp_path: Path) -> None:
    first = Imitation(recipe(), place(tmp_path), demonstrations())
    first.trainer.save()
    second = Imitation(replace(recipe(), learning_rate=0.1), place(tmp_path), demonstrations())
    with pytest.raises(CheckpointMismatch, match=r"another recipe \(learning_rate 0.001, expected 0.1\): name another"):
        second.run()


def test_other_demonstrations_do_not_go_on(tmp_path: Path) -> None:
    Imitation(recipe(), place(tmp_path), demonstrations()).trainer.save()
    with pytest.raises(CheckpointMismatch, match="is of other data"):
        Imitation(recipe(), place(tmp_path), demonstrations(count=8)).run()


def test_longer_training_goes_on_as_if_it_had_been_meant_to(tmp_path: Path) -> None:
    shown = demonstrations()
    long = Imitation(recipe(passes=4), place(tmp_path / "long"), shown)
    long.run()
    Imitation(recipe(passes=2), place(tmp_path / "two"), shown).run()
    longer = Imitation(recipe(passes=4), place(tmp_path / "two"), shown)
    longer.run()
    assert longer.trainer.losses == long.trainer.losses


def test_of_steps_that_repeat_an_action_a_share_is_learned_from(tmp_path: Path) -> None:
    every = Imitation(replace(recipe(), share=1.0), place(tmp_path), demonstrations())
    some = Imitation(replace(recipe(), share=0.3), place(tmp_path), demonstrations())
    assert every.trainer.update() != some.trainer.update()


def test_the_best_weights_of_each_phase_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of three validations, the second is best in the street, the first in the room."""
    values = {"navigation": iter([0.1, 0.3, 0.2]), "assembly": iter([0.5, 0.4, 0.4])}

    def play(agent: LearnedAgent, plan: RolloutPlan) -> dict[str, Mapping[str, float]]:
        value = next(values[plan.phases[0]])
        return {"1": {"nDTW": value, "PTC": value}}

    monkeypatch.setattr(imitation, "play", play)
    made = Imitation(recipe(validate=1), place(tmp_path), demonstrations())
    kept = []
    for _ in range(3):
        made.trainer.update()
        made.trainer.validate()
        kept.append({name: value.clone() for name, value in made.policy.model.state_dict().items()})
    best = load_policy(made.weights)
    assert best.about["validation"] == {"navigation": 0.3, "assembly": 0.5}
    for name, value in best.model.state_dict().items():
        assert torch.equal(value, kept[1 if ".navigation." in name else 0][name]), name


def test_it_learns_in_less_precision_or_says_that_the_processor_cannot(tmp_path: Path) -> None:
    told: list[str] = []
    made = Imitation(replace(recipe(passes=40), precision="bfloat16"), place(tmp_path), demonstrations(), told.append)
    assert made.recipe.precision == ("bfloat16" if has_bfloat16("cpu") else "float32")
    assert ("this processor has no bfloat16: training in float32, which takes longer" in told) != has_bfloat16("cpu")
    made.run()
    assert sum(made.trainer.losses[-5:]) < sum(made.trainer.losses[:5]) / 3
    assert {value.dtype for value in made.policy.model.state_dict().values()} == {torch.float32}


@pytest.mark.parametrize(
    ("has", "wanted", "used"),
    [(True, "bfloat16", "bfloat16"), (True, "float32", "float32"), (False, "float32", "float32")],
)
def test_a_precision_that_the_device_has_is_used(
    monkeypatch: pytest.MonkeyPatch, has: bool, wanted: str, used: str
) -> None:
    told: list[str] = []
    monkeypatch.setattr(precision, "has_bfloat16", lambda _device: has)
    assert precision.usable_precision(wanted, "cpu", told.append) == used
    assert not told


def test_a_precision_that_the_device_lacks_is_not_used_and_that_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[str] = []
    monkeypatch.setattr(precision, "has_bfloat16", lambda _device: False)
    assert precision.usable_precision("bfloat16", "cpu", told.append) == "float32"
    (line,) = told
    assert "no bfloat16" in line


def test_an_unknown_precision_is_named() -> None:
    with pytest.raises(ValueError, match="there is no precision 'float16'; there are float32, bfloat16"):
        replace(recipe(), precision="float16")


def test_averaged_weights_are_kept_and_change_no_update(tmp_path: Path) -> None:
    shown = demonstrations()
    plain = Imitation(recipe(), place(tmp_path / "plain"), shown)
    plain.run()
    averaged = Imitation(replace(recipe(), average=0.8), place(tmp_path / "averaged", checkpoint_steps=2), shown)
    name, passed = "modules_by_phase.navigation.output.weight", []
    begun = averaged.policy.model.state_dict()[name].clone()
    for _ in range(4):
        averaged.trainer.update()
        passed.append(averaged.policy.model.state_dict()[name].clone())
    averaged.trainer.save()
    expected = begun
    for number, weight in enumerate(passed, start=1):
        kept = min(0.8, number / (number + 10.0))
        expected = kept * expected + (1.0 - kept) * weight
    torch.testing.assert_close(averaged.trainer.weights()[name], expected)
    resumed = Imitation(replace(recipe(), average=0.8), place(tmp_path / "averaged", checkpoint_steps=2), shown)
    resumed.run()
    assert resumed.trainer.losses == plain.trainer.losses
    shipped = load_policy(resumed.weights).model.state_dict()
    assert torch.equal(shipped[name], resumed.trainer.weights()[name])
    assert not torch.equal(shipped[name], resumed.policy.model.state_dict()[name])


def test_a_model_without_sight_learns_from_demonstrations_without_features(tmp_path: Path) -> None:
    tiny.write(tmp_path, "train")
    blind = replace(recipe(sees=False), rooms=0, episodes=2)
    found = demonstrations_of(blind, place(tmp_path, tmp_path), print)
    assert len(found) == 2 * 4  # Episodes, and in each two turns of two phases.
    assert found[0].features.shape[-1] == 0
