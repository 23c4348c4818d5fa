"""Maps of an agent's paths beside the ground truth, and a classification of its failures.

    python -m benchmarks.agents.trajectories [--data DIR] [--agent NAME] [--agent-arg NAME=VALUE ...]
                                             [--split S] [--lang L] [--episodes N] [--worst N] [--output DIR]

An agent plays the first N episodes in this process, by the rules of every run. The folder gets a picture of each turn,
in the style of the paper's figures: the ground truth in pink, the agent's way in green, the target ringed, with the
instruction above; `failures.md`, a table of the turns whose target was not picked up, sorted by what can be told
from the ways: where it left the path, and how the turn ended; and `worst.md`, a sheet of the worst of them with their
pictures, to be classified by a reader. Text that the font lacks is left out of the pictures.

Played paths are kept in `ways.json` in the folder, so that an interrupted command can be resumed. Use another folder
for other weights.
"""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from arramon_agents.training.rollouts import PARALLEL, RolloutPlan, play
from arramon_client.agent import Action, Agent, Observation, actions_of, end_episode
from arramon_client.agent import Episode as Begun
from arramon_client.plugin.arguments import parse_arguments, parse_value
from arramon_dataset.pictures.canvas import BLACK, GREEN, PINK, SWATCHES, WHITE, add_title, wrap_text
from arramon_dataset.pictures.maps import ground_map
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split, read_split, split_folder
from arramon_server.scoring.metrics import ndtw
from arramon_server.scoring.turn_outcomes import PathOutcome, followed_share, path_outcome
from arramon_server.sim.geometry import Pose
from arramon_server.sim.own_furniture import furnished
from arramon_server.sim.rules import reachable
from arramon_server.sim.section import Section
from benchmarks.common import named_agent, parser_of

SCALE, MARGIN = 14.0, 8.0
"""Pixels per unit, and margin around the paths, in units."""

ELSEWHERE = "turn 2 began elsewhere, as turn 1 ended there"
CAUSES = {
    PathOutcome.BEGAN_ELSEWHERE: ELSEWHERE,
    PathOutcome.LEFT_AT_START: "left the path at its beginning",
    PathOutcome.LEFT_ON_THE_WAY: "left the path on the way",
    PathOutcome.REACHED_END: "reached the path's end",
}
ENDS = ("took another object that looks the same", "took an object that looks different", "step limit")

Path2 = npt.NDArray[np.float64]


@dataclass
class PlayedPath:
    """An agent's navigation in one turn.

    Attributes:
        poses: (x, z, heading in degrees) before each action.
        took: whether the last action picked something up.
    """

    poses: list[tuple[float, float, float]] = field(default_factory=list)
    took: bool = False


class RecordingAgent:
    """Wraps an agent and records its paths.

    Args:
        agent: the agent to record.
    """

    def __init__(self, agent: Agent) -> None:
        self._agent = agent
        self.sensors = tuple(dict.fromkeys((*getattr(agent, "sensors", ("rgb", "depth")), "pose")))
        self.paths: dict[tuple[str, int], PlayedPath] = {}

    def begin(self, episode: Begun) -> None:
        """Start a new episode."""
        self._agent.begin(episode)

    def end(self, episode_id: str) -> None:
        """Let the agent discard its state of an episode."""
        end_episode(self._agent, episode_id)

    def act(self, observations: Sequence[Observation]) -> Sequence[int]:
        """Return the agent's actions, and record its poses."""
        actions = actions_of(self._agent.act(observations))
        for observation, action in zip(observations, actions, strict=True):
            if observation.phase == "navigation" and observation.pose is not None:
                played_path = self.paths.setdefault((observation.episode_id, observation.turn), PlayedPath())
                played_path.poses.append(observation.pose)
                played_path.took = action == Action.INTERACT
        return actions


@dataclass(frozen=True)
class JudgedTurn:
    """A turn with the classification of its outcome.

    Attributes:
        path: (n, 2) of distinct positions.
        ndtw: of the path.
        cause, end: a value of CAUSES and one of ENDS; empty if the target was picked up.
        reached: share of the ground truth along which the agent was near it, in order.
        taken: the object that the last action picked up; empty for none.
    """

    episode: Episode
    turn: int
    path: Path2
    ndtw: float
    cause: str
    end: str
    reached: float
    taken: str

    @property
    def name(self) -> str:
        """File name of its picture."""
        return f"{self.episode.episode_id}-{self.turn}"


def classify(episode: Episode, turn: int, played_path: PlayedPath) -> JudgedTurn:
    """Classify the outcome of a turn by the agent's path."""
    truth = episode.turns[turn - 1]
    path, reference = np.array([pose[:2] for pose in played_path.poses]), np.array(truth.path)
    played, truth_path = [tuple(each) for each in path.tolist()], [tuple(each) for each in reference.tolist()]
    share = followed_share(played, truth_path)
    x, z, heading = played_path.poses[-1]
    taken = reachable(Pose(x, z, heading), truth.street) if played_path.took else None
    cause = end = ""
    if taken != 0:
        same = taken is not None and truth.street[taken].type == truth.target.type
        end = ENDS[2] if taken is None else ENDS[0] if same else ENDS[1]
        cause = CAUSES[path_outcome(played, truth_path)]
    score = ndtw(played, truth_path)
    return JudgedTurn(
        episode, turn, path, score, cause, end, share, "" if taken is None else str(truth.street[taken].type)
    )


