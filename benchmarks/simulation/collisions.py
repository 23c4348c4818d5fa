"""Comparison of pybullet's collision checks with plane geometry, and their speed (needs pybullet).

    python -m benchmarks.simulation.collisions [--moves 1000000] [--data DIR] [--log FILE] [--minutes M] [--json FILE]

In each section, the project's seven, two that are drawn, and those of the splits in a data folder: random steps of the
agent, a third of them within 0.001 units of touching a body. For each split in addition every step of every ground
truth, with the episode's own furniture, and a step in each of twelve directions from each place on it.

`pybullet alone` counts the moves about which pybullet by itself would decide otherwise than the exact distance, and
`farthest` says how far from touching these were at most, in units. `differ` counts the moves about which the two
implementations of the rules decide differently: there must be none, or the exit status is 1. Chunks in the log are
not computed again, so that a long comparison can be made in several commands: `--minutes` ends one, the next resumes.
"""

import json
import math
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, fields
from functools import cache, partial
from itertools import islice
from pathlib import Path
from random import Random

from arramon_client.world import AGENT_RADIUS, STEP, TURN, Action
from arramon_dataset.generation.extra_sections import extra_sections
from arramon_dataset.plans import build_section, plan_ids, read_plan
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split, read_splits
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.worlds import Worlds
from arramon_server.sim.bullet import Obstacles
from arramon_server.sim.city import city_scene
from arramon_server.sim.footprints import TOUCHING, Footprint, Footprints, Place
from arramon_server.sim.geometry import Pose
from arramon_server.sim.physics import Physics
from arramon_server.sim.rules import Limits, Phase
from arramon_server.sim.scene import Scene
from arramon_server.sim.section import Section
from benchmarks.common import OpenGround, add_json, markdown_table, parser_of, positive_int, write_json

SEED = "arramon"
"""Seed of the project's own sections."""

DRAWN = ("101", "102")
"""Ids of sections with random street plans."""

CHUNK = 20_000
"""Number of random moves in a chunk, which is computed and logged at once."""

BEYOND = 2.0
"""Distance beyond a section's bounds from which moves still start, in units."""

Move = tuple[Place, Place]


@dataclass
class MoveCounts:
    """Counts of compared moves.

    Attributes:
        moves: all moves.
        near: moves within TOUCHING of touching a body.
        free: moves decided as free.
        pybullet_alone: moves for which pybullet by itself disagrees with the exact distance.
        farthest: maximum distance of these from touching, in units.
        differ: moves for which the implementations of the rules disagree.
    """

    moves: int = 0
    near: int = 0
    free: int = 0
    pybullet_alone: int = 0
    farthest: float = 0.0
    differ: int = 0

    def add(self, other: "MoveCounts") -> None:
        """Add other counts to these."""
        for field in fields(self):
            mine, its = getattr(self, field.name), getattr(other, field.name)
            setattr(self, field.name, max(mine, its) if field.name == "farthest" else mine + its)


def steps_anywhere(section: Section, random: Random) -> Iterator[Move]:
    """Yield steps of the agent from anywhere in a section, in any direction, without end."""
    x0, y0, x1, y1 = section.bounds
    while True:
        yield _step(random.uniform(x0 - BEYOND, x1 + BEYOND), random.uniform(y0 - BEYOND, y1 + BEYOND), random)


def steps_that_almost_touch(scene: Scene, plane: Footprints, random: Random) -> Iterator[Move]:
    """Yield steps of the agent whose distance from the nearest body of a scene is within TOUCHING of its radius."""
    footprints = [Footprint.of(body) for body in scene.bodies if body.collider is not None]
    while True:
        footprint = random.choice(footprints)
        size = footprint.half_width + footprint.half_length + STEP
        start, end = _step(footprint.x + random.uniform(-size, size), footprint.y + random.uniform(-size, size), random)
        there, here = nearest_points(footprint, start, end)
        distance = math.dist(there, here)
        if distance < 1e-3:
            continue  # They meet: there is no direction in which to move the step away.
        # Moved along the line between the nearest points, these stay the nearest.
        wanted = AGENT_RADIUS + random.uniform(-TOUCHING, TOUCHING)
        dx, dy = ((here[i] - there[i]) / distance * (wanted - distance) for i in (0, 1))
        move = (start[0] + dx, start[1] + dy), (end[0] + dx, end[1] + dy)
        if abs(plane.distance(*move) - AGENT_RADIUS) <= TOUCHING:  # otherwise another body is nearer
            yield move


