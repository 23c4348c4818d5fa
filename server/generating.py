"""Writes and tries the instructions of generated episodes: plan once, say it in every language, see where it leads."""

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path

import lang
from arramon_client.agent import Agent
from arramon_client.loading import load_agent
from lang.meaning import Assembly, Meaning, Navigation, Thing, Where
from lang.meaning import Turn as Step
from lang.quality import check, is_blocked
from server.episodes.chance import seeded
from server.episodes.episode import Instructions, Turn
from server.episodes.generate import Draft, Site
from server.episodes.generate.command import Progress, generate
from server.episodes.generate.sizes import chosen
from server.episodes.instruct.assembly import plan_assembly
from server.episodes.instruct.navigation import plan_navigation
from server.episodes.instruct.sight import Landmark, look, poses_along
from server.episodes.splits import Split
from server.scoring.episode import EpisodeScores
from server.sim.cameras import Camera
from server.sim.geometry import TURN, Pose
from server.sim.raster import RasterCamera
from server.sim.room_scene import room_scene
from server.sim.rules import Action, PlacedObject
from server.trial import Place, play

FOLLOWER = "agents.follower"
"""The agent that tries instructions; by name, as the server imports no agents."""

PLANS = 4
"""Plans made of one draft before another is drawn."""

MIN_NDTW = 0.2
"""What a follower's nDTW must be above in both turns (paper, section 4)."""

MUST_BE_ONE = ("CTC-3", "PTC")
"""What must be 1 in both turns besides: it comes to the target, and places it where it belongs."""

TELL_SECONDS = 5.0
"""Between two lines of progress of one split."""

Plan = tuple[tuple[Navigation, Assembly], tuple[Navigation, Assembly]]
Texts = Mapping[str, tuple[Instructions, Instructions]]


class Scribe:
    """Writes a draft's instructions in every language, and keeps those that the follower is led by in all of them.

    Args:
        languages: codes.
        make_follower: makes what plays from text, depth and segmentation: a new one for each trial, which remembers
            nothing.

    Attributes:
        make_follower: as it was given.
    """

    def __init__(self, languages: tuple[str, ...], make_follower: Callable[[], Agent]) -> None:
        self._languages = languages
        self.make_follower = make_follower

    def __call__(self, draft: Draft, site: Site, names: tuple[object, ...]) -> Texts | None:
        """As `server.episodes.generate.Writer`."""
        return next((texts for texts in self.tellings(draft, site, names) if self._leads(draft, site, texts)), None)

    def tellings(self, draft: Draft, site: Site, names: tuple[object, ...]) -> Iterator[Texts]:
        """What may be said of a draft, one plan after another, in texts that pass the checks and are not tried yet."""
        sights = _sights(draft, site)
        for number in range(PLANS):
            plan = _plan(draft, sights, (*names, number))
            texts = self._write(draft, plan, (*names, number)) if plan is not None else None
            if texts is not None:
                yield texts

    def _write(self, draft: Draft, plan: Plan, names: tuple[object, ...]) -> Texts | None:
        """The plan in every language; None if a text fails a check."""
        texts = {}
        for code in self._languages:
            turns = []
            for number, (turn, meanings) in enumerate(zip(draft.turns, plan, strict=True), start=1):
                navigation = _say(code, "navigation", turn, meanings[0], (*names, code, number))
                assembly = _say(code, "assembly", turn, meanings[1], (*names, code, number))
                if navigation is None or assembly is None:
                    return None
                turns.append(Instructions(navigation, assembly))
            texts[code] = (turns[0], turns[1])
        return texts

    def _leads(self, draft: Draft, site: Site, texts: Texts) -> bool:
        """Whether the follower passes in every language.

        It goes by what it reads: languages whose texts it reads alike are tried once.
        """
        episode = draft.spoken(texts)
        place = Place(site.world, site.camera, room_camera())
        first_of = {_read(texts[code], code): code for code in reversed(self._languages)}
        return all(passes(play(self.make_follower(), episode, code, place)) for code in first_of.values())


