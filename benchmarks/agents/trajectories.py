"""Pictures of an agent's paths over the map, beside the ground truth, and a table of its failures.

    python -m benchmarks.agents.trajectories [--data DIR] [--agent NAME] [--agent-arg NAME=VALUE ...]
                                             [--split S] [--lang L] [--episodes N] [--output DIR]

An agent plays the first N episodes in this process, by the rules of every run. The folder gets a picture of each turn,
in the style of the paper's figures: the ground truth in pink, the agent's way in green, the target ringed, with the
instruction above; and `failures.md`, a table of the turns whose target was not picked up, sorted by what can be told
from the ways: where it left the path, and how the turn ended. Text that the font lacks is left out of the pictures.
"""

import argparse
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from agents.learning.training.rollouts import Plan, play
from arramon_client import load_agent
from arramon_client.agent import Action, Agent, Observation
from arramon_client.agent import Episode as Begun
from arramon_client.plugin.arguments import parse_arguments, parse_value
from server.dataset.pictures.canvas import BLACK, GREEN, PINK, SWATCHES, WHITE, add_title, wrap_text
from server.dataset.pictures.maps import ground_map
from server.episodes.episode import Episode
from server.episodes.splits import folder_of, read_split
from server.scoring.metrics import ndtw
from server.sim.geometry import Pose
from server.sim.own_furniture import furnished
from server.sim.rules import reachable
from server.sim.section import Section

SCALE, MARGIN = 14.0, 8.0
"""Pixels per unit, and units around the ways that are shown."""

LEFT = 3.0
"""Distance from the ground truth from which the agent has left it, in units."""

ELSEWHERE = "turn 2 began elsewhere, as turn 1 ended there"
CAUSES = (ELSEWHERE, "left the path at its beginning", "left the path on the way", "reached the path's end")
ENDS = ("took another object that looks the same", "took an object that looks different", "step limit")

Path2 = npt.NDArray[np.float64]


@dataclass
class Way:
    """What an agent did in the street in one turn.

    Attributes:
        poses: (x, z, heading in degrees) before each action.
        took: whether the last action was to pick something up.
    """

    poses: list[tuple[float, float, float]] = field(default_factory=list)
    took: bool = False


class Watched:
    """An agent whose ways are recorded.

    Args:
        agent: that plays.
    """

    def __init__(self, agent: Agent) -> None:
        self._agent = agent
        self.sensors = tuple(dict.fromkeys((*getattr(agent, "sensors", ("rgb", "depth")), "pose")))
        self.ways: dict[tuple[str, int], Way] = {}

    def begin(self, episode: Begun) -> None:
        """Start a new episode."""
        self._agent.begin(episode)

    def act(self, observations: Sequence[Observation]) -> Sequence[int]:
        """Return the agent's actions, and record where it is."""
        actions = self._agent.act(observations)
        for observation, action in zip(observations, actions, strict=True):
            if observation.phase == "navigation" and observation.pose is not None:
                way = self.ways.setdefault((observation.episode_id, observation.turn), Way())
                way.poses.append(observation.pose)
                way.took = action == Action.INTERACT
        return actions


@dataclass(frozen=True)
class Judged:
    """A turn, and what can be told of it.

    Attributes:
        path: (n, 2) of distinct positions.
        ndtw: of the path.
        cause, end: one of CAUSES and of ENDS; empty if the target was picked up.
        reached: share of the ground truth along which the agent was near it, in order.
    """

    episode: Episode
    turn: int
    path: Path2
    ndtw: float
    cause: str
    end: str
    reached: float


def judge(episode: Episode, turn: int, way: Way) -> Judged:
    """Return what can be told of a turn from its way."""
    truth = episode.turns[turn - 1]
    path, reference = np.array([pose[:2] for pose in way.poses]), np.array(truth.path)
    reached = 0
    for place in path:
        near = np.hypot(*(reference[reached : reached + 6] - place).T) < LEFT
        reached += int(np.flatnonzero(near).max(initial=0))
    share = reached / max(len(reference) - 1, 1)
    x, z, heading = way.poses[-1]
    taken = reachable(Pose(x, z, heading), truth.street) if way.took else None
    cause = end = ""
    if taken != 0:
        same = taken is not None and truth.street[taken].type == truth.target.type
        end = ENDS[2] if taken is None else ENDS[0] if same else ENDS[1]
        began = float(np.hypot(*(path[0] - reference[0])))
        cause = CAUSES[0 if began > LEFT else 1 if share < 0.25 else 2 if share < 0.9 else 3]
    score = ndtw([tuple(each) for each in path.tolist()], [tuple(each) for each in reference.tolist()])
    return Judged(episode, turn, path, score, cause, end, share)


