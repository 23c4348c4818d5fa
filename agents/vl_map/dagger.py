"""Training of the policy of `vl_map`: imitation on simulated walks along paths, then DAgger."""

import json
import random
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import torch

from arramon_agents.reading.reader.reader import load as load_reader
from arramon_agents.simulated.body import PerceptionErrorRates
from arramon_agents.simulated.courses import Course, training_courses
from arramon_agents.simulated.walks import LabelledDecision, walk
from arramon_agents.training.checkpoint import TrainingInputs
from arramon_agents.training.precision import usable_precision
from arramon_agents.training.recipe import update_settings
from arramon_agents.training.schedule import warm_up_cosine
from arramon_agents.training.trainer import Trainer, TrainerSettings
from arramon_agents.training.workspace import Report, Workspace
from arramon_agents.vl_map.network import PolicyNetwork, PolicySizes
from arramon_agents.vl_map.policy import MapPolicy
from arramon_agents.vl_map.recipe import MapRecipe
from arramon_agents.vl_map.task import Arrays, DecisionTask, arrays_of, load_arrays, save_arrays
from arramon_agents.weights import SUFFIX

NAME = "vl_map"

DECAY = 0.01
"""Weight decay."""

PERFECT_SHARE = 0.25
"""Share of walks without perception errors; the others have 0.5 to 1.5 times the measured error rates."""


@dataclass(frozen=True)
class TrainedPolicy:
    """Result of a training.

    Attributes:
        network: the trained network, in evaluation mode.
        updates: number of updates.
        cpu_seconds: processor time of walks and updates.
        description: description of the training data.
        data_hash: hash of the training split.
    """

    network: PolicyNetwork
    updates: int
    cpu_seconds: float
    description: str
    data_hash: str


def train_policy(recipe: MapRecipe, workspace: Workspace, report: Report) -> TrainedPolicy:
    """Train the policy, resuming from walks and checkpoints in the output folder.

    Raises:
        ArraMonError: if the data folder lacks a split or a language.
        ValueError: if walks or checkpoints belong to another recipe or other data.
    """
    recipe = replace(recipe, precision=usable_precision(recipe.precision, "cpu", report))
    walks = SimulatedWalks(recipe, workspace, report)
    first = walks.along_paths()
    count = len(first["label"])
    torch.manual_seed(recipe.seed)
    network = PolicyNetwork(PolicySizes())
    task = DecisionTask(network, recipe.batch, recipe.seed, recipe.precision)
    task.add(first)

    def trainer(name: str, samples: int, rate: float) -> Trainer:
        steps = samples // recipe.batch
        settings = TrainerSettings(
            name,
            steps,
            warm_up_cosine(rate, steps),
            recipe.seed,
            decay=DECAY,
            checkpoint_steps=workspace.checkpoint_steps,
            training_inputs=walks.training_inputs,
        )
        return Trainer(task, settings, workspace.output, report)

    trainers = [trainer(NAME, recipe.passes * count, recipe.learning_rate)]
    steps = trainers[0].settings.steps
    for number in range(recipe.rounds):
        share = recipe.first + (1.0 - recipe.first) / recipe.rounds * number
        trainers[0].run(until=round(steps * share))
        task.add(walks.dagger_round(number + 1, network))
    trainers[0].run()
    if recipe.again:
        task.add(walks.dagger_round(recipe.rounds + 1, network))
        trainers.append(trainer(f"{NAME}.again", recipe.again * task.count, recipe.learning_rate / 2))
        trainers[1].run()
    updates, seconds = sum(each.step for each in trainers), sum(each.cpu_seconds for each in trainers)
    return TrainedPolicy(
        network.eval(),
        updates,
        walks.cpu_seconds + seconds,
        f"{walks.description}, {count:,} decisions along paths",
        walks.data_hash,
    )


