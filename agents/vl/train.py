"""Training of the paper's models: imitation of the expert, validation by rollouts, weights and model card."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from arramon_agents.process_settings import prepare_process
from arramon_agents.training.checkpoint import TrainingInputs, check_recipe
from arramon_agents.training.demonstrations import (
    DemonstrationSource,
    PhaseDemonstration,
    data_hash_of,
    without_features,
)
from arramon_agents.training.precision import usable_precision
from arramon_agents.training.recipe import update_settings
from arramon_agents.training.rollouts import RolloutPlan, check_validation, mean, play
from arramon_agents.training.schedule import constant
from arramon_agents.training.sources import describe_data, digest_of, load_demonstrations, sources_of, splits_of
from arramon_agents.training.trainer import Scores, Trainer, TrainerSettings
from arramon_agents.training.workspace import Report, Workspace
from arramon_agents.vl.agent import LearnedAgent
from arramon_agents.vl.card import card
from arramon_agents.vl.initial_policy import initial_policy
from arramon_agents.vl.model import Model
from arramon_agents.vl.policy import VlPolicy, save_policy
from arramon_agents.vl.recipe import Recipe
from arramon_agents.vl.task import ImitationTask
from arramon_agents.weights import SUFFIX

CHOSEN_BY = {"navigation": "nDTW", "assembly": "PTC"}
"""Metric of each phase by which the best weights are chosen; in validation, the ground truth plays the other phase."""

PHASE_PREFIX = "modules_by_phase.{phase}."
"""Prefix of the tensor names of a phase's module."""


def train(recipe: Recipe, workspace: Workspace, report: Report) -> Path:
    """Train an agent, resuming from a checkpoint if there is one; return the path of the weights.

    The model card is written to the same folder.

    Raises:
        UsageError: if the data folder does not have what the recipe names, the split for validation included.
        ValueError: if the output folder holds a checkpoint of another recipe or other data.
    """
    prepare_process()
    recipe = replace(recipe, precision=usable_precision(recipe.precision, workspace.device, report))
    check_recipe(workspace.output, recipe.agent, settings_of(recipe))
    data_hash = data_hash_of(DemonstrationSource(workspace.data, recipe.split, recipe.languages, "", 0))
    check_validation(workspace.data, recipe.validate, recipe.languages, recipe.validate_episodes)
    demonstrations = demonstrations_of(recipe, workspace, report)
    imitation = Imitation(recipe, workspace, demonstrations, report)
    imitation.policy.about["data_hash"] = data_hash
    size = sum(parameter.numel() for parameter in imitation.policy.model.parameters())
    report(f"{recipe.agent}: {len(demonstrations)} demonstrations, {size:,} parameters, on {workspace.device}")
    imitation.run()
    if imitation.best:
        best = ", ".join(f"{CHOSEN_BY[phase]} {value:.3f}" for phase, value in imitation.best.items())
        report(f"{recipe.agent}: best {best}")
    return imitation.weights


def settings_of(recipe: Recipe) -> dict[str, Any]:
    """Return the settings that must be those of a checkpoint to resume from it; the number of epochs may grow."""
    return update_settings(replace(recipe, passes=0))


def demonstrations_of(recipe: Recipe, workspace: Workspace, report: Report) -> list[PhaseDemonstration]:
    """Return the demonstrations of a recipe, without image features if the model does not see.

    Raises:
        UsageError: if the data folder does not have what the recipe names.
    """
    split = DemonstrationSource(
        workspace.data, recipe.split, recipe.texts, recipe.encoder, recipe.episodes, every=recipe.every
    )
    drawn = load_demonstrations(sources_of(split, recipe.rooms), workspace, report)
    return [each if recipe.sees else without_features(each) for each in drawn]