def nearest_points(footprint: Footprint, start: Place, end: Place) -> tuple[Place, Place]:
    """Return the point of a rectangle that is nearest to a segment, and that of the segment which is nearest to it.

    Of a segment that the rectangle meets, some point of it near the rectangle.
    """
    sin, cos, width, length = footprint.sin, footprint.cos, footprint.half_width, footprint.half_length
    u, v = [], []
    for x, y in (start, end):
        dx, dy = x - footprint.x, y - footprint.y
        u.append(dx * cos - dy * sin)
        v.append(dx * sin + dy * cos)
    du, dv = u[1] - u[0], v[1] - v[0]
    shares = [0.0, 1.0]
    for p, q in ((width, length), (-width, length), (-width, -length), (width, -length)):
        shares.append(min(max(((p - u[0]) * du + (q - v[0]) * dv) / (du * du + dv * dv), 0.0), 1.0))

    def pair(share: float) -> tuple[float, Place, Place]:
        here = u[0] + share * du, v[0] + share * dv
        there = min(max(here[0], -width), width), min(max(here[1], -length), length)
        return math.dist(here, there), there, here

    _, there, here = min(map(pair, shares))
    back = [(footprint.x + p * cos + q * sin, footprint.y - p * sin + q * cos) for p, q in (there, here)]
    return back[0], back[1]


def random_moves(section: Section, scene: Scene, plane: Footprints, random: Random) -> Iterator[Move]:
    """Yield random moves without end; every third one almost touches a body."""
    anywhere, near = steps_anywhere(section, random), steps_that_almost_touch(scene, plane, random)
    while True:
        yield next(anywhere)
        yield next(near)
        yield next(anywhere)


Check = Callable[[Place, Place], bool]
"""Returns whether the straight line between two places is free."""


def compare(
    moves_to_check: Iterable[Move], engine: Check, alone: Check, distance: Callable[[Place, Place], float]
) -> MoveCounts:
    """Compare the decisions of pybullet and plane geometry about moves.

    Args:
        moves_to_check: the moves.
        engine: pybullet's collision checks, as the rules use them.
        alone: collision checks of pybullet by itself.
        distance: returns the exact distance of a move from the nearest body.
    """
    counts = MoveCounts()
    for start, end in moves_to_check:
        nearest = distance(start, end)
        free, excess = nearest > AGENT_RADIUS, abs(nearest - AGENT_RADIUS)
        counts.moves += 1
        counts.near += excess <= TOUCHING
        counts.free += free
        counts.differ += engine(start, end) != free
        if alone(start, end) != free:
            counts.pybullet_alone += 1
            counts.farthest = max(counts.farthest, excess)
    return counts


def compare_in_section(section: Section, moves: int, number: int) -> MoveCounts:
    """Return the counts of a chunk of random moves in a section, checked both ways; its number seeds them."""
    scene = _scene(section)
    plane, random = Footprints(scene), Random(f"{section.id} {section.bounds} {number}")  # noqa: S311
    with Obstacles(scene) as engine, Obstacles(scene, exact_within=0.0) as alone:
        moves_to_check = islice(random_moves(section, scene, plane, random), moves)
        return compare(moves_to_check, engine.way_is_free, alone.way_is_free, plane.distance)


def on_ground_truths(split: Split, section: str) -> MoveCounts:
    """Return the results of the moves on and beside all ground truths of a split in one section."""
    counts, splits = MoveCounts(), {split.name: split}
    engine_alone = partial(Obstacles, exact_within=0.0)
    with closing(Worlds(splits, physics=Obstacles)) as engines, closing(Worlds(splits, physics=engine_alone)) as alone:
        for episode in split.episodes.values():
            if episode.section == section:
                engine, other = (each.world(split.name, episode) for each in (engines, alone))
                # The plane is that of the episode's own scene: the others have its difference from the section's.
                plane = Footprints(engine.scene)
                counts.add(compare(_ways(episode), engine.way_is_free, other.way_is_free, plane.distance))
    return counts


def _ways(episode: Episode) -> Iterator[Move]:
    """Yield the steps of an episode's ground truth, and one in each direction from each place on it."""
    session, seen = EpisodeSession(episode, OpenGround(), Limits(10_000)), set[tuple[float, float]]()
    for action in (action for turn in episode.turns for action in (*turn.actions, *turn.room_actions)):
        pose, phase = session.state.pose, session.state.phase
        if phase is Phase.NAVIGATION and action is Action.FORWARD:
            after = pose.ahead()
            yield (pose.x, pose.z), (after.x, after.z)
        if phase is Phase.NAVIGATION and (pose.x, pose.z) not in seen:
            seen.add((pose.x, pose.z))
            for turns in range(round(360 / TURN)):
                after = pose.turned(turns * TURN).ahead()
                yield (pose.x, pose.z), (after.x, after.z)
        session.apply(action)