def draw(judged: Judged, section: Section, language: str) -> Image.Image:
    """Return the map of a turn with the ground truth, the agent's way, and the instruction."""
    episode, turn = judged.episode, judged.episode.turns[judged.turn - 1]
    canvas = ground_map(furnished(section, episode.furniture), SCALE)
    canvas.line(turn.path, PINK, 5)
    canvas.line([(x, z) for x, z in judged.path.tolist()], GREEN, 3)
    for item in turn.street:
        canvas.dot(item.position.x, item.position.z, 5, SWATCHES[item.type.colour])
    canvas.dot(turn.target.position.x, turn.target.position.z, 10, None, BLACK, width=3)
    canvas.label(turn.target.position.x + 0.8, turn.target.position.z, str(turn.target.type), size=13)
    canvas.dot(*turn.path[0], 6, BLACK)
    canvas.dot(float(judged.path[0, 0]), float(judged.path[0, 1]), 6, WHITE)
    shown = np.concatenate([np.array(turn.path), judged.path, [(turn.target.position.x, turn.target.position.z)]])
    (left, bottom), (right, top) = (canvas.at(*place) for place in (shown.min(0) - MARGIN, shown.max(0) + MARGIN))
    image = canvas.image.crop((
        max(0, int(left)), max(0, int(top)), min(canvas.image.width, int(right)), min(canvas.image.height, int(bottom)),
    ))  # fmt: skip
    said = episode.instruction(language, judged.turn, "navigation")
    outcome = f"{judged.cause}; {judged.end}" if judged.end else "picked up the target"
    title = f"episode {episode.episode_id}, turn {judged.turn}: nDTW {judged.ndtw:.2f}, {outcome}"
    return add_title(image, [title, *wrap_text(said, max(40, image.width // 8))])


def table(turns: Sequence[Judged], language: str) -> str:
    """Return the failures in Markdown: how many of each sort, then each with its instruction."""
    failed = [each for each in turns if each.end]
    sorts = Counter((each.cause, each.end) for each in failed)
    ends = [end for end in ENDS if any(end == known for _, known in sorts)]
    lines = [
        f"{len(failed)} of {len(turns)} turns did not end with the target.",
        "",
        f"| | {' | '.join(ends)} |",
        f"| --- |{' --- |' * len(ends)}",
        *(f"| {cause} | {' | '.join(str(sorts[cause, end]) for end in ends)} |" for cause in CAUSES),
        "",
        "| episode, turn | nDTW | share of the path | sort | instruction |",
        "| --- | --- | --- | --- | --- |",
        *(
            f"| {each.episode.episode_id}, {each.turn} | {each.ndtw:.2f} | {each.reached:.2f} | "
            f"{each.cause}; {each.end} | {each.episode.instruction(language, each.turn, 'navigation')} |"
            for each in failed
        ),
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Play, draw, and write the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("arramon-data"))
    parser.add_argument("--agent", default="agents.vl_map")
    parser.add_argument(
        "--agent-arg", action="append", default=[], metavar="NAME=VALUE", help="a value is JSON or text"
    )
    parser.add_argument("--split", default="val_unseen")
    parser.add_argument("--lang", default="en")
    parser.add_argument("--episodes", type=int, default=40)
    parser.add_argument("--output", type=Path, default=Path("arramon-results/trajectories"))
    given = parser.parse_args()
    arguments = {name: parse_value(value) for name, value in parse_arguments(given.agent_arg).items()}
    agent = Watched(load_agent(given.agent, arguments))
    play(agent, Plan(given.data, given.split, (given.lang,), given.episodes, 224))
    split = read_split(folder_of(given.data, given.split))
    turns = [judge(split.episodes[episode_id], turn, way) for (episode_id, turn), way in sorted(agent.ways.items())]
    given.output.mkdir(parents=True, exist_ok=True)
    for each in turns:
        image = draw(each, split.sections[each.episode.section], given.lang)
        image.save(given.output / f"{each.episode.episode_id}-{each.turn}.png")
    (given.output / "failures.md").write_text(table(turns, given.lang), encoding="utf-8")
    print(table(turns, given.lang).split("\n\n| episode")[0])


if __name__ == "__main__":
    main()
