"""Cost of the metrics: a server that counts and times every step, compared with one that does not.

    python -m benchmarks.serving.metering [--data DIR] [--seconds 6] [--rounds 6] [--parallel 1 16]

The second server is the same program with a meter that does nothing instead of the one for Prometheus. They alternate,
each first in every other round. The table shows medians of the rounds' ratios, and all rounds: of the server's CPU time
per step, and of steps per second, which depend on more than the server.
"""

import argparse
import statistics
from pathlib import Path

from arramon_server.episodes.splits import read_splits
from benchmarks.common import data_or_sample
from benchmarks.serving.steps import Setting, measure

UNMEASURED = """
import sys
from arramon_server.cli import main
from arramon_server.process.metrics import Metrics
from arramon_server.runs.storage.meter import Meter

for name in vars(Meter):
    if not name.startswith("_"):
        setattr(Metrics, name, getattr(Meter, name))
sys.exit(main(sys.argv[1:]))
"""


def main() -> None:
    """Run the benchmark and print its table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--data", type=Path, help="data folder (default: the sample episodes)")
    parser.add_argument("--seconds", type=float, default=6.0, help="duration of each round (default: %(default)s)")
    parser.add_argument("--rounds", type=int, default=6, help="number of rounds (default: %(default)s)")
    parser.add_argument("--parallel", type=int, nargs="+", default=[1, 16], help="episodes open at once")
    options = parser.parse_args()
    with data_or_sample(options.data) as data:
        split = max(read_splits(data).values(), key=lambda split: len(split.episodes))
        for parallel in options.parallel:
            with_, without = (
                Setting("measured", parallel),
                Setting("not measured", parallel, program=("-c", UNMEASURED)),
            )
            works, rates = [], []
            for number in range(options.rounds):
                pair = (with_, without) if number % 2 else (without, with_)
                found = {setting.name: measure(data, split, setting, options.seconds) for setting in pair}
                works.append(found["measured"].work / found["not measured"].work)
                rates.append(found["measured"].rate / found["not measured"].rate)
            for name, ratios in (("server CPU per step", works), ("steps per second", rates)):
                rounds = " ".join(f"{ratio:.3f}" for ratio in ratios)
                print(f"{parallel:4} episodes, {name:28} {statistics.median(ratios):.3f}   rounds {rounds}", flush=True)


if __name__ == "__main__":
    main()
