"""Walks of episodes in rendered streets, seen by the visual encoder: labelled decisions to train `vl_map` with."""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.probabilistic_landmark_memory import ProbabilisticLandmarkMemory
from arramon_agents.perception.eyes.encoder import load_far
from arramon_agents.perception.eyes.perception import EyesPerception
from arramon_agents.perception.eyes.predicted_segmentation import LABELS
from arramon_agents.simulated.courses import TrainingCourses
from arramon_agents.simulated.episode_walks import EpisodeWalk, PlannedWalk, walk_in_processes
from arramon_agents.simulated.walks import CourseGuide, LabelledDecision, RecordedPolicy
from arramon_agents.simulated.world_frame import WorldFrame
from arramon_agents.vl_map.navigator import MapNavigator
from arramon_agents.vl_map.network import PolicyNetwork
from arramon_agents.vl_map.policy import MapPolicy
from arramon_client.environments.backend import Player, PlayerSettings
from arramon_client.environments.options import Options
from arramon_client.environments.players import open_backend
from arramon_client.world import NAVIGATION

IMAGE_SIZE = 224
"""Side length of the images, in pixels."""

ASTRAY = 0.05
"""Share of decisions in which the label is followed instead of the policy."""


class RenderedStreets(NamedTuple):
    """Where the episodes are rendered from.

    Attributes:
        data: data folder.
        language: any language that the splits have: the courses have the instructions as they were read.
    """

    data: Path
    language: str


class RenderedWalker:
    """Walks the navigation phases of episodes by a policy, on rendered images.

    Args:
        streets: where they are rendered from.
        courses: the episodes' courses.
        network: network of the policy.
    """

    def __init__(self, streets: RenderedStreets, courses: TrainingCourses, network: PolicyNetwork) -> None:
        self._streets, self._courses, self._policy = streets, courses, MapPolicy([network])
        self._backend = open_backend(Options(data=streets.data))
        self._perceive = EyesPerception(load_far())
        self._players: dict[str, Player] = {}

    def walk(self, planned: PlannedWalk) -> EpisodeWalk:
        """Walk both turns of an episode; the ground truth plays the room between them."""
        courses, draws = self._courses.pairs[planned.pair], np.random.default_rng(planned.seed)
        split, episode_id = self._courses.names[planned.pair]
        player = self._player(split)
        frame = WorldFrame(*courses[0].start)
        body = AgentBody(LABELS, ProbabilisticLandmarkMemory(LABELS))
        observation = player.begin(episode_id, 0)
        decided: list[LabelledDecision] = []
        for course in courses:
            rows = course.readings[(planned.reading + course.turn) % len(course.readings)]
            policy = RecordedPolicy(CourseGuide(course, rows, body, frame), draws, self._policy.option_values, ASTRAY)
            navigator = MapNavigator(body, rows, policy, course.turn)
            body.record_action(None)
            body.landmarks.forget_collectibles()
            while observation.turn == course.turn:
                (percept,) = self._perceive([observation])
                body.perceive(percept.observation, percept.things)
                action = navigator.act(observation.steps_left)
                body.record_action(action)
                step = player.step(action)
                if step.ending is not None:
                    break
                assert step.observation is not None
                observation = step.observation
            decided += policy.decisions
        assert step.ending is not None
        assert step.ending.scores is not None
        scores = step.ending.scores
        return EpisodeWalk(decided, sum(round(scores[f"turn {course.turn}"]["CTC-0"]) for course in courses))

    def _player(self, split: str) -> Player:
        if split not in self._players:
            language = self._streets.language
            settings = PlayerSettings(language, split, ("rgb", "depth"), IMAGE_SIZE, phases=(NAVIGATION,))
            self._players[split] = self._backend.player(settings)
        return self._players[split]


def walk_rendered_episodes(
    streets: RenderedStreets,
    courses: TrainingCourses,
    planned: Sequence[PlannedWalk],
    network: PolicyNetwork,
    processes: int = 1,
) -> Iterator[EpisodeWalk]:
    """Return the results of walks in order; they do not depend on the number of processes.

    Args:
        streets, courses, network: as for `RenderedWalker`.
        planned: the walks.
        processes: number of processes.
    """
    make = partial(RenderedWalker, streets, courses, network)
    return walk_in_processes(make, planned, processes, "walks in rendered streets")
