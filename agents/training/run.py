"""A training run with a log and saved states from which it resumes."""

import json
import logging
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from arramon_agents.training.trainer import Trainer

LOG = logging.getLogger(__name__)

EVERY_STEPS, TELL_STEPS, SAVE_SECONDS = 50, 250, 120.0
"""Steps between two log lines, steps between two tests, seconds between two saved states."""


def train(trainer: Trainer, folder: Path, name: str, tell: Callable[[], Mapping[str, object]] | None = None) -> None:
    """Train to the end of the plan; save the state every few minutes, and at the end.

    Args:
        trainer: with network and plan.
        folder: for `NAME.state.safetensors`, from which training resumes if it exists, and `NAME.log.jsonl`.
        name: of the files.
        tell: tests the network, and returns more fields for the log.
    """
    plan, state, losses = trainer.plan, folder / f"{name}.state.safetensors", []
    if state.exists():
        trainer.restore(state)
        LOG.info("%s: going on after %d of %d steps", name, trainer.done, plan.steps)
    saved = began = time.monotonic()
    first = trainer.done
    with (folder / f"{name}.log.jsonl").open("a") as log:
        while trainer.done < plan.steps:
            losses.append(trainer.step())
            entry: dict[str, object] = {}
            if trainer.done % EVERY_STEPS == 0 or trainer.done == plan.steps:
                mean = sum(losses) / len(losses)
                entry = {"step": trainer.done, "loss": round(mean, 5), "seconds": round(trainer.seconds, 1)}
                losses.clear()
                left = (time.monotonic() - began) / (trainer.done - first) * (plan.steps - trainer.done)
                LOG.info("%s: step %d of %d, loss %.3f, %d s left", name, trainer.done, plan.steps, mean, left)
            if time.monotonic() - saved > SAVE_SECONDS or trainer.done == plan.steps:
                trainer.save(state)
                saved = time.monotonic()
            if tell and (trainer.done % TELL_STEPS == 0 or trainer.done == plan.steps):
                entry |= {"step": trainer.done, **tell()}
            if entry:
                log.write(json.dumps(entry) + "\n")
                log.flush()
