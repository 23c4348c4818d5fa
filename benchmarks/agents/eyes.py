"""Accuracy of the visual encoder `eyes`: `python -m benchmarks.agents.eyes`.

Prints a Markdown table.

Frames are of section 6, whose streets are in no training split, and of sections 1 to 5 from other viewpoints than those
of training.
"""

import time
from pathlib import Path

import numpy as np
import torch

from arramon_agents.perception.eyes.encoder import Eyes, load, load_far
from arramon_agents.perception.eyes.scores import GridScores, NameScores
from arramon_agents.simulated.frames import FrameSource, label_names
from benchmarks.common import markdown_table, parser_of, positive_int

SEED = 1_000_003
"""Seed of the frames, different from those of training."""

PLACES = {"unseen": ("6",), "seen": ("1", "2", "3", "4", "5")}


def main() -> None:
    """Print the table."""
    parser = parser_of(__doc__)
    parser.add_argument("--weights", type=Path, help="file of weights (default: the shipped ones)")
    parser.add_argument(
        "--frames", type=positive_int, default=1000, help="frames in the unseen section, and in the seen ones"
    )
    parser.add_argument("--far", action="store_true", help="the encoder for agents that keep a map")
    options = parser.parse_args()
    if options.far and options.weights:
        parser.error("--far and --weights both name the encoder: give one of them")
    torch.set_num_threads(1)
    eyes = load_far() if options.far else load(options.weights)
    measured = {place: measure(eyes, sections, options.frames) for place, sections in PLACES.items()}
    print(table(measured))


def measure(eyes: Eyes, sections: tuple[str, ...], frames: int) -> tuple[GridScores, NameScores, float]:
    """Return the scores on frames of sections, and the CPU seconds per frame."""
    source = FrameSource([(section, "0") for section in sections], eyes.image_size, SEED)
    cells, names, seconds = GridScores(label_names()), NameScores(label_names()), 0.0
    for number in range(frames):
        frame = source.frame(number)
        began = time.thread_time()
        features = eyes.encode(frame.rgb[None], frame.depth[None])[0]
        seconds += time.thread_time() - began
        cells.add(features, frame.labels)
        names.add(eyes.things(frame.rgb[None], frame.depth[None])[0], frame.labels)
    return cells, names, seconds / frames


def table(measured: dict[str, tuple[GridScores, NameScores, float]]) -> str:
    """Return all scores as a Markdown table."""
    places = list(measured)
    groups, rows = {place: scores.groups() for place, (scores, _, _) in measured.items()}, []
    for group in dict.fromkeys(group for each in groups.values() for group in each):
        rows.append([f"**{group}**", *(f"{groups[place].get(group, np.nan):.2f}" for place in places)])
        rows += [
            [name, *(f"{measured[place][0].counts[name].f1:.2f}" for place in places)]
            for name in measured[places[0]][0].counts
            if name.startswith(f"{group}:")
        ]
    names = []
    for place, (_, scores, _) in measured.items():
        names += [[f"{place}, {pixels}", *map(str, shares.values())] for pixels, shares in scores.shares().items()]
        names.append([f"{place}, other things called collectibles", str(scores.false), *[""] * 5])
    times = [
        f"{1000 * seconds:.1f} ms of processor time a frame ({place})." for place, (_, _, seconds) in measured.items()
    ]
    header = ["collectibles by name", "count", "found", "kind", "colour", "pattern", "all"]
    return "\n\n".join(
        [markdown_table(["F1 by class", *places], rows), markdown_table(header, names), "\n".join(times)]
    )


if __name__ == "__main__":
    main()
