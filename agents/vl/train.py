"""Imitation learning by teacher forcing: updates, checkpoints, validation by rollouts, choice of the best weights."""

import random
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import torch
from tensorboardX import SummaryWriter

from arramon_agents.training.batches import as_tokens, draw_text, epoch, loss_of, make_batch
from arramon_agents.training.card import card
from arramon_agents.training.demonstrations import Demonstration
from arramon_agents.training.precision import usable
from arramon_agents.training.rollouts import Plan, mean, play
from arramon_agents.training.sources import Tell, data_of, digest_of, splits_of
from arramon_agents.training.variants import Variants
from arramon_agents.vl.agent import LearnedAgent
from arramon_agents.vl.alignment import alignment_loss, other_texts
from arramon_agents.vl.model import PHASES, Model
from arramon_agents.vl.policy import Policy, save_policy
from arramon_agents.vl.recipe import Place, Recipe
from arramon_agents.vl.start import initial_policy
from arramon_agents.weights import SUFFIX, read_tensors, write_tensors

JUDGED = {"navigation": "nDTW", "assembly": "PTC"}
"""Metric of each phase for choosing the best weights; the ground truth plays the other phase in validation."""


class OtherRecipe(ValueError):
    """The output folder holds a checkpoint of another recipe."""


class Imitation:
    """One agent in training.

    Args:
        recipe: all settings.
        place: folders to read from and write to.
        demonstrations: of the expert.
        tell: receives lines of progress.

    Attributes:
        recipe: with a precision that the device has.
        step: number of updates so far.
        losses: of every update so far.
    """

    def __init__(
        self, recipe: Recipe, place: Place, demonstrations: Sequence[Demonstration], tell: Tell = lambda _: None
    ) -> None:
        torch.manual_seed(recipe.seed)
        recipe = replace(recipe, precision=usable(recipe.precision, place.device, tell))
        self.recipe, self.place, self.tell = recipe, place, tell
        self.demonstrations = demonstrations
        texts = [text for each in demonstrations for text in each.read_in(recipe.texts)]
        self.policy = initial_policy(recipe, texts, place, tell)
        self.optimizer = torch.optim.Adam(self.policy.model.parameters(), recipe.learning_rate)
        self.averaged = {name: value.clone() for name, value in self.policy.model.state_dict().items()}
        self._variants = Variants(
            demonstrations,
            recipe.texts if recipe.reads else (),
            recipe.variants,
            self.policy.encoder.channel_names if self.policy.encoder else None,
            recipe.seed,
        )
        self.step, self.losses = 0, list[float]()
        self.best: dict[str, float] = {}
        self._cpu, self._cpu_before = time.process_time(), 0.0
        self._orders: dict[tuple[str, int], list[list[int]]] = {}
        self._counts = {phase: len(self._order(phase, 0)) for phase in PHASES}
        self.steps = recipe.passes * (self._counts["navigation"] or self._counts["assembly"])

    @property
    def weights(self) -> Path:
        """The file of the best weights."""
        return self.place.output / f"{self.recipe.agent}{SUFFIX}"

    @property
    def checkpoint(self) -> Path:
        """The checkpoint from which training resumes."""
        return self.place.output / f"{self.recipe.agent}.checkpoint{SUFFIX}"

    def run(self) -> Policy:
        """Train to the end, resuming from a checkpoint if there is one, and return the best weights of each phase.

        Raises:
            OtherRecipe: if the checkpoint is of another recipe, or other demonstrations.
            BadWeights: if it cannot be read.
        """
        if self.checkpoint.exists():
            self.resume()
            self.tell(f"{self.recipe.agent}: goes on at update {self.step} of {self.steps}")
        log = SummaryWriter(str(self.place.output / "log" / self.recipe.agent), purge_step=self.step)
        begun, first = time.monotonic(), self.step
        self._cpu = time.process_time()
        while self.step < self.steps:
            losses = self.update()
            for phase, loss in losses.items():
                log.add_scalar(f"loss/{phase}", loss, self.step)
            if self.step % self.recipe.validate_steps == 0 or self.step == self.steps:
                for metric, value in self.validate().items():
                    log.add_scalar(f"validation/{metric}", value, self.step)
            if self.step % self.place.checkpoint_steps == 0 or self.step == self.steps:
                self.save()
                left = (time.monotonic() - begun) / (self.step - first) * (self.steps - self.step)
                recent = self.losses[-self.place.checkpoint_steps :]
                mean_loss = sum(recent) / len(recent)
                self.tell(
                    f"{self.recipe.agent}: update {self.step} of {self.steps}, loss {mean_loss:.3f}, "
                    f"{left / 60:.0f} minutes left"
                )
        log.close()
        return self._finish()

    def update(self) -> dict[str, float]:
        """Do one update on a batch of each phase, and return their losses."""
        recipe, model = self.recipe, self.policy.model.train()
        torch.manual_seed(recipe.seed * 1_000_003 + self.step)  # Of dropout: the same when training goes on.
        losses, apart = {}, {}
        for phase, count in self._counts.items():
            if not count:
                continue
            rows = self._order(phase, self.step // count)[self.step % count]
            chance = random.Random(f"{recipe.seed}/{phase}/{self.step}")  # noqa: S311 - not for secrets
            chosen = [self._variants.draw(row, chance) for row in rows]
            texts = [draw_text(each, recipe.languages, chance) for each in chosen]
            batch = make_batch(chosen, texts, self.policy.tokenizer, recipe.share, f"{recipe.seed}/{self.step}")
            batch, module = batch.to(self.place.device), model.of(phase)
            with torch.autocast(self.place.device, torch.bfloat16, enabled=recipe.precision == "bfloat16"):
                text = module.read(batch.tokens)
                values, _ = module.act(text, batch.cells, batch.before, at=batch.at)
                if recipe.align and recipe.reads:
                    rows, others = other_texts(chosen, texts, recipe.aligned, chance)
                    tokens = as_tokens(others, self.policy.tokenizer).to(self.place.device)
                    apart[f"{phase}/alignment"] = alignment_loss(text.of(rows), module.read(tokens))
            losses[phase] = loss_of(values.float(), batch, recipe.pick_up)
        total = torch.stack(list(losses.values())).mean()
        if apart:
            total = total + recipe.align * torch.stack(list(apart.values())).mean()
        self.optimizer.zero_grad()
        total.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(model.parameters(), recipe.clip)
        self.optimizer.step()
        self.step += 1
        self._average()
        self.losses.append(total.item())
        return {name: loss.item() for name, loss in (losses | apart).items()}

    def validate(self) -> dict[str, float]:
        """Play the validation episodes, keep the weights of each phase with a new best score, and return the scores."""
        recipe, model = self.recipe, self._averaged_model()
        if not recipe.validate_episodes:
            save_policy(replace(self.policy, model=model), self.weights)
            return {}
        size = self.policy.encoder.image_size if self.policy.encoder else 8
        plan = Plan(self.place.data, recipe.validate, recipe.languages, recipe.validate_episodes, size)
        found, best = {}, self._best_model()
        for phase, metric in JUDGED.items():
            agent = LearnedAgent(replace(self.policy, model=model), recipe.agent, temperature=recipe.temperature)
            found[metric] = mean(play(agent, replace(plan, phases=(phase,))), metric)
            if found[metric] > self.best.get(phase, -1.0):
                self.best[phase] = found[metric]
                best.of(phase).load_state_dict(model.of(phase).state_dict())
        self.policy.about["validation"] = dict(self.best)
        save_policy(replace(self.policy, model=best), self.weights)
        scores = ", ".join(f"{metric} {value:.3f}" for metric, value in found.items())
        self.tell(f"{recipe.agent}: validation after {self.step} updates: {scores}")
        return found

    def save(self) -> None:
        """Write a checkpoint."""
        tensors = {f"model.{name}": value.cpu() for name, value in self.policy.model.state_dict().items()}
        tensors |= {f"average.{name}": value.cpu() for name, value in self.averaged.items()}
        parameters = dict(self.policy.model.named_parameters())
        for name, parameter in parameters.items():
            for key, value in self.optimizer.state[parameter].items():
                tensors[f"adam.{key}.{name}"] = value.cpu()
        tensors["losses"] = torch.tensor(self.losses, dtype=torch.float64)
        header = {
            "recipe": self.recipe.as_json(),
            "step": self.step,
            "best": self.best,
            "cpu_seconds": self._cpu_seconds(),
            "data": digest_of(self.demonstrations),
        }
        write_tensors(self.checkpoint, tensors, header)

    def resume(self) -> None:
        """Resume from the last checkpoint.

        Raises:
            OtherRecipe: if it is of another recipe, or other demonstrations.
            BadWeights: if it cannot be read.
        """
        tensors, header = read_tensors(self.checkpoint)
        if header["recipe"] | self.recipe.without_effect() != self.recipe.as_json():
            raise OtherRecipe(f"{self.checkpoint} is of another recipe: name another --output, or remove it")
        if header["data"] != digest_of(self.demonstrations):
            raise OtherRecipe(f"{self.checkpoint} is of other demonstrations: name another --output, or remove it")
        model = self.policy.model
        model.load_state_dict({name[6:]: value for name, value in tensors.items() if name.startswith("model.")})
        for name, value in self.averaged.items():
            value.copy_(tensors[f"average.{name}"])
        for name, parameter in model.named_parameters():
            self.optimizer.state[parameter] = {
                key: tensors[f"adam.{key}.{name}"].to("cpu" if key == "step" else parameter.device)
                for key in ("step", "exp_avg", "exp_avg_sq")
                if f"adam.{key}.{name}" in tensors
            }
        self.step, self.losses, self.best = header["step"], tensors["losses"].tolist(), header["best"]
        self._cpu, self._cpu_before = time.process_time(), header["cpu_seconds"]

    def _cpu_seconds(self) -> float:
        return self._cpu_before + time.process_time() - self._cpu

    def _finish(self) -> Policy:
        """Write the best weights with their metadata and model card, and return them."""
        best = replace(self.policy, model=self._best_model())
        best.about |= {
            "data": data_of(self.demonstrations, splits_of(self.recipe.split, self.place.data)),
            "updates": self.step,
            "cpu_seconds": round(self._cpu_seconds()),
            "validation": dict(self.best),
        }
        save_policy(best, self.weights)
        self.weights.with_suffix(".md").write_text(card(best, self.recipe), encoding="utf-8")
        return best

    def _order(self, phase: str, number: int) -> list[list[int]]:
        if (phase, number) not in self._orders:
            sizes = {"navigation": self.recipe.batch, "assembly": self.recipe.room_batch}
            order = epoch(self.demonstrations, phase, sizes[phase], f"{self.recipe.seed}/{number}")
            self._orders = {key: value for key, value in self._orders.items() if key[0] != phase}
            self._orders[phase, number] = order
        return self._orders[phase, number]

    def _best_model(self) -> Model:
        """Return the model with the best weights of each phase so far."""
        if not (self.weights.exists() and self.best):
            return self._averaged_model().cpu()
        model = Model(self.policy.model.config)
        tensors, _ = read_tensors(self.weights)
        model.load_state_dict({name[6:]: value for name, value in tensors.items() if name.startswith("model.")})
        return model.eval()

    def _average(self) -> None:
        """Move the averaged weights towards the present ones; at first faster, as they begin at random."""
        kept = min(self.recipe.average, self.step / (self.step + 10.0))
        for name, value in self.policy.model.state_dict().items():
            if value.is_floating_point():
                self.averaged[name].lerp_(value, 1.0 - kept)
            else:
                self.averaged[name].copy_(value)

    def _averaged_model(self) -> Model:
        model = Model(self.policy.model.config).to(self.place.device)
        model.load_state_dict(self.averaged)
        return model.eval()
