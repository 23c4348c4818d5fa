"""The command `python -m website.figures`: draws all figures of the documentation into `docs/figures`."""

import argparse
import sys
from pathlib import Path

from website.figures import ablations, drawings, language, learning, results, speed
from website.staging import DOCS


def main() -> int:
    """Draw the figures."""
    parser = argparse.ArgumentParser(prog="python -m website.figures", description=__doc__)
    parser.add_argument("--output", type=Path, default=DOCS / "figures", help="folder of the figures")
    folder = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    for metric, name in results.METRICS.items():
        results.draw(metric, folder / f"{name}.svg")
    for name in ablations.CHARTS:
        ablations.draw(name, folder / f"{name}.svg")
    for name in language.CHARTS:
        language.draw(name, folder / f"{name}.svg")
    speed.draw(folder / f"{speed.NAME}.svg")
    learning.draw_reader(folder / f"{learning.READER}.svg")
    learning.draw_policies(folder / f"{learning.POLICIES}.svg")
    for name, text in drawings.all_drawings().items():
        (folder / f"{name}.svg").write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
