"""Training task of the paper's models: imitate the expert's actions in both phases, by teacher forcing."""

import random
from collections.abc import Sequence

import torch
from torch import Tensor

from arramon_agents.training.batches import EpochBatches
from arramon_agents.training.demonstrations import PhaseDemonstration
from arramon_agents.training.trainer import Loss
from arramon_agents.training.variants import Variants
from arramon_agents.vl.alignment import alignment_loss, other_texts
from arramon_agents.vl.batches import action_loss, draw_text, make_batch, tokenize_batch
from arramon_agents.vl.model import Model
from arramon_agents.vl.policy import VlPolicy
from arramon_agents.vl.recipe import Recipe
from arramon_client.world import PHASES


class ImitationTask:
    """Batches of demonstrations of both phases, and the loss of the expert's actions.

    Args:
        recipe: all training settings.
        policy: policy with the model to train.
        demonstrations: demonstrations of the expert.
        device: device of the model.

    Attributes:
        network: the model.
        steps: number of updates: `recipe.passes` epochs of the navigation demonstrations, or of the assembly
            demonstrations if there are no others.
    """

    def __init__(
        self, recipe: Recipe, policy: VlPolicy, demonstrations: Sequence[PhaseDemonstration], device: str
    ) -> None:
        self.network: Model = policy.model
        self._recipe, self._tokenizer, self._device = recipe, policy.tokenizer, device
        self._variants = Variants(
            demonstrations,
            recipe.texts if recipe.reads else (),
            recipe.variants,
            policy.encoder.channel_names if policy.encoder else None,
            recipe.seed,
        )
        sizes = dict(zip(PHASES, (recipe.batch, recipe.room_batch), strict=True))
        epochs = {phase: EpochBatches(demonstrations, phase, size, recipe.seed) for phase, size in sizes.items()}
        self._epochs = {phase: each for phase, each in epochs.items() if each.count}
        self.steps = recipe.passes * (next(iter(self._epochs.values())).count if self._epochs else 0)

    def loss(self, step: int) -> Loss:
        """Return the mean loss of a batch of each phase, plus the weighted alignment loss."""
        phases, alignments = dict[str, Tensor](), dict[str, Tensor]()
        for phase, epochs in self._epochs.items():
            phases[phase], aligned = self._phase_loss(phase, epochs.batch(step), step)
            if aligned is not None:
                alignments[f"{phase}/alignment"] = aligned
        total = torch.stack(list(phases.values())).mean()
        if alignments:
            total = total + self._recipe.align * torch.stack(list(alignments.values())).mean()
        return Loss(total, phases | alignments)

    def _phase_loss(self, phase: str, rows: Sequence[int], step: int) -> tuple[Tensor, Tensor | None]:
        """Return the action loss of a batch of one phase, and its alignment loss if the recipe has one.

        Args:
            phase: phase of the demonstrations.
            rows: indices of the demonstrations.
            step: number of the update; it seeds the choice of texts and variants.
        """
        recipe, model = self._recipe, self.network.of(phase)
        chance = random.Random(f"{recipe.seed}/{phase}/{step}")  # noqa: S311 - not for secrets
        chosen = [self._variants.draw(row, chance) for row in rows]
        texts = [draw_text(each, recipe.languages, chance) for each in chosen]
        batch = make_batch(chosen, texts, self._tokenizer, recipe.share, f"{recipe.seed}/{step}").to(self._device)
        aligned = None
        with torch.autocast(self._device, torch.bfloat16, enabled=recipe.precision == "bfloat16"):
            text = model.read(batch.tokens)
            logits, _ = model.act(text, batch.cells, batch.previous_actions, selected_steps=batch.loss_steps)
            if recipe.align and recipe.reads:
                paired, others = other_texts(chosen, texts, recipe.aligned, chance)
                tokens = tokenize_batch(others, self._tokenizer).to(self._device)
                aligned = alignment_loss(text.of(paired), model.read(tokens))
        return action_loss(logits.float(), batch, recipe.pick_up), aligned
