"""Measure how well the visual encoder sees: `python -m benchmarks.agents.eyes`.

It prints a table in Markdown.

Frames are of section 6, whose streets are in no training split, and of sections 1 to 5 from other viewpoints than those
of training.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np
import torch

from arramon_agents.perception.eyes.encoder import Eyes, load
from arramon_agents.perception.eyes.scores import GridScores, NameScores
from arramon_agents.simulated.frames import FrameSource, label_names

SEED = 1_000_003
"""Seed of the frames, different from those of training."""

PLACES = {"unseen": ("6",), "seen": ("1", "2", "3", "4", "5")}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--weights", type=Path, help="file of weights (default: the shipped ones)")
    parser.add_argument("--frames", type=int, default=1000, help="frames in the unseen section, and in the seen ones")
    options = parser.parse_args()
    torch.set_num_threads(1)
    eyes = load(options.weights)
    measured = {place: measure(eyes, sections, options.frames) for place, sections in PLACES.items()}
    sys.stdout.write(table(measured))


def measure(eyes: Eyes, sections: tuple[str, ...], frames: int) -> tuple[GridScores, NameScores, float]:
    """Return the scores on frames of sections, and the seconds of processor time for each frame."""
    source = FrameSource([(section, "0") for section in sections], eyes.image_size, SEED)
    cells, names, seconds = GridScores(label_names()), NameScores(label_names()), 0.0
    for number in range(frames):
        frame = source.frame(number)
        began = time.thread_time()
        features = eyes.encode(frame.rgb[None], frame.depth[None])[0]
        seconds += time.thread_time() - began
        cells.add(features, frame.labels)
        names.add(eyes.things(frame.rgb[None], frame.depth[None])[0], frame.labels)
    return cells, names, seconds / max(1, frames)


def table(measured: dict[str, tuple[GridScores, NameScores, float]]) -> str:
    """Return all scores as Markdown."""
    places = list(measured)
    lines = [f"| F1 by class | {' | '.join(places)} |", "| --- |" + " --- |" * len(places)]
    groups = {place: scores.groups() for place, (scores, _, _) in measured.items()}
    for group in dict.fromkeys(group for each in groups.values() for group in each):
        lines.append(f"| **{group}** | " + " | ".join(f"{groups[p].get(group, np.nan):.2f}" for p in places) + " |")
        lines.extend(
            f"| {name} | " + " | ".join(f"{measured[place][0].counts[name].f1:.2f}" for place in places) + " |"
            for name in measured[places[0]][0].counts
            if name.startswith(f"{group}:")
        )
    lines += ["", "| collectibles by name | count | found | kind | colour | pattern | all |", "| --- |" + " --- |" * 6]
    for place, (_, names, _) in measured.items():
        for pixels, shares in names.shares().items():
            lines.append(f"| {place}, {pixels} | " + " | ".join(str(value) for value in shares.values()) + " |")
        lines.append(f"| {place}, other things called collectibles | {names.false} | | | | | |")
    lines += [""] + [
        f"{1000 * seconds:.1f} ms of processor time a frame ({place})." for place, (_, _, seconds) in measured.items()
    ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