def comparison_parts(moves: int, splits: Sequence[Split]) -> Iterator[tuple[str, Callable[[], MoveCounts]]]:
    """Yield the parts of the comparison, each with its name and what computes it: section by section, then splits."""
    sections = {f"section {id_}": build_section(read_plan(id_), SEED) for id_ in plan_ids()}
    sections |= {f"section {id_}": section for id_, (_, section) in extra_sections(SEED, DRAWN).items()}
    for split in splits:
        sections |= {f"{split.name}, section {id_}": section for id_, section in split.sections.items()}
        for id_ in split.sections:
            yield f"{split.name}, section {id_}, ground truths/0", partial(on_ground_truths, split, id_)
    chunks = math.ceil(moves / len(sections) / CHUNK)
    for number in range(chunks):
        for name, section in sections.items():
            size = min(CHUNK, math.ceil(moves / len(sections) / chunks))
            yield f"{name}/{number}", partial(compare_in_section, section, size, number)


def speed(section: Section, moves: int) -> dict[str, float]:
    """Return microseconds for each random step, and milliseconds to build a section, of both; best of three."""
    scene = _scene(section)
    moves_to_check = list(islice(steps_anywhere(section, Random(1)), moves))  # noqa: S311
    makes: dict[str, Callable[[Scene], Physics]] = {
        "pybullet": partial(Obstacles, exact_within=0.0),
        "pybullet, exact near touching": Obstacles,
        "plane": Footprints,
    }
    figures: dict[str, float] = {}
    for _ in range(3):
        for name, make in makes.items():
            started = time.process_time()
            physics = make(scene)
            made = time.process_time()
            for start, end in moves_to_check:
                physics.way_is_free(start, end)
            done = time.process_time()
            physics.close()
            for key, value in (
                ("us", 1e6 * (done - made) / len(moves_to_check)),
                ("ms to build", 1e3 * (made - started)),
            ):
                figures[f"{name}, {key}"] = min(value, figures.get(f"{name}, {key}", math.inf))
    return figures


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark."""
    parser = parser_of(__doc__)
    parser.add_argument(
        "--moves", type=positive_int, default=1_000_000, help="random moves in all (default: %(default)s)"
    )
    parser.add_argument("--data", type=Path, help="data folder whose splits are compared, too")
    parser.add_argument("--log", type=Path, help="log of finished chunks, to resume from")
    parser.add_argument("--minutes", type=float, default=math.inf, help="time after which no new chunk is started")
    parser.add_argument(
        "--timed",
        type=positive_int,
        default=20_000,
        help="moves in each measurement of the speed (default: %(default)s)",
    )
    add_json(parser)
    given = parser.parse_args(arguments)
    done: dict[str, MoveCounts] = {}
    if given.log and given.log.exists():
        for line in given.log.read_text().splitlines():
            part, record = json.loads(line)
            done[part] = MoveCounts(**record)
    splits = read_splits(given.data) if given.data else {}
    until, left = time.monotonic() + 60 * given.minutes, 0
    for name, work in comparison_parts(given.moves, list(splits.values())):
        if name in done:
            continue
        if time.monotonic() > until:
            left += 1
            continue
        done[name] = work()
        if given.log:
            with given.log.open("a") as file:
                file.write(json.dumps([name, asdict(done[name])]) + "\n")
    rows: dict[str, MoveCounts] = {"total": MoveCounts()}
    for name, counts in done.items():
        for row in (name.rpartition("/")[0], "total"):
            rows.setdefault(row, MoveCounts()).add(counts)
    rows["total"] = rows.pop("total")
    print(table(rows))
    if left:
        print(f"{left} chunks are left")
    figures = speed(build_section(read_plan("1"), SEED), given.timed)
    print("".join(f"{name}: {value:.2f}\n" for name, value in figures.items()), end="")
    ratios = (figures[f"pybullet, {key}"] / figures[f"plane, {key}"] for key in ("us", "ms to build"))
    print("pybullet takes {:.1f} times as long for each step as plane geometry, {:.0f} times to build".format(*ratios))
    write_json(given.json, {"rows": {name: asdict(counts) for name, counts in rows.items()}, "speed": figures})
    return 1 if rows["total"].differ else 0


def table(rows: dict[str, MoveCounts]) -> str:
    """Return the table of results."""
    names = [field.name for field in fields(MoveCounts)]
    lines = []
    for name, counts in rows.items():
        values = (getattr(counts, field) for field in names)
        lines.append([name, *(f"{value:.6f}" if isinstance(value, float) else f"{value:,}" for value in values)])
    return markdown_table(["where", *(name.replace("_", " ") for name in names)], lines)


def _step(x: float, y: float, random: Random) -> Move:
    after = Pose(x, y, random.uniform(0.0, 360.0)).ahead()
    return (x, y), (after.x, after.z)


@cache
def _scene(section: Section) -> Scene:
    return city_scene(section)


if __name__ == "__main__":
    sys.exit(main())
