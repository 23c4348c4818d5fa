"""Training of the policy of `vl_map`: imitation on simulated walks, then on walks of its own (DAgger)."""

import json
import logging
import random
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from arramon_agents.reading.reader.reader import load as load_reader
from arramon_agents.simulated.body import Faults
from arramon_agents.simulated.courses import Course, training_courses
from arramon_agents.simulated.walks import Decided, walk
from arramon_agents.training.precision import usable
from arramon_agents.training.trainer import Plan, Trainer
from arramon_agents.vl_map.network import PolicyNetwork, Sizes
from arramon_agents.vl_map.policy import Policy
from arramon_agents.vl_map.task import Arrays, ChoosingTask, arrays_of, load_arrays, save_arrays

LOG = logging.getLogger(__name__)

Tell = Callable[[str], None]

SAVE_SECONDS = 60.0
"""Seconds between two saved states."""

DECAY = 0.01
"""Weight decay."""

PERFECT = 0.25
"""Share of walks without errors of seeing; the other walks have half to one and a half times the usual error rates."""


@dataclass(frozen=True)
class MapRecipe:
    """All settings of a training.

    Attributes:
        languages: in which instructions are read.
        episodes: of each split, the first ones in playing order; 0 for all.
        walks: of each episode, along its paths.
        rounds: number of rounds in which the policy walks by itself, evenly spaced after `first` of all steps.
        round_walks: share of all episodes that a round plays, drawn anew.
        first: share of the steps before the first round of its own walks.
        passes: through the decisions of the walks along paths.
        again: passes through all decisions after that, with those of a last round, and a learning rate that starts anew
            at half of the highest; 0 for none of this.
        batch: decisions of a step.
        learning_rate: the highest.
        precision: "float32", or "bfloat16", which takes two thirds of the time on a processor that has it.
        seed: of everything.
    """

    languages: tuple[str, ...] = ("en", "hi")
    episodes: int = 0
    walks: int = 1
    rounds: int = 2
    round_walks: float = 0.25
    first: float = 0.35
    passes: int = 14
    again: int = 0
    batch: int = 32
    learning_rate: float = 2e-3
    precision: str = "bfloat16"
    seed: int = 1


def smoke(recipe: MapRecipe) -> MapRecipe:
    """Return a recipe for smoke tests, which takes seconds and learns next to nothing."""
    return MapRecipe(recipe.languages, episodes=2, walks=1, rounds=1, passes=2, again=1, batch=8, seed=recipe.seed)


