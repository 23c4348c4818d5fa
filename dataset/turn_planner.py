"""Planning of valid navigation instructions for one turn of a draft."""

from dataclasses import replace
from random import Random

from arramon_dataset.alignment.route_tokens import Tokens, tokens_of
from arramon_dataset.generation.site import GenerationSite
from arramon_dataset.instructions.gate.navigation import NavigationCheck, faults_of_navigation
from arramon_dataset.instructions.gate.world import GateWorld
from arramon_dataset.instructions.navigation.plan import plan_navigation
from arramon_dataset.instructions.visible_landmarks import find_landmarks, poses_along
from arramon_dataset.paraphrases.route_facts import facts_along
from arramon_dataset.randomness import seeded
from arramon_lang.coreference import mentions, things_of
from arramon_lang.meaning import Navigation, Step, Walk
from arramon_lang.writing.voice import Manner, draw_manner
from arramon_server.episodes.episode import Turn
from arramon_server.sim.geometry import Pose

OMITTED_PASSING = 0.6
"""Probability of leaving out a walk past a thing that the way does not need; divided by how much a speaker says."""


def manner_of(names: tuple[object, ...]) -> Manner:
    """Return the manner of an episode's texts; `names` are those of its draft."""
    return draw_manner(seeded(*names, "manner"))


class TurnPlanner:
    """Plans valid navigation instructions for one turn.

    Args:
        start: pose at its beginning.
        turn: of a draft.
        site: where it takes place.

    Attributes:
        turn, site: the arguments.
    """

    def __init__(self, start: Pose, turn: Turn, site: GenerationSite) -> None:
        self.turn, self.site = turn, site
        self._poses = poses_along(start, turn.path, turn.actions)
        self._landmarks = find_landmarks(self._poses, turn.street, site.section, site.landmark_camera, site.graph)
        goal = turn.target.position.x, turn.target.position.z
        self._world = GateWorld(turn.path, self._poses[0], self._landmarks, goal, site.graph, self._poses)
        self._drawn: dict[tuple[object, ...], Navigation | None] = {}

    def navigation(self, names: tuple[object, ...]) -> Navigation | None:
        """Return a meaning of its navigation that passes the gate, or None.

        Args:
            names: seed of all choices; the last two are the number of the plan and of the turn.
        """
        if names not in self._drawn:
            self._drawn[names] = self._draw(names)
        return self._drawn[names]

    def tokens(self) -> Tokens:
        """Return the tokens of its route, for the alignment check, which shares nothing with the grammar."""
        return tokens_of(facts_along(self.turn, self._poses, self._landmarks), self.turn.target.type)

    def _draw(self, names: tuple[object, ...]) -> Navigation | None:
        turn, check = self.turn, NavigationCheck(self._world)
        random, manner = seeded(*names), manner_of(names[:-2])
        meaning = plan_navigation(
            turn.path,
            self._poses,
            turn.target,
            turn.street,
            self._landmarks,
            random,
            self.site.graph,
            check,
            manner,
            names[-1] == 1,
        )
        if meaning is None or faults_of_navigation(meaning, self._world):
            return None
        brief = _without_idle_walks(meaning)
        meaning = meaning if brief == meaning or faults_of_navigation(brief, self._world) else brief
        return self._without_needless_passing(meaning, random, OMITTED_PASSING / manner.says_more)

    def _without_needless_passing(self, meaning: Navigation, random: Random, share: float) -> Navigation:
        """Return a meaning without some walks past things that the way does not need, each with a probability."""
        number = 0
        while number < len(meaning.steps) - 1:
            step, after = meaning.steps[number : number + 2]
            is_plain = isinstance(step, Walk) and step.way == "past" and not _is_referred_to(number, meaning)
            if is_plain and random.random() < share:
                onward = replace(after, straight=False) if isinstance(after, Walk) else after
                brief = replace(meaning, steps=(*meaning.steps[:number], onward, *meaning.steps[number + 2 :]))
                if not faults_of_navigation(brief, self._world):
                    meaning = brief
                    continue
            number += 1
        return meaning


def _is_referred_to(number: int, meaning: Navigation) -> bool:
    """Return whether a later step names a thing of this step again, or another of its kind as "the next" one."""
    step, later = meaning.steps[number], replace(meaning, steps=meaning.steps[number + 1 :])
    here = things_of(step)
    return any(
        thing.identity == other.identity or (thing.kind == other.kind and other.which != "")
        for thing in here
        for other in mentions(later)
    )


def _without_idle_walks(meaning: Navigation) -> Navigation:
    """Return a meaning without walks straight ahead before another walk: "go forward, go past the bench"."""
    steps: list[Step] = []
    for step in meaning.steps:
        if isinstance(step, Walk) and step.way not in ("beside", "until") and steps[-1:] == [Walk("ahead")]:
            steps[-1] = replace(step, straight=False)
        else:
            steps.append(step)
    return replace(meaning, steps=tuple(steps))
