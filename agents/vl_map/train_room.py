"""Training of the network of `vl_map` that finds the cell of the room, on the rooms of episodes."""

import time
from collections.abc import Sequence
from random import Random

import numpy as np
import torch
from torch.nn import functional

from arramon_agents.simulated.rooms import Task, misnamed
from arramon_agents.vl_map.room import CELLS, Placer, given_of, several

PASSES, BATCH, RATE, DECAY = 30, 64, 0.03, 1e-4
"""Passes over all rooms, batch size, highest learning rate, weight decay."""


def train_rooms(tasks: Sequence[Task], seed: int, passes: int = PASSES) -> tuple[Placer, float]:
    """Return a trained network, and the seconds of processor time that it took.

    Args:
        tasks: training tasks.
        seed: for the order, the choice of readings, and misnamed things.
        passes: number of passes over all rooms.
    """
    began = time.process_time()
    torch.manual_seed(seed)
    random, order = Random(seed), np.random.default_rng(seed)  # noqa: S311 - nothing here is a secret
    network = Placer()
    optimiser = torch.optim.AdamW(network.parameters(), RATE, weight_decay=DECAY)
    steps = max(1, passes * len(tasks) // BATCH)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
    for _ in range(steps):
        chosen = [tasks[number] for number in order.integers(len(tasks), size=BATCH)]
        given = [given_of(list(random.choice(task.readings)), misnamed(task.room, random)) for task in chosen]
        right = torch.tensor([CELLS.index(task.cell) for task in chosen])
        loss = functional.cross_entropy(network(several(given)), right)
        optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimiser.step()
        schedule.step()
    return network.eval(), time.process_time() - began


def right_cells(network: Placer, tasks: Sequence[Task], reading: int) -> float:
    """Return the share of tasks whose cell is found, given correctly named things."""
    with torch.inference_mode():
        values = network(several([given_of(list(task.readings[reading]), task.room) for task in tasks]))
    found = [CELLS[number] for number in values.argmax(1).tolist()]
    return sum(cell == task.cell for cell, task in zip(found, tasks, strict=True)) / len(tasks)