class Imitation:
    """Imitation learning of one agent.

    Args:
        recipe: all settings.
        workspace: folders to read from and write to.
        demonstrations: of the expert.
        report: receives lines of progress.

    Attributes:
        recipe: with a precision that the device has.
        policy: in training.
        trainer: the loop.
    """

    def __init__(
        self,
        recipe: Recipe,
        workspace: Workspace,
        demonstrations: Sequence[PhaseDemonstration],
        report: Report = lambda _: None,
    ) -> None:
        torch.manual_seed(recipe.seed)
        recipe = replace(recipe, precision=usable_precision(recipe.precision, workspace.device, report))
        self.recipe, self._workspace, self._report, self._demonstrations = recipe, workspace, report, demonstrations
        texts = [text for each in demonstrations for text in each.texts_in(recipe.texts)]
        self.policy = initial_policy(recipe, texts, workspace, report)
        task = ImitationTask(recipe, self.policy, demonstrations, workspace.device)
        settings = TrainerSettings(
            recipe.agent,
            task.steps,
            constant(recipe.learning_rate),
            recipe.seed,
            clip=recipe.clip,
            average=recipe.average,
            validate_steps=recipe.validate_steps,
            checkpoint_steps=workspace.checkpoint_steps,
            chosen_by={PHASE_PREFIX.format(phase=phase): metric for phase, metric in CHOSEN_BY.items()},
            training_inputs=TrainingInputs(settings_of(recipe), digest_of(demonstrations)),
        )
        self.trainer = Trainer(task, settings, workspace.output, report, self._validate, self._write)

    @property
    def weights(self) -> Path:
        """The file of the best weights."""
        return self._workspace.output / f"{self.recipe.agent}{SUFFIX}"

    @property
    def best(self) -> dict[str, float]:
        """Best score of each phase so far."""
        return {phase: self.trainer.scores[name] for phase, name in CHOSEN_BY.items() if name in self.trainer.scores}

    def run(self) -> VlPolicy:
        """Train to the end, resuming from a checkpoint if there is one; write and return the best weights.

        Raises:
            CheckpointMismatch: if the checkpoint belongs to another recipe or other demonstrations.
            BadWeights: if it cannot be read.
        """
        self.trainer.run()
        self.policy.about |= {
            "data": describe_data(self._demonstrations, splits_of(self.recipe.split, self._workspace.data)),
            "updates": self.trainer.step,
            "cpu_seconds": round(self.trainer.cpu_seconds),
        }
        policy = self._write()
        self.weights.with_suffix(".md").write_text(card(policy, self.recipe), encoding="utf-8")
        return policy

    def _validate(self) -> Scores:
        """Play the validation episodes, once per phase with the ground truth in the other phase; return the scores."""
        recipe = self.recipe
        if not recipe.validate_episodes:
            return {}
        size = self.policy.encoder.image_size if self.policy.encoder else 8
        plan = RolloutPlan(self._workspace.data, recipe.validate, recipe.languages, recipe.validate_episodes, size)
        scores = {}
        for phase, metric in CHOSEN_BY.items():
            agent = LearnedAgent(
                self._policy_with(self.policy.model.state_dict()), recipe.agent, temperature=recipe.temperature
            )
            scores[metric] = mean(play(agent, replace(plan, phases=(phase,))), metric)
        summary = ", ".join(f"{metric} {value:.3f}" for metric, value in scores.items())
        self._report(f"{recipe.agent}: validation after {self.trainer.step} updates: {summary}")
        return scores

    def _write(self) -> VlPolicy:
        """Write the best weights so far, and return them."""
        self.policy.about["validation"] = self.best
        policy = self._policy_with(self.trainer.weights())
        save_policy(policy, self.weights)
        return policy

    def _policy_with(self, weights: Mapping[str, Tensor]) -> VlPolicy:
        """Return the policy with these weights, on the CPU, in evaluation mode."""
        model = Model(self.policy.model.config)
        model.load_state_dict(weights)
        return replace(self.policy, model=model.eval())
