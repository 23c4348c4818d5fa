"""Scores of the rules' navigation in simulated walks: `python -m benchmarks.agents.simulated_rules DATA [options]`.

The rules of `agents.seeing_follower` walk both turns of a split's episodes without rendering: the body perceives by
geometry, with the measured error rates of the visual encoder (`agents.simulated.body`), and the learned reader reads
the texts. An episode takes a fraction of a second, so that a change of the rules is measured on hundreds of turns in a
minute. The level is not that of rendered episodes; differences between rules are what it is for.

Prints nDTW, CTC-3 and the share of picked targets, for all turns, first turns, and second turns after a good first one
(the target was picked up). `--save` keeps the turns; `--against` compares with kept ones, paired by episode, with 95%
intervals. `--heading true` begins second turns from the reference's last heading, and `--reading grammar --errors 0` is
reading and perception without errors.
"""

import argparse
import json
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from arramon_agents.follower.agent import make_estimating_navigator, make_rule_navigator
from arramon_agents.follower.navigation import Navigator
from arramon_agents.mapping.agent import PhasePlayer
from arramon_agents.mapping.motion import TURN
from arramon_agents.reading.reader.reader import load as load_reader
from arramon_agents.reading.reader.slots import meaning_of
from arramon_agents.simulated.body import PerceptionErrorRates, SimulatedBody
from arramon_agents.simulated.courses import Course, courses_of
from arramon_agents.simulated.walks import act_until_picked
from arramon_client.agent import Action
from arramon_client.world import HEADINGS, NAVIGATION
from arramon_lang.meaning import Navigation
from arramon_server.episodes.splits import read_named_split
from arramon_server.scoring.metrics import ndtw
from benchmarks.common import parser_of, text_table

METRICS = ("nDTW", "CTC-3", "picked")


@dataclass(frozen=True)
class WalkedTurn:
    """A turn that was walked by the rules.

    Attributes:
        episode: id of the episode.
        turn: 1 or 2.
        scores: by METRICS.
        path: positions in the world.
        picked: index of the object that was picked up, 0 for the target; None for none.
        notes: what the rules were doing at each action.
    """

    episode: str
    turn: int
    scores: dict[str, float]
    path: list[tuple[float, float]]
    picked: int | None
    notes: list[str]


class Settings(NamedTuple):
    """How turns are walked.

    Attributes:
        heading: "own", "estimate" or "true": from where second turns are followed.
        reading: index among the readings of a course: 0 for the grammar's, 1 for the learned reader's.
        errors: factor of the error rates of perception.
        seed: of the perception errors.
    """

    heading: str
    reading: int
    errors: float
    seed: int


def make_player(body: SimulatedBody, course: Course, meaning: Navigation, settings: Settings) -> PhasePlayer:
    """Return the player of a turn."""
    if settings.heading == "true" and course.turn == 2:
        start = round((course.start[2] - body.frame.heading) / TURN) % HEADINGS
        return Navigator(body, meaning, start)
    make = make_rule_navigator if settings.heading == "own" else make_estimating_navigator
    return make(body, meaning, course.turn)


def walk_episode(name: str, courses: Sequence[Course], settings: Settings) -> Iterator[WalkedTurn]:
    """Walk the turns of an episode; each begins where the one before ended."""
    draws = np.random.default_rng((settings.seed, *name.encode()))
    faults = PerceptionErrorRates().scaled(settings.errors)
    body = None
    for course in courses:
        rows = course.readings[min(settings.reading, len(course.readings) - 1)]
        meaning = meaning_of(rows, NAVIGATION)
        assert isinstance(meaning, Navigation)
        if body is None:
            body = SimulatedBody(course.world, course.things, course.start, faults, draws)
        else:
            body.begin_turn(course.things)
            body.landmarks.forget()
        yield walk_turn(name, course, body, make_player(body, course, meaning, settings))


