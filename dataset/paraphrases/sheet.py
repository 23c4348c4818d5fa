"""Sheets for writers of instructions: a picture with the path and the target, and a page of facts, for each turn."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from PIL import Image

from arramon_dataset.generation.site import GenerationSite
from arramon_dataset.generation.split_maker import SOURCE
from arramon_dataset.paraphrases.room_facts import room_facts
from arramon_dataset.paraphrases.route_facts import LegFacts, RouteFacts, landmark_name, route_facts
from arramon_dataset.path_tolerances import FACTS_STRAIGHT
from arramon_dataset.pictures.canvas import BLACK, PINK, SWATCHES, WHITE, Canvas, add_title
from arramon_dataset.pictures.maps import EDGE, PROPS, STREET, roof_colour
from arramon_dataset.plans import plan_ids, read_plan
from arramon_server.episodes.episode import Episode, Turn
from arramon_server.episodes.splits import read_splits
from arramon_server.errors import NotFound
from arramon_server.sim.assets.roadside import ZEBRA_LENGTH, ZEBRA_WIDTH
from arramon_server.sim.cameras import Viewpoint
from arramon_server.sim.geometry import Pose
from arramon_server.sim.own_furniture import furnished
from arramon_server.sim.rules import Collectible
from arramon_server.sim.section import Section
from arramon_server.sim.view import street_actor

SIZE, FRAMES, MAP = 224, 9, 800
"""Pixels along each side of a frame; the number of frames on a sheet; pixels along the longer side of a map."""

MARGIN = 7.0
"""Margin of a map around the path and the turn's objects, in units."""


def writer_sheet(episode: Episode, number: int, site: GenerationSite) -> tuple[Image.Image, str]:
    """Return the picture and the page of facts from which a writer describes turn 1 or 2 of an episode."""
    facts, turn = route_facts(episode, number, site), episode.turns[number - 1]
    chart = street_map(site.section, turn)
    for landmark in facts.landmarks:
        if landmark.label.kind not in ("intersection", "corner", "junction") and not landmark.identity.startswith(
            "collect"
        ):
            chart.label(landmark.x + 0.2, landmark.z, landmark_name(landmark), size=11, colour=PROPS)
    chart.line(turn.path, PINK)
    draw_arrow(chart, facts.poses[0])
    chart.dot(turn.target.position.x, turn.target.position.z, 10, None, BLACK, width=3)
    for item in turn.street:
        draw_object(chart, item, f"TARGET: {item.type}" if item == turn.target else str(item.type))
    title = f"episode {episode.episode_id}, turn {number}: way pink, starts at the arrow, ends at the ringed target"
    shown = {f"step {n}": facts.poses[n] for n in _moments(facts.legs, len(facts.poses))}
    picture = with_views_beside(add_title(chart.image, [title]), agent_frames(shown, turn, site))
    lines = [f"== episode {episode.episode_id}, turn {number}", *_route_lines(facts, turn)]
    return picture, "\n".join([*lines, *room_facts(episode, number, with_goal=True)]) + "\n"


Sheet = Callable[[Episode, int, GenerationSite], tuple[Image.Image, str]]
"""Draws the picture and writes the page of a turn: 1 or 2."""


def sheets_of_split(
    data: Path, split: str, ids: Sequence[str], output: Path, sheet: Sheet = writer_sheet
) -> Iterator[Path]:
    """Write the sheets of a split's episodes, and yield the paths: two pictures and a page for each episode.

    Args:
        data: the data folder.
        split: its name. Buildings, junctions and corners are named where its sections come from the project's plans.
        ids: of episodes; none for all.
        output: folder for the files, created if missing.
        sheet: makes the sheet of a turn; by default that of a writer.

    Raises:
        NotFound: if the split or an episode does not exist.
        OSError: if a file cannot be written.
    """
    chosen = read_splits(data)
    if split not in chosen:
        raise NotFound(f"there is no split {split!r}; there are {', '.join(chosen)}")
    episodes = chosen[split].episodes
    for episode in ids or episodes:
        if episode not in episodes:
            raise NotFound(f"there is no episode {episode!r} in {split}")
    output.mkdir(parents=True, exist_ok=True)
    planned = plan_ids() if chosen[split].source.startswith(SOURCE) else ()
    sites = {
        name: GenerationSite(section, read_plan(name) if name in planned else None)
        for name, section in chosen[split].sections.items()
    }
    for episode in ids or episodes:
        yield from _write(episodes[episode], _site(episodes[episode], sites), output, sheet)


def _site(episode: Episode, sites: Mapping[str, GenerationSite]) -> GenerationSite:
    """Return the site of an episode: that of its section, or one with the episode's own furniture."""
    site = sites[episode.section]
    return site if episode.furniture.is_empty else GenerationSite(furnished(site.section, episode.furniture), site.plan)


