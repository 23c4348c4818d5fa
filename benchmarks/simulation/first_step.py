"""CPU seconds from the start of the interpreter to the first step of an environment.

    python -m benchmarks.simulation.first_step [--data DIR] [--split NAME] [--rounds 5] [--against PYTHON]

Each round starts a new process, which makes the environment, resets it and takes a step; compiled code is on disk, as
it is after the first time on a machine. `--against` names the interpreter of another checkout or release, with which
the rounds alternate. Prints medians of the CPU time by part, and the large packages that were imported, as imports take
most of the time.
"""

import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.common import add_data, add_rounds, data_or_sample, largest_split, parser_of, text_table

PROGRAM = """
import json, sys, time
import gymnasium, arramon_client.environments
imported = time.process_time()
env = gymnasium.make("arramon/ArraMon-v0", data=sys.argv[1], split=sys.argv[2])
made = time.process_time()
env.reset(seed=0)
begun = time.process_time()
env.step(0)
heavy = ("PIL", "alembic", "cryptography", "grpc", "arramon_lang", "numba", "pybullet",
         "pydantic", "scipy", "sqlalchemy")
print(json.dumps({"import": imported, "make": made - imported, "reset": begun - made,
                  "step": time.process_time() - begun, "all": time.process_time(),
                  "imported": [name for name in heavy if name in sys.modules]}))
"""

PARTS = ("import", "make", "reset", "step", "all")


def first_step(python: str, data: Path, split: str) -> dict[str, float | list[str]]:
    """Return the CPU seconds of each part in a new process, and which large packages it has imported."""
    with tempfile.TemporaryDirectory() as folder:  # Not here, where this checkout would be imported.
        command = [python, "-c", PROGRAM, str(data.absolute()), split]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    measured: dict[str, float | list[str]] = json.loads(done.stdout)
    return measured


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    add_data(parser)
    parser.add_argument("--split", help="name of the split (default: the one with the most episodes)")
    add_rounds(parser, 5)
    parser.add_argument("--against", help="interpreter of another checkout or release")
    options = parser.parse_args()
    pythons = {"this one": sys.executable} | ({"the other": options.against} if options.against else {})
    results: dict[str, list[dict[str, float | list[str]]]] = {name: [] for name in pythons}
    with data_or_sample(options.data) as data:
        split = options.split or largest_split(data).name
        for python in pythons.values():
            first_step(python, data, split)  # Compiled code comes to the disk.
        for _ in range(options.rounds):
            for name, python in pythons.items():
                results[name].append(first_step(python, data, split))
    lines = []
    for name, rounds in results.items():
        medians = [statistics.median(float(each[part]) for each in rounds) for part in PARTS]  # type: ignore[arg-type]
        lines.append([name, *(f"{median:.3f}" for median in medians)])
    print(text_table(["CPU seconds to the first step", *PARTS], lines))
    for name, rounds in results.items():
        print(f"{name} imports {', '.join(rounds[-1]['imported'])}")  # type: ignore[arg-type]


if __name__ == "__main__":
    main()
