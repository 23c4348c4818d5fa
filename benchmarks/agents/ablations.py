"""Ablations of `agents.vl` at equal compute, and of `agents.vl_map` at play: the tables of docs/results/ablations.md.

    python -m benchmarks.agents.ablations [--data DIR] [--runs DIR] [--cache DIR] [--seconds S] [--room-seconds S]
                                          [--train-episodes N] [--rooms N] [--seeds 1,2] [--episodes N] [--rows A,B]
                                          [--phases navigation,assembly] [--map-rows A,B] [--map-weights FILE]
                                          [--page FILE] [--play-only]

Each variation of `vl` is trained on each phase for the same CPU time, with a learning rate that falls to 0 and without
choosing weights by validation, and plays that phase of the first N episodes of each split in both languages, while the
ground truth plays the other. Variations of `vl_map` need no training: the shipped weights play with a part disabled.
Weights and scores in the folder of runs are reused, so that an interrupted command can be resumed. Use another folder
of runs for other data, training times or amounts of training data. With `--play-only` the page stays as it is: two
commands with different rows or phases can run side by side.
"""

import argparse
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import torch

from arramon_agents.training.demonstrations import DemonstrationSource, episodes_of
from arramon_agents.training.rollouts import FRAME_SIZE
from arramon_agents.weights import find_weights
from arramon_client import load_agent
from benchmarks.agents.ablations_tables import BASE, PhaseScores, tables
from benchmarks.agents.study import METRICS, SHORT_RECIPE, Study, TrainingSet, study_options, write_page

BEGIN, END = "<!-- tables: benchmarks/agents/ablations.py -->", "<!-- end of tables -->"


@dataclass(frozen=True)
class Variation:
    """A variation of the base agent.

    Attributes:
        what: description in the table.
        recipe: fields of the recipe, for `vl`.
        arguments: of the agent, for `vl_map`.
        share: of the training episodes, the first ones.
        phases: phases that it affects; only these are trained and played.
    """

    what: str
    recipe: Mapping[str, Any] = field(default_factory=dict)
    arguments: Mapping[str, object] = field(default_factory=dict)
    share: float = 1.0
    phases: tuple[str, ...] = tuple(METRICS)


ROWS = {
    BASE: Variation("as shipped, but trained for this time, and without variants of demonstrations"),
    "variants": Variation("with variants, the time to write them included", {"variants": 4}),
    "pooled": Variation("encoder `pooled`: shares of colours and depths, not learned", {"encoder": "pooled"}),
    "share-1": Variation("all steps in the loss, changes of action without more weight", {"share": 1.0}),
    "no-rooms": Variation("no drawn rooms", {"rooms": 0}, phases=("assembly",)),
    "half": Variation("half of the episodes", share=0.5),
    "en": Variation("English texts alone", {"languages": ("en",)}),
    "hi": Variation("Hindi texts alone", {"languages": ("hi",)}),
    "no-text": Variation("no text", {"reads": False}),
    "no-sight": Variation("no images", {"sees": False}),
}
"""Variations of `vl`."""

STREETS = ("navigation",)

MAP_ROWS = {
    BASE: Variation("as shipped"),
    "segmentation": Variation("sensor `segmentation`", arguments={"sensor": "segmentation"}),
    "no-mirror": Variation("without the mirror image", arguments={"mirror": False}, phases=STREETS),
    "no-looks": Variation("without looking around", arguments={"looks": False}, phases=STREETS),
    "no-sums": Variation(
        "the largest view names a thing, not the sum of views", arguments={"sums": False}, phases=STREETS
    ),
}
"""Variations of `vl_map`."""


def main() -> None:
    """Train and play the missing variations, and write the page's tables."""
    parser = study_options(__doc__, "ablations")
    parser.add_argument("--seconds", type=float, default=180.0, help="of CPU time, to train navigation once")
    parser.add_argument("--room-seconds", type=float, default=60.0, help="the same for assembly")
    parser.add_argument("--phases", default=",".join(METRICS))
    parser.add_argument("--rows", default=",".join(ROWS), help="variations of vl; empty for none")
    parser.add_argument("--map-rows", default=",".join(MAP_ROWS), help="variations of vl_map; empty for none")
    parser.add_argument("--map-weights", default="vl_map", help="a file; otherwise the shipped ones")
    given = parser.parse_args()
    for option, known in (("rows", ROWS), ("map_rows", MAP_ROWS), ("phases", METRICS)):
        names = [name for name in getattr(given, option).split(",") if name]
        if not set(names) <= set(known):
            parser.error(f"--{option.replace('_', '-')} {','.join(names)}: there are {', '.join(known)}")
        setattr(given, option, names)
    torch.set_num_threads(1)
    study = Study(given.data, given.cache, given.runs, given.rate, given.episodes)
    trained = [
        measure(study, given, name, phase, int(seed))
        for seed in given.seeds.split(",")
        for phase in given.phases
        for name in given.rows
        if phase in ROWS[name].phases
    ]
    played = [
        measure_map(study, given, name, phase)
        for phase in given.phases
        for name in given.map_rows
        if phase in MAP_ROWS[name].phases
    ]
    if not given.play_only:
        whats = [{name: row.what for name, row in rows.items()} for rows in (ROWS, MAP_ROWS)]
        write_page(given.page, BEGIN, END, tables(trained, played, *whats))


def measure(study: Study, given: argparse.Namespace, name: str, phase: str, seed: int) -> PhaseScores:
    """Return the scores of a variation of `vl` in a phase, from the folder of runs or by training and playing it."""
    row = ROWS[name]
    changes = {"episodes": given.train_episodes, "rooms": given.rooms, **row.recipe}
    recipe = replace(SHORT_RECIPE, seed=seed, **changes)
    if row.share < 1.0:
        count = recipe.episodes or len(episodes_of(DemonstrationSource(given.data, "train", ("en",), "", 0))[0])
        recipe = replace(recipe, episodes=max(1, round(row.share * count)))
    eyes = recipe.encoder if recipe.sees else ""
    training_set = TrainingSet(phase, eyes, recipe.episodes, recipe.rooms if phase == "assembly" else 0)
    seconds = given.room_seconds if phase == "assembly" else given.seconds
    kept = study.result(f"{name}-{phase}-{seed}", recipe, training_set, seconds)
    return PhaseScores(name, phase, seed, kept["scores"], kept["updates"])


def measure_map(study: Study, given: argparse.Namespace, name: str, phase: str) -> PhaseScores:
    """Return the scores of a variation of `vl_map` in a phase, from the folder of runs or by playing it."""
    arguments = {"weights": given.map_weights, **MAP_ROWS[name].arguments}

    def play() -> dict[str, Any]:
        return {"scores": study.play(load_agent("agents.vl_map", arguments), phase, FRAME_SIZE)}

    mark = hashlib.sha256(find_weights(given.map_weights).read_bytes()).hexdigest()[:8]
    return PhaseScores(name, phase, 0, study.kept(f"map-{mark}-{name}-{phase}", play)["scores"], 0)


if __name__ == "__main__":
    main()