class SimulatedWalks:
    """Labelled decisions of simulated walks, cached in files of the output folder.

    Args:
        recipe: all training settings.
        workspace: has the data folder and the output folder.
        report: receives lines of progress.

    Attributes:
        data_hash: hash of the training split.
        training_inputs: recipe and data that determine the walks.
        cpu_seconds: processor time spent on the walks.
    """

    def __init__(self, recipe: MapRecipe, workspace: Workspace, report: Report) -> None:
        self._recipe, self._output, self._report = recipe, workspace.output, report
        self.cpu_seconds = 0.0
        courses, self.data_hash = training_courses(workspace.data, recipe.languages, recipe.episodes, load_reader())
        self._pairs = list(zip(courses[::2], courses[1::2], strict=True))  # The two turns of each episode.
        sections = len({course.world.section.id for course in courses})
        self.description = f"{len(courses)} turns in {sections} sections"
        self.training_inputs = TrainingInputs(update_settings(recipe), f"{self.data_hash}, {len(courses)} turns")
        self._about = json.dumps({**self.training_inputs.recipe, "data": self.data_hash, "turns": len(courses)})

    def along_paths(self) -> Arrays:
        """Return the decisions of walks along the episodes' paths."""
        return self._part(0, self._walk_along_paths)

    def dagger_round(self, number: int, network: PolicyNetwork) -> Arrays:
        """Return the decisions of a DAgger round, in which the policy walks.

        Args:
            number: number of the round, from 1 on.
            network: network of the policy.
        """
        return self._part(number, partial(self._walk_by_policy, number, network))

    def _part(self, number: int, make: Callable[[], list[LabelledDecision]]) -> Arrays:
        """Return the decisions of a round from its file; if there is none, make them and write the file."""
        path = self._output / f"{NAME}.walks-{number}{SUFFIX}"
        if not path.exists():
            began = time.process_time()
            arrays = arrays_of(make())
            save_arrays(path, arrays, self._about, time.process_time() - began)
        arrays, seconds = load_arrays(path, self._about)
        self.cpu_seconds += seconds
        self._report(f"{NAME}: {len(arrays['label'])} decisions in walks {number}, {self.cpu_seconds:.0f} s")
        return arrays

    def _walk_along_paths(self) -> list[LabelledDecision]:
        decided: list[LabelledDecision] = []
        pairs, seed = self._pairs, self._recipe.seed
        for number in range(self._recipe.walks * len(pairs)):
            decided += walk_turns(pairs[number % len(pairs)], number // len(pairs), (seed, 0, number))[0]
            if number % 100 == 99:
                self._report(f"{NAME}: walks of {number + 1} episodes, {len(decided)} decisions")
        return decided

    def _walk_by_policy(self, number: int, network: PolicyNetwork) -> list[LabelledDecision]:
        seed = self._recipe.seed
        chance = random.Random(f"{seed}/{number}")  # noqa: S311 - nothing here is a secret
        policy = MapPolicy(network.eval())
        decided: list[LabelledDecision] = []
        picked = 0
        count = max(1, round(self._recipe.round_walks * len(self._pairs)))
        for place in range(count):
            pair = chance.choice(self._pairs)
            reading = chance.randrange(len(pair[0].readings))
            walked, hits = walk_turns(pair, reading, (seed, number, place), policy)
            decided += walked
            picked += hits
        self._report(f"{NAME}: round {number}: {picked / count / 2:.2f} of its walks end at the target")
        return decided


def walk_turns(
    pair: tuple[Course, Course], reading: int, seed: Sequence[int], policy: MapPolicy | None = None
) -> tuple[list[LabelledDecision], int]:
    """Walk both turns of an episode; the second starts where the first ended.

    Args:
        pair: courses of the two turns.
        reading: index of the first turn's reading; the second turn uses the next one.
        seed: seed of perception errors and of random detours.
        policy: policy that walks; None for walks along the paths.

    Returns:
        The decisions, and the number of targets that were picked up.
    """
    draws = np.random.default_rng(tuple(seed))
    faults = PerceptionErrorRates().scaled(0.0 if draws.random() < PERFECT_SHARE else draws.uniform(0.5, 1.5))
    decided: list[LabelledDecision] = []
    picked, body = 0, None
    for course in pair:
        # The two turns use different readings.
        rows = course.readings[(reading + course.turn) % len(course.readings)]
        if policy is None:
            walked = walk(course, rows, faults, draws, body=body)
        else:
            walked = walk(course, rows, faults, draws, policy.option_values, astray=0.05, body=body)
        decided += walked.decisions
        picked += walked.picked == 0
        body = walked.body
    return decided, picked