def draw(judged: JudgedTurn, section: Section, language: str) -> Image.Image:
    """Return the map of a turn with the ground truth, the agent's path, and the instruction."""
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


def table(turns: Sequence[JudgedTurn], language: str) -> str:
    """Return the failures in Markdown: counts by class, then each with its instruction."""
    failed = [each for each in turns if each.end]
    sorts = Counter((each.cause, each.end) for each in failed)
    ends = [end for end in ENDS if any(end == known for _, known in sorts)]
    lines = [
        f"{len(failed)} of {len(turns)} turns did not end with the target.",
        "",
        f"| | {' | '.join(ends)} |",
        f"| --- |{' --- |' * len(ends)}",
        *(f"| {cause} | {' | '.join(str(sorts[cause, end]) for end in ends)} |" for cause in CAUSES.values()),
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


def sheet(turns: Sequence[JudgedTurn], language: str, most: int) -> str:
    """Return the worst failures in Markdown with pictures and space for a reader's class, the lowest nDTW first.

    Turns that began elsewhere are left out, as their class is known.
    """
    failed = [each for each in turns if each.end]
    unsorted = sorted((each for each in failed if each.cause != ELSEWHERE), key=lambda each: each.ndtw)
    left_out = len(failed) - len(unsorted)
    parts = [f"# The {len(unsorted[:most])} worst of {len(failed)} failures", f"Left out: {left_out} ({ELSEWHERE})."]
    for number, each in enumerate(unsorted[:most], 1):
        target = each.episode.turns[each.turn - 1].target.type
        parts += [
            f"## {number}. Episode {each.episode.episode_id}, turn {each.turn}",
            f"> {each.episode.instruction(language, each.turn, 'navigation')}",
            f"Asked for: {target}. Took: {each.taken or 'nothing'}. nDTW {each.ndtw:.2f}, path {each.reached:.0%}. "
            f"By the command: {each.cause}; {each.end}.",
            f"![The way over the map]({each.name}.png)",
            "Sort:",
        ]
    return "\n\n".join(parts) + "\n"


def read_or_play(given: argparse.Namespace, split: Split) -> dict[tuple[str, int], PlayedPath]:
    """Return the paths of the first episodes by id and turn, from the folder or by playing.

    Raises:
        SystemExit: if the folder has paths of another agent, or on other data.
    """
    arguments = {name: parse_value(value) for name, value in parse_arguments(given.agent_arg).items()}
    about = [given.agent, arguments, split.name, given.lang, split.data_hash]
    path: Path = given.output / "ways.json"
    paths: dict[tuple[str, int], PlayedPath] = {}
    if path.exists():
        kept: dict[str, Any] = json.loads(path.read_text())
        if kept["about"] != about:
            sys.exit(f"{path} is of {kept['about']}, not of {about}: name another --output")
        paths = {
            (name, turn): PlayedPath([(x, z, heading) for x, z, heading in played_path["poses"]], played_path["took"])
            for name, turn, played_path in kept["ways"]
        }
    wanted = [each.episode_id for each in split.in_playing_order(given.lang)][: given.episodes or None]
    done = {name for name, _ in paths}
    left = [name for name in wanted if name not in done]
    agent = RecordingAgent(named_agent(given.agent, arguments)) if left else None
    for first in range(0, len(left), PARALLEL):
        assert agent is not None
        chosen = tuple(left[first : first + PARALLEL])
        play(agent, RolloutPlan(given.data, given.split, (given.lang,), 0, chosen=chosen))
        paths |= agent.paths
        new = path.with_suffix(".new")
        new.write_text(
            json.dumps({"about": about, "ways": [(*key, asdict(played_path)) for key, played_path in paths.items()]})
        )
        new.replace(path)
    return {key: played_path for key, played_path in sorted(paths.items()) if key[0] in wanted}


def main() -> None:
    """Play, draw, and write the table and the sheet."""
    parser = parser_of(__doc__)
    parser.add_argument("--data", type=Path, default=Path("arramon-data"))
    parser.add_argument("--agent", default="agents.vl_map")
    parser.add_argument(
        "--agent-arg", action="append", default=[], metavar="NAME=VALUE", help="a value is JSON or text"
    )
    parser.add_argument("--split", default="val_unseen")
    parser.add_argument("--lang", default="en")
    parser.add_argument("--episodes", type=int, default=40, help="the first ones; 0 for all")
    parser.add_argument("--worst", type=int, default=20, help="failures on the sheet")
    parser.add_argument("--output", type=Path, default=Path("arramon-results/trajectories"))
    given = parser.parse_args()
    split = read_split(split_folder(given.data, given.split))
    given.output.mkdir(parents=True, exist_ok=True)
    paths = read_or_play(given, split)
    turns = [
        classify(split.episodes[episode_id], turn, played_path) for (episode_id, turn), played_path in paths.items()
    ]
    for each in turns:
        draw(each, split.sections[each.episode.section], given.lang).save(given.output / f"{each.name}.png")
    (given.output / "worst.md").write_text(sheet(turns, given.lang, given.worst), encoding="utf-8")
    (given.output / "failures.md").write_text(table(turns, given.lang), encoding="utf-8")
    print(table(turns, given.lang).split("\n\n| episode")[0])


if __name__ == "__main__":
    main()