def _write(episode: Episode, site: GenerationSite, output: Path, sheet: Sheet) -> Iterator[Path]:
    pages = []
    for number in (1, 2):
        picture, page = sheet(episode, number, site)
        path = output / f"{episode.episode_id}-{number}.png"
        picture.save(path)
        yield path
        pages.append(page)
    path = output / f"{episode.episode_id}.txt"
    path.write_text("\n".join(pages), encoding="utf-8")
    yield path


def _route_lines(facts: RouteFacts, turn: Turn) -> list[str]:
    lines = ["way (all numbers are units; one step forward is half a unit):"]
    for place, leg in enumerate(facts.legs, start=1):
        lines.append(f"  leg {place}: {_turning(leg.turn)}, walk {leg.length:.0f} units")
        if leg.passed:
            lines.append("    goes by: " + "; ".join(map(str, leg.passed)))
        if leg.ahead:
            lines.append("    straight ahead at its end: " + "; ".join(leg.ahead))
    lines.append(f"  at the end: target {_turning(facts.last_turn)}")
    lines.append(f"target: {turn.target.type}")
    lines.append("  around the target, as one arrives: " + ("; ".join(facts.around) or "nothing near"))
    lines.append("  other objects seen on the way: " + (", ".join(facts.others) or "none"))
    return lines


def _turning(degrees: float) -> str:
    if abs(degrees) < FACTS_STRAIGHT:
        return "straight on"
    return f"{abs(degrees):.0f} degrees to the {'right' if degrees > 0 else 'left'}"


def street_map(section: Section, turn: Turn) -> Canvas:
    """Return a map of the streets around a turn's path and objects, without these."""
    places = [*turn.path, *((item.position.x, item.position.z) for item in turn.street)]
    xs, zs = [x for x, _ in places], [z for _, z in places]
    bounds = (min(xs) - MARGIN, min(zs) - MARGIN, max(xs) + MARGIN, max(zs) + MARGIN)
    scale = MAP / max(bounds[2] - bounds[0], bounds[3] - bounds[1])
    canvas = Canvas(bounds, scale, STREET)
    for building in section.buildings:
        half = (building.half_width, building.half_length)
        canvas.rectangle(building.x, building.z, half, building.heading, roof_colour(building.facade), EDGE)
    for prop in section.props:
        if prop.kind == "zebra_crossing":
            canvas.rectangle(prop.x, prop.z, (ZEBRA_WIDTH / 2, ZEBRA_LENGTH / 2), prop.heading, WHITE)
        canvas.dot(prop.x, prop.z, 3, PROPS, PROPS)
    return canvas


def draw_object(canvas: Canvas, item: Collectible, name: str) -> None:
    """Draw an object on a map, with a name beside it."""
    canvas.dot(item.position.x, item.position.z, 6, SWATCHES[item.type.colour])
    canvas.label(item.position.x + 0.5, item.position.z, name, size=13)


def draw_arrow(canvas: Canvas, pose: Pose) -> None:
    """Draw the agent's start pose on a map, as an arrow."""
    tip = pose.ahead(2.0)
    canvas.line([(pose.x, pose.z), (tip.x, tip.z)], BLACK, 4)
    for side in (-150.0, 150.0):
        end = tip.turned(side).ahead(0.8)
        canvas.line([(tip.x, tip.z), (end.x, end.z)], BLACK, 4)
    canvas.dot(pose.x, pose.z, 7, BLACK)


def agent_frames(poses: Mapping[str, Pose], turn: Turn, site: GenerationSite) -> list[tuple[str, Image.Image]]:
    """Return the agent's frames from named poses in a turn's streets."""
    actors = [street_actor(item) for item in turn.street]
    return [
        (name, Image.fromarray(site.camera.render(Viewpoint(p.x, p.z, p.heading), actors, SIZE).rgb))
        for name, p in poses.items()
    ]


def _moments(legs: Sequence[LegFacts], count: int) -> list[int]:
    """Return the indices of the poses to show: the beginnings of legs, the end, and evenly between, in order."""
    moments = {0, count - 1, *(min(leg.first + 3, count - 1) for leg in legs)}
    for place in range(FRAMES):
        if len(moments) >= FRAMES:
            break
        moments.add(round(place * (count - 1) / (FRAMES - 1)))
    return sorted(moments)[:FRAMES]


def with_views_beside(chart: Image.Image, views: Sequence[tuple[str, Image.Image]]) -> Image.Image:
    """Return a map with named views to its right, in three columns."""
    titled = [add_title(view, [name], size=11) for name, view in views]
    width, height = SIZE + 6, titled[0].height + 4
    columns = 3
    rows = math.ceil(len(titled) / columns)
    whole = Image.new("RGB", (chart.width + 8 + columns * width, max(chart.height, rows * height)), WHITE)
    whole.paste(chart, (0, 0))
    for place, frame in enumerate(titled):
        whole.paste(frame, (chart.width + 8 + place % columns * width, place // columns * height))
    return whole
