"""Train the visual encoder on frames with labels: `python -m arramon_agents.perception.eyes.train`.

It trains two networks, "blocks" and "naming", one after the other or the one that is asked for. For each, the folder
gets `NAME.state.safetensors`, from which it goes on when it is started again, and `NAME.log.jsonl`; at the end
`vision_eyes.safetensors` holds the weights of both.
"""

import argparse
import logging
from collections.abc import Callable
from pathlib import Path

import torch

from arramon_agents.perception.eyes.encoder import write_weights
from arramon_agents.perception.eyes.naming import NamingNetwork
from arramon_agents.perception.eyes.network import EyesNetwork, Sizes
from arramon_agents.perception.eyes.targets import LabelTable
from arramon_agents.perception.eyes.tasks import BlocksTask, NamingTask
from arramon_agents.simulated.frames import FrameSource, label_names
from arramon_agents.training.run import train
from arramon_agents.training.trainer import Plan, Task, Trainer

SECTIONS = ("1", "2", "3", "4", "5")
"""Sections of the training splits."""

NAMES = ("blocks", "naming")


def main() -> None:
    """Train, or go on training."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    options = _options()
    torch.set_num_threads(options.threads)
    options.out.mkdir(parents=True, exist_ok=True)
    sections = [(section, str(city)) for city in range(options.cities) for section in SECTIONS]
    frames = FrameSource(sections, options.size, options.seed)
    table = LabelTable(label_names())
    about = f"{options.size} pixels, {options.cities} cities"
    blocks = Plan(options.frames, batch=8, rate=0.002, seed=options.seed, about=about)
    naming = Plan(options.naming_frames, batch=24, rate=0.003, seed=options.seed, about=about)
    sizes = Sizes(options.size)
    tasks: dict[str, tuple[Plan, Callable[[], Task]]] = {
        "blocks": (blocks, lambda: BlocksTask(sizes, frames.frame, table)),
        "naming": (naming, lambda: NamingTask(frames.frame, table)),
    }
    for name in options.only or NAMES:
        train(Trainer(*tasks[name]), options.out, name)
    if all((options.out / f"{name}.state.safetensors").exists() for name in NAMES):
        trained = {name: Trainer(*tasks[name]) for name in NAMES}
        for name, trainer in trained.items():
            trainer.restore(options.out / f"{name}.state.safetensors")
        seeing, calling = trained["blocks"].network, trained["naming"].network
        assert isinstance(seeing, EyesNetwork)
        assert isinstance(calling, NamingNetwork)
        write_weights(options.out / "vision_eyes.safetensors", seeing, calling)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, required=True, help="folder for states, logs and weights")
    parser.add_argument("--frames", type=int, default=60_000, help="frames that the blocks are learned from")
    parser.add_argument("--naming-frames", type=int, default=60_000, help="frames that the names are learned from")
    parser.add_argument("--size", type=int, default=Sizes().image, help="side length of the frames, in pixels")
    parser.add_argument("--cities", type=int, default=4, help="cities drawn from the plans of the training sections")
    parser.add_argument("--seed", type=int, default=0, help="of frames and first weights")
    parser.add_argument("--threads", type=int, default=1, help="threads of the computation")
    parser.add_argument("--only", choices=NAMES, action="append", help="train this network alone")
    return parser.parse_args()


if __name__ == "__main__":
    main()
