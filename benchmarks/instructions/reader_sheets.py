"""Sheets for human readers of instructions, who decide to which object and cell a text leads.

    python -m benchmarks.instructions.reader_sheets --split val_unseen [--data DIR] [--output DIR] [EPISODE ...]

A reader sees the same streets and room as a writer (`arramon-server sheets`), but without the way and the goal, and
every object by number. That is how the free paraphrases were checked (`dataset/paraphrases/data/README.md`).
"""

import hashlib
import sys
from collections.abc import Sequence
from pathlib import Path

from PIL import Image

from arramon_dataset.generation.site import GenerationSite
from arramon_dataset.paraphrases.room_facts import room_facts
from arramon_dataset.paraphrases.route_facts import route_facts
from arramon_dataset.paraphrases.sheet import (
    agent_frames,
    draw_arrow,
    draw_object,
    sheets_of_split,
    street_map,
    with_views_beside,
)
from arramon_dataset.pictures.canvas import add_title
from arramon_dataset.pictures.maps import PROPS
from arramon_server.episodes.episode import Episode
from arramon_server.errors import ArraMonError
from arramon_server.sim.rules import Collectible
from arramon_server.sim.section import Prop
from benchmarks.common import parser_of


def reader_sheet(episode: Episode, number: int, site: GenerationSite) -> tuple[Image.Image, str]:
    """Return a reader's picture and page of facts, without path and goal."""
    facts, turn = route_facts(episode, number, site), episode.turns[number - 1]
    chart = street_map(site.section, turn)
    for prop in site.section.props:  # All of them: those that are seen from the way would tell it.
        chart.label(prop.x + 0.2, prop.z, name_of_prop(prop), size=10, colour=PROPS)
    draw_arrow(chart, facts.poses[0])
    lines = [f"== episode {episode.episode_id}, turn {number}", "objects in the street:"]
    for place, item in enumerate(numbered_objects(episode, number), start=1):
        draw_object(chart, item, f"#{place} {item.type}")
        lines.append(f"  #{place}: {item.type}")
    title = f"episode {episode.episode_id}, turn {number}: start at the arrow"
    start = facts.poses[0]
    shown = {"start": start, **{f"{60 * n} degrees right": start.turned(60.0 * n) for n in range(1, 6)}}
    picture = with_views_beside(add_title(chart.image, [title]), agent_frames(shown, turn, site))
    return picture, "\n".join([*lines, *room_facts(episode, number, with_goal=False)]) + "\n"


def numbered_objects(episode: Episode, number: int) -> list[Collectible]:
    """Return a turn's street objects in an order that does not reveal the target."""
    street = episode.turns[number - 1].street
    keys = {item: f"{episode.episode_id}/{number}/{item.type}/{item.position}" for item in street}
    return sorted(street, key=lambda item: hashlib.sha256(keys[item].encode()).digest())


def name_of_prop(prop: Prop) -> str:
    """Return a plain English name of a piece of street furniture."""
    return " ".join(filter(None, (prop.shape, prop.colour, prop.kind.replace("_", " "))))


def main(argv: Sequence[str] | None = None) -> int:
    """Write the sheets; return the exit status."""
    parser = parser_of(__doc__)
    parser.add_argument("episodes", nargs="*", metavar="EPISODE", help="ids (default: all of the split)")
    parser.add_argument("--split", required=True, help="split of the episodes")
    parser.add_argument("--data", type=Path, default=Path("arramon-data"), help="data folder (default: %(default)s)")
    parser.add_argument("--output", type=Path, default=Path("sheets"), help="folder (default: %(default)s)")
    arguments = parser.parse_args(argv)
    try:
        for path in sheets_of_split(
            arguments.data, arguments.split, arguments.episodes, arguments.output, reader_sheet
        ):
            print(path)
    except (ArraMonError, OSError) as error:
        print(f"reader_sheets: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
