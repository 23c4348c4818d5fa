"""How often walkers end turn 1 in the reference's heading: `python -m benchmarks.agents.last_heading DATA`.

Plays episodes of a data folder with `agents.follower`, from depth and true labels. After first turns in which it took
the right object, its own heading and the one that it estimates from its map are compared with the reference's, which
agents never see. Prints the share of first turns by the difference.
"""

from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from arramon_agents.follower import Agent
from arramon_agents.follower.reference_walk import last_heading
from arramon_agents.mapping.agent import PhasePlayer
from arramon_agents.mapping.body import AgentBody
from arramon_client.world import HEADINGS, TURN, turn_between
from arramon_dataset.generation import GenerationSite
from arramon_dataset.generation.navigation_tasks import follow_actions
from arramon_dataset.trial import play
from arramon_lang.meaning import Navigation
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import read_splits
from arramon_server.sim.own_furniture import furnished
from benchmarks.common import parser_of, positive_int, text_table

COLUMNS = (0, 30, 60)
"""Differences of headings, in degrees; the last column is for all from there on."""


class WatchedFollower(Agent):
    """Follower that remembers its own and its estimated heading at the start of turn 2.

    Attributes:
        headings: both, in multiples of 30 degrees clockwise from its first heading; None before turn 2, or if it took
            nothing in turn 1.
    """

    def __init__(self) -> None:
        super().__init__()
        self.headings: tuple[int, int] | None = None
        self._walk = self._skills.make_walk
        self._skills = replace(self._skills, make_walk=self._make_walk)

    def _make_walk(self, body: AgentBody, meaning: Navigation, turn: int) -> PhasePlayer:
        if turn == 2 and body.taken is not None:
            estimated = last_heading(body.ground, body.taken)
            self.headings = body.heading, body.heading if estimated is None else estimated
        return self._walk(body, meaning, turn)


def reference_heading(episode: Episode) -> int:
    """Return the heading in which turn 1 of an episode's reference ends, as `WatchedFollower.headings`."""
    _, end = follow_actions(episode.start, list(episode.turns[0].actions))
    return round(turn_between(episode.start.heading, end.heading) / TURN) % HEADINGS


def difference(heading: int, other: int) -> int:
    """Return the angle between two headings in multiples of 30 degrees, in degrees in [0, 180]."""
    apart = (heading - other) % HEADINGS
    return round(TURN) * min(apart, HEADINGS - apart)


def shares(differences: Iterable[int]) -> list[str]:
    """Return the share of differences in each of the columns."""
    counts = Counter(min(each, COLUMNS[-1]) for each in differences)
    return [f"{counts[column] / max(counts.total(), 1):.2f}" for column in COLUMNS]


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder of `arramon-server generate`")
    parser.add_argument("--split", default="val_unseen", help="one of its splits (default: %(default)s)")
    parser.add_argument("--language", default="en", help="language of the texts (default: %(default)s)")
    parser.add_argument("--episodes", type=positive_int, default=60, help="number of episodes (default: %(default)s)")
    arguments = parser.parse_args()

    split = read_splits(arguments.data)[arguments.split]
    sites = {name: GenerationSite(section) for name, section in split.sections.items()}
    own, estimated = [], []
    for episode in list(split.episodes.values())[: arguments.episodes]:
        site = sites[episode.section]
        if not episode.furniture.is_empty:
            site = GenerationSite(furnished(site.section, episode.furniture))
        follower = WatchedFollower()
        first, _ = play(follower, episode, arguments.language, site.in_episode(episode.layout)).turns
        if follower.headings is not None and first["CTC-0"]:
            reference = reference_heading(episode)
            own.append(difference(follower.headings[0], reference))
            estimated.append(difference(follower.headings[1], reference))
    header = ["", "turns", *(f"{column}" for column in COLUMNS[:-1]), f"{COLUMNS[-1]} and more"]
    rows = [["own", str(len(own)), *shares(own)], ["estimated", str(len(estimated)), *shares(estimated)]]
    print(text_table(header, rows))


if __name__ == "__main__":
    main()
