"""Cost of the metrics: a server that counts and times every step, compared with one that does not.

    python -m benchmarks.serving.metering [--data DIR] [--seconds 6] [--rounds 6] [--parallel 1 16]

The second server is the same program with a meter that does nothing instead of the one for Prometheus. They alternate,
each first in every other round. The table shows medians of the rounds' ratios, and all rounds: of the server's CPU time
per step, and of steps per second, which depend on more than the server.
"""

import statistics

from benchmarks.common import (
    add_data,
    add_rounds,
    add_seconds,
    data_or_sample,
    largest_split,
    parser_of,
    positive_int,
)
from benchmarks.serving.server import ServerSetting
from benchmarks.serving.steps import measure

UNMEASURED = """
import sys
from arramon_server.__main__ import main
from arramon_server.process.prometheus_metrics import PrometheusMetrics
from arramon_server.runs.storage.meter import Meter

for name in vars(Meter):
    if not name.startswith("_"):
        setattr(PrometheusMetrics, name, getattr(Meter, name))
sys.exit(main(sys.argv[1:]))
"""


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    add_data(parser)
    add_seconds(parser, 6.0, "duration of each round")
    add_rounds(parser, 6)
    parser.add_argument("--parallel", type=positive_int, nargs="+", default=[1, 16], help="episodes open at once")
    options = parser.parse_args()
    with data_or_sample(options.data) as data:
        split = largest_split(data)
        for parallel in options.parallel:
            with_, without = (
                ServerSetting("measured", parallel),
                ServerSetting("not measured", parallel, program=("-c", UNMEASURED)),
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
