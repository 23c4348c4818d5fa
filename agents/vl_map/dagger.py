"""Training of the policy of `vl_map`: imitation on simulated walks along paths, then DAgger."""

import json
import random
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import partial

import torch

from arramon_agents.reading.reader.reader import load as load_reader
from arramon_agents.simulated.courses import training_courses
from arramon_agents.simulated.episode_walks import PlannedWalk, cpu_seconds, walk_episodes
from arramon_agents.simulated.rendered_walks import RenderedStreets, walk_rendered_episodes
from arramon_agents.simulated.walks import LabelledDecision
from arramon_agents.training.checkpoint import TrainingInputs, check_recipe
from arramon_agents.training.precision import usable_precision
from arramon_agents.training.recipe import update_settings
from arramon_agents.training.schedule import warm_up_cosine
from arramon_agents.training.trainer import Trainer, TrainerSettings
from arramon_agents.training.workspace import Report, Workspace
from arramon_agents.vl_map.network import PolicyNetwork, sizes_of
from arramon_agents.vl_map.recipe import MapRecipe
from arramon_agents.vl_map.task import Arrays, DecisionTask, arrays_of, load_arrays, save_arrays
from arramon_agents.weights import SUFFIX

NAME = "vl_map"

DECAY = 0.01
"""Weight decay."""


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
        UsageError: if the data folder lacks a split.
        ValueError: if a split lacks a language, or walks or checkpoints belong to another recipe or other data.
    """
    recipe = replace(recipe, precision=usable_precision(recipe.precision, workspace.device, report))
    check_recipe(workspace.output, NAME, update_settings(recipe))
    walks = SimulatedWalks(recipe, workspace, report)
    first = walks.along_paths()
    count = len(first["label"])
    torch.manual_seed(recipe.seed)
    network = PolicyNetwork(sizes_of(recipe.width, recipe.layers)).to(workspace.device)
    task = DecisionTask(network, recipe.batch, recipe.seed, recipe.precision, workspace.device)
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
        network.cpu().eval(),
        updates,
        walks.cpu_seconds + seconds,
        f"{walks.description}, {count:,} decisions along paths",
        walks.data_hash,
    )


class SimulatedWalks:
    """Labelled decisions of simulated walks, cached in files of the output folder.

    Args:
        recipe: all training settings.
        workspace: has the data folder, the output folder and the number of processes.
        report: receives lines of progress.

    Attributes:
        data_hash: hash of the training split.
        training_inputs: recipe and data that determine the walks.
        cpu_seconds: processor time spent on the walks.
    """

    def __init__(self, recipe: MapRecipe, workspace: Workspace, report: Report) -> None:
        self._recipe, self._workspace, self._report = recipe, workspace, report
        self.cpu_seconds = 0.0
        self._courses = training_courses(workspace.data, recipe.languages, recipe.episodes, load_reader())
        courses, self.data_hash = [each for pair in self._courses.pairs for each in pair], self._courses.data_hash
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
        path = self._workspace.output / f"{NAME}.walks-{number}{SUFFIX}"
        if not path.exists():
            began = cpu_seconds()
            arrays = arrays_of(make())
            save_arrays(path, arrays, self._about, cpu_seconds() - began)
        arrays, seconds = load_arrays(path, self._about)
        self.cpu_seconds += seconds
        self._report(f"{NAME}: {len(arrays['label'])} decisions in walks {number}, {self.cpu_seconds:.0f} s")
        return arrays

    def _walk_along_paths(self) -> list[LabelledDecision]:
        count, seed = len(self._courses.pairs), self._recipe.seed
        total = self._recipe.walks * count
        planned = [PlannedWalk(number % count, number // count, (seed, 0, number)) for number in range(total)]
        decided: list[LabelledDecision] = []
        for number, walked in enumerate(
            walk_episodes(self._courses.pairs, planned, None, self._workspace.processes), start=1
        ):
            decided += walked.decisions
            if number % 100 == 0:
                self._report(f"{NAME}: walks of {number} episodes, {len(decided)} decisions")
        return decided

    def _walk_by_policy(self, number: int, network: PolicyNetwork) -> list[LabelledDecision]:
        seed = self._recipe.seed
        chance = random.Random(f"{seed}/{number}")  # noqa: S311 - nothing here is a secret
        planned: list[PlannedWalk] = []
        for place in range(max(1, round(self._recipe.round_walks * len(self._courses.pairs)))):
            pair = chance.randrange(len(self._courses.pairs))
            reading = chance.randrange(len(self._courses.pairs[pair][0].readings))
            planned.append(PlannedWalk(pair, reading, (seed, number, place)))
        decided: list[LabelledDecision] = []
        picked = 0
        policy = deepcopy(network).cpu().eval()
        processes = self._workspace.processes
        recipe = self._recipe
        if recipe.rendered and number > recipe.rounds - recipe.rendered:  # Also the round after them, for `again`.
            streets = RenderedStreets(self._workspace.data, self._recipe.languages[0])
            walks = walk_rendered_episodes(streets, self._courses, planned, policy, processes)
        else:
            walks = walk_episodes(self._courses.pairs, planned, policy, processes)
        for count, walked in enumerate(walks, start=1):
            decided += walked.decisions
            picked += walked.picked
            if count % 100 == 0:
                self._report(f"{NAME}: round {number}: {count} episodes, {len(decided)} decisions")
        self._report(f"{NAME}: round {number}: {picked / len(planned) / 2:.2f} of its walks end at the target")
        return decided