class MapTraining:
    """The policy in training, from its saved state if there is one.

    Args:
        recipe: all settings.
        data: the data folder.
        output: folder for walks, saved state and log.
        tell: receives lines of progress.

    Raises:
        ValueError: if the state is of another recipe or other data.

    Attributes:
        trainer: with the network.
        data_hash: of the training split.
        told: description of the training data.
        state: path of the saved state.
    """

    def __init__(self, recipe: MapRecipe, data: Path, output: Path, tell: Tell = lambda _: None) -> None:
        recipe = replace(recipe, precision=usable(recipe.precision, "cpu", tell))
        self.recipe, self._output, self._tell = recipe, output, tell
        output.mkdir(parents=True, exist_ok=True)
        self._walk_seconds = self._first_seconds = 0.0
        self._steps = 0
        began = time.process_time()
        self._courses, self.data_hash = training_courses(data, recipe.languages, recipe.episodes, load_reader())
        self._tell(f"vl_map: {len(self._courses)} turns, {time.process_time() - began:.0f} s")
        self._about = json.dumps(asdict(recipe) | {"data": self.data_hash, "turns": len(self._courses)})
        first = self._part(0, self._along_paths)
        sections = len({course.world.section.id for course in self._courses})
        self.told = f"{len(self._courses)} turns in {sections} sections, {len(first['label']):,} decisions along paths"
        samples = recipe.passes * len(first["label"])
        plan = Plan(samples, recipe.batch, recipe.learning_rate, decay=DECAY, seed=recipe.seed, about=self._about)
        self.trainer = Trainer(plan, self._make_task)
        self._task.add(first)
        self.state = output / "vl_map.state.safetensors"
        self._restore()

    @property
    def seconds(self) -> float:
        """Processor time of walks and training so far."""
        return self._walk_seconds + self._first_seconds + self.trainer.seconds

    @property
    def updates(self) -> int:
        """Steps done so far."""
        return self._steps + self.trainer.done

    @property
    def network(self) -> PolicyNetwork:
        """The network in training."""
        return self._task.network

    def run(self) -> None:
        """Train to the end, with the rounds of walks."""
        plan, rounds = self.trainer.plan, self.recipe.rounds
        share = (1.0 - self.recipe.first) / max(rounds, 1)
        starts = [round(plan.steps * (self.recipe.first + share * number)) for number in range(rounds)]
        for number, (start, end) in enumerate(zip([0, *starts], [*starts, plan.steps], strict=True)):
            if number:
                self._train(start)
                self._walk_by_itself(number)
            self._train(end)
        if self.recipe.again:
            self._walk_by_itself(rounds + 1)
            self._start_again()
            self._train(self.trainer.plan.steps)

    def _walk_by_itself(self, number: int) -> None:
        self._task.add(self._part(number, partial(self._by_itself, number)))

    def _start_again(self) -> None:
        """Begin a second training of the same network, with a new learning rate schedule."""
        recipe = self.recipe
        self._first_seconds, self._steps = self.trainer.seconds, self.trainer.done
        plan = Plan(
            recipe.again * self._task.count,
            recipe.batch,
            recipe.learning_rate / 2,
            decay=DECAY,
            seed=recipe.seed,
            about=self._about,
        )
        self.trainer = Trainer(plan, lambda: self._task)
        self.state = self._output / "vl_map.state-again.safetensors"
        self._restore()

    def _restore(self) -> None:
        if self.state.exists():
            self.trainer.restore(self.state)

    def _make_task(self) -> ChoosingTask:
        self._task = ChoosingTask(PolicyNetwork(Sizes()), self.recipe.seed, self.recipe.precision)
        return self._task

    def _part(self, number: int, make: Callable[[], list[Decided]]) -> Arrays:
        """Return decisions from the file of this number, or make them."""
        path = self._output / f"vl_map.walks-{number}.safetensors"
        if not path.exists():
            began = time.process_time()
            arrays = arrays_of(make())
            save_arrays(path, arrays, self._about, time.process_time() - began)
        arrays, seconds = load_arrays(path, self._about)
        self._walk_seconds += seconds
        self._tell(f"vl_map: {len(arrays['label'])} decisions in walks {number}, {self._walk_seconds:.0f} s")
        return arrays

    def _along_paths(self) -> list[Decided]:
        decided: list[Decided] = []
        pairs = self._pairs
        for number in range(self.recipe.walks * len(pairs)):
            decided += self._walk(pairs[number % len(pairs)], number // len(pairs), (self.recipe.seed, 0, number))[0]
            if number % 100 == 99:
                self._tell(f"vl_map: walks of {number + 1} episodes, {len(decided)} decisions")
        return decided

    def _by_itself(self, number: int) -> list[Decided]:
        chance = random.Random(f"{self.recipe.seed}/{number}")  # noqa: S311 - nothing here is a secret
        policy = Policy(self.network.eval())
        decided: list[Decided] = []
        picked = 0
        count = max(1, round(self.recipe.round_walks * len(self._pairs)))
        for place in range(count):
            pair = chance.choice(self._pairs)
            walked, hits = self._walk(pair, chance.randrange(len(pair[0].readings)), (self.recipe.seed, number, place),
                                      policy)  # fmt: skip
            decided += walked
            picked += hits
        self._tell(f"vl_map: round {number}: {picked / count / 2:.2f} of its walks end at the target")
        return decided

    @property
    def _pairs(self) -> list[tuple[Course, Course]]:
        """The two turns of each episode."""
        return list(zip(self._courses[::2], self._courses[1::2], strict=True))

    def _walk(
        self, pair: tuple[Course, Course], reading: int, seed: Sequence[int], policy: Policy | None = None
    ) -> tuple[list[Decided], int]:
        """Return the decisions of an episode's walks, the second from where the first ended, and targets picked up."""
        draws = np.random.default_rng(tuple(seed))
        faults = Faults().scaled(0.0 if draws.random() < PERFECT else draws.uniform(0.5, 1.5))
        decided: list[Decided] = []
        picked, body = 0, None
        for course in pair:
            # Each turn with another reading, the first not always with what was meant.
            rows = course.readings[(reading + course.turn) % len(course.readings)]
            if policy is None:
                walked = walk(course, rows, faults, draws, body=body)
            else:
                walked = walk(course, rows, faults, draws, policy.choose, astray=0.05, body=body)
            decided += walked.decisions
            picked += walked.picked == 0
            body = walked.body
        return decided, picked

    def _train(self, end: int) -> None:
        trainer, losses = self.trainer, list[float]()
        saved = time.monotonic()
        with (self._output / "vl_map.log.jsonl").open("a") as log:
            while trainer.done < end:
                losses.append(trainer.step())
                if trainer.done % 100 == 0 or trainer.done == end:
                    entry = {"step": trainer.done, "loss": round(sum(losses) / len(losses), 4),
                             "seconds": round(trainer.seconds, 1)}  # fmt: skip
                    losses.clear()
                    log.write(json.dumps(entry) + "\n")
                    log.flush()
                    self._tell(f"vl_map: {entry} of {trainer.plan.steps} steps")
                if time.monotonic() - saved > SAVE_SECONDS or trainer.done == end:
                    trainer.save(self.state)
                    saved = time.monotonic()