def walk_turn(name: str, course: Course, body: SimulatedBody, player: PhasePlayer) -> WalkedTurn:
    """Walk one turn with a player, until it picks up an object or has no step left."""
    notes: list[str] = []

    def act(left: int) -> Action:
        action = player.act(left)
        notes.append(f"{action.name} {json.dumps(player.intent())}")
        return action

    path, picked = act_until_picked(course, body, act)
    far = math.dist(path[-1], course.target)
    values = ndtw(path, [tuple(each) for each in course.path.tolist()]), float(far < 3.0), float(picked == 0)
    return WalkedTurn(name, course.turn, dict(zip(METRICS, values, strict=True)), path, picked, notes)


def summary(turns: Sequence[WalkedTurn]) -> str:
    """Return the table of scores."""
    good = {each.episode for each in turns if each.turn == 1 and each.picked == 0}
    groups = {
        "all": turns,
        "first turns": [each for each in turns if each.turn == 1],
        "second turns": [each for each in turns if each.turn == 2],
        "second turns after a good first": [each for each in turns if each.turn == 2 and each.episode in good],
    }
    rows = [
        [name, str(len(group)), *(f"{np.mean([each.scores[metric] for each in group]):.3f}" for metric in METRICS)]
        for name, group in groups.items()
        if group
    ]
    return text_table(["", "turns", *METRICS], rows)


def comparison(turns: Sequence[WalkedTurn], before: Sequence[WalkedTurn]) -> str:
    """Return the mean differences by episode, with 95% intervals."""
    lines = []
    for metric in METRICS:
        values: dict[str, list[float]] = {}
        known = {(each.episode, each.turn): each.scores[metric] for each in before}
        for each in turns:
            if (each.episode, each.turn) in known:
                values.setdefault(each.episode, []).append(each.scores[metric] - known[each.episode, each.turn])
        means = np.array([np.mean(each) for each in values.values()])
        half = 1.96 * means.std(ddof=1) / math.sqrt(len(means))
        lines.append(f"{metric} {means.mean():+.3f} ({means.mean() - half:+.3f} to {means.mean() + half:+.3f})")
    return "difference: " + ", ".join(lines)


def options() -> argparse.ArgumentParser:
    """Return the parser of the command's arguments."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder of `arramon-server generate`")
    parser.add_argument("--split", default="val_unseen", help="one of its splits (default: %(default)s)")
    parser.add_argument("--language", default="en", help="language of the texts (default: %(default)s)")
    parser.add_argument("--episodes", type=int, default=0, help="the first in playing order; 0 for all")
    parser.add_argument("--heading", choices=("own", "estimate", "true"), default="estimate")
    parser.add_argument("--reading", choices=("grammar", "learned"), default="learned")
    parser.add_argument("--errors", type=float, default=1.0, help="factor of the error rates of perception")
    parser.add_argument("--seed", type=int, default=0, help="of the perception errors")
    parser.add_argument("--save", type=Path, metavar="FILE", help="output file for the turns")
    parser.add_argument("--against", type=Path, metavar="FILE", help="file of an earlier `--save` to compare with")
    return parser


def main() -> None:
    """Run the benchmark and print its tables."""
    given = options().parse_args()
    split = read_named_split(given.data, given.split)
    episodes = split.in_playing_order(given.language)[: given.episodes or None]
    courses = list(courses_of(split, episodes, [given.language], load_reader()))
    reading = ("grammar", "learned").index(given.reading)
    settings = Settings(given.heading, reading, given.errors, given.seed)
    began = time.process_time()
    turns = [
        walked
        for episode, pair in zip(episodes, zip(courses[::2], courses[1::2], strict=True), strict=True)
        for walked in walk_episode(episode.episode_id, pair, settings)
    ]
    print(summary(turns))
    print(f"{(time.process_time() - began) / len(episodes):.2f} s of processor time an episode")
    if given.save:
        given.save.write_text(json.dumps([asdict(each) for each in turns]))
    if given.against:
        print(comparison(turns, [WalkedTurn(**each) for each in json.loads(given.against.read_text())]))


if __name__ == "__main__":
    main()