def make_scribe() -> Scribe:
    """A scribe of all languages; for `generate.MakeWriter`.

    Raises:
        ValueError: if the data of one cannot say even the simplest thing.
    """
    thing = Thing("mug", "red", "dotted")
    for code in lang.available():
        for meaning in (Navigation((Step("right"),), thing), Assembly((), thing, (Where("behind", (Thing("ball"),)),))):
            lang.load(code).write(meaning, seeded(code))
    return Scribe(lang.available(), type(load_agent(FOLLOWER)))


def generate_splits(
    data: Path, names: list[str] | None, *, scale: float, seed: int, jobs: int, tell: Callable[[str], None]
) -> list[Split]:
    """What `arramon-server generate` does: splits of these names, all for None; see `generate.command.generate`."""
    told: dict[str, float] = {}

    def tell_of(progress: Progress) -> None:
        since = progress.seconds - told.get(progress.split, 0.0)
        if since >= TELL_SECONDS or progress.done == progress.total:
            told[progress.split] = progress.seconds
            tell(str(progress))

    return generate(data, chosen(names), scale=scale, seed=seed, jobs=jobs, make_writer=make_scribe, tell=tell_of)


def passes(scores: EpisodeScores) -> bool:
    """Whether a follower was led where it should (the paper's second stage, and to the right object)."""
    return all(turn["nDTW"] > MIN_NDTW and all(turn[name] == 1.0 for name in MUST_BE_ONE) for turn in scores.turns)


Sights = tuple[tuple[tuple[Pose, ...], tuple[Landmark, ...]], ...]


def _sights(draft: Draft, site: Site) -> Sights:
    """For each turn the poses of its ground truth, and what is seen from them."""
    sights, start = [], draft.start
    for turn in draft.turns:
        poses = poses_along(start, turn.path, turn.actions)
        sights.append((tuple(poses), look(poses, turn.street, site.section, site.camera)))
        start = poses[-1]
    return tuple(sights)


def _plan(draft: Draft, sights: Sights, names: tuple[object, ...]) -> Plan | None:
    """What both turns' instructions say; None where a planner finds nothing."""
    room, planned = draft.decoys, []
    for number, (turn, (poses, marks)) in enumerate(zip(draft.turns, sights, strict=True), start=1):
        random = seeded(*names, number, "plan")
        navigation = plan_navigation(turn.path, poses, turn.target, turn.street, marks, random)
        assembly = plan_assembly(turn.target.type, turn.target_cell, room, random)
        if navigation is None or assembly is None:
            return None
        planned.append((navigation, assembly))
        room = (*room, PlacedObject(turn.target.type, turn.target_cell))
    return planned[0], planned[1]


def _say(code: str, phase: str, turn: Turn, meaning: Meaning, names: tuple[object, ...]) -> str | None:
    """One instruction; None if it cannot be said, or fails a check that blocks."""
    try:
        text = lang.load(code).write(meaning, seeded(*names, phase))
    except ValueError:
        return None  # The language has no words for something, such as so many paces: another plan may do without.
    target = turn.target.type
    failures = check(
        text,
        code,
        phase,
        target=Thing(target.kind, target.colour, target.pattern),
        first_turn=first_turn(turn.actions),
    )
    return None if is_blocked(failures) else text


def first_turn(actions: tuple[Action, ...]) -> float:
    """The degrees, either way, by which a ground truth turns before its first step."""
    turned = 0.0
    for action in actions:
        if action not in (Action.LEFT, Action.RIGHT):
            break
        turned += TURN if action is Action.RIGHT else -TURN
    return abs(turned)


def _read(texts: tuple[Instructions, Instructions], code: str) -> tuple[Meaning | str, ...]:
    """What is read in a language's texts; of one that cannot be read, the text itself."""
    speech = lang.load(code)
    read: list[Meaning | str] = []
    for turn in texts:
        for phase, text in (("navigation", turn.navigation), ("assembly", turn.assembly)):
            try:
                read.append(speech.read(text, phase))
            except lang.CannotRead:
                read.append(text)
    return tuple(read)


@cache
def room_camera() -> Camera:
    """The room's camera, one for all trials of a process."""
    return RasterCamera(room_scene())
