"""Writer of instructions for generated episodes: plans, phrases in all languages, and tests with an agent."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from random import Random
from typing import Protocol

import arramon_lang as lang
from arramon_client.agent import Agent
from arramon_client.plugin.loader import load_agent
from arramon_client.world import TURN, Action
from arramon_dataset.alignment.model import contradicts_route
from arramon_dataset.alignment.route_tokens import Tokens
from arramon_dataset.demands import add_demands
from arramon_dataset.generation import Draft, GenerationSite
from arramon_dataset.generation.batches import MakeWriter
from arramon_dataset.generation.command import generate
from arramon_dataset.generation.split_maker import GenerationProgress
from arramon_dataset.generation.split_specs import select_specs
from arramon_dataset.instructions.assembly.plan import plan_assembly
from arramon_dataset.instructions.assembly.visible_objects import whole_room
from arramon_dataset.instructions.gate.assembly import faults_of_assembly
from arramon_dataset.instructions.gate.texts import faults_of_text
from arramon_dataset.instructions.visible_landmarks import poses_along
from arramon_dataset.randomness import seeded
from arramon_dataset.trial import EarlyStop, play_or_stop_early
from arramon_dataset.turn_planner import TurnPlanner, manner_of
from arramon_lang.meaning import Assembly, Meaning, Navigation, Rotate, Thing, Where
from arramon_lang.quality import any_blocks, check
from arramon_lang.writing.voice import Manner, Voice
from arramon_server.episodes.episode import Episode, Instructions, Turn
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput
from arramon_server.scoring.episode_scores import EpisodeScores
from arramon_server.sim.geometry import Pose
from arramon_server.sim.rules import PlacedObject
from arramon_server.sim.section_world import EpisodeWorld

FOLLOWER = "agents.follower"
"""The agent that tests instructions, loaded by name because this package does not import agents."""

PLANS = 3
"""Maximum number of plans for one draft before the draft is discarded."""

DRAWS = 8
"""Maximum number of meanings drawn for one assembly instruction until the gate accepts one."""

DRAWINGS, FURTHER_DRAWINGS = 2, 4
"""Maximum number of drawings of a plan's texts in a language until one passes the checks: in a required language, whose
plan can be replaced, and in a further one."""

MIN_NDTW = 0.2
"""The follower's nDTW must exceed this in both turns (paper, section 4)."""

MUST_BE_ONE = ("CTC-3", "PTC")
"""Metrics that must be 1 in both turns: the follower reaches the target and places it correctly."""

REPORT_SECONDS = 5.0
"""Minimum seconds between two progress lines of one split."""

Plan = tuple[tuple[Navigation, Assembly], tuple[Navigation, Assembly]]
Texts = Mapping[str, tuple[Instructions, Instructions]]

Accepts = Callable[[str, tuple[Instructions, Instructions]], bool]
"""Whether a language's texts may be used; the arguments are its code and the texts."""

Write = Callable[[lang.Language, Meaning, Random, Voice], str]
"""A method of `Language` that writes a text: `write` or `draft`."""


class _WritesPlan(Protocol):
    """Returns a plan's texts in the language of a code, or None if a text fails a check; `names` seed them."""

    def __call__(
        self, code: str, names: tuple[object, ...], write: Write = lang.Language.write
    ) -> tuple[Instructions, Instructions] | None: ...


Readings = tuple[Meaning | str, ...]
"""Meanings of a language's texts; the text itself where it cannot be read."""


class InstructionWriter:
    """Writes a draft's instructions; accepts only those with which the follower succeeds in all required languages.

    A further language changes neither the plans nor the texts of the others: an episode that it cannot express, or in
    which the follower fails with its texts, lacks it.

    Args:
        languages: codes of the required languages.
        make_follower: returns a new agent that plays from text, depth and segmentation; called once per trial.
        trial: whether the follower must succeed with the texts. If not, the first that pass the checks are taken.
        further: codes of the languages to write where they can express the plan.

    Attributes:
        make_follower: the argument.
    """

    def __init__(
        self,
        languages: tuple[str, ...],
        make_follower: Callable[[], Agent],
        trial: bool = True,
        further: tuple[str, ...] = (),
    ) -> None:
        self._languages, self._trial, self._further = languages, trial, further
        self.make_follower = make_follower
        self._turns: dict[int, TurnPlanner] = {}

    def can_describe(
        self, start: Pose, turn: Turn, number: int, site: GenerationSite, names: tuple[object, ...]
    ) -> bool:
        """Return whether a plan describes the path of a turn; see `arramon_dataset.generation.DraftWriter`."""
        return self._planner(start, turn, number, site).navigation((*names, 0, number)) is not None

    def __call__(self, draft: Draft, site: GenerationSite, names: tuple[object, ...]) -> Texts | None:
        """Return instructions for a draft, or None if no plan passes; see `arramon_dataset.generation.DraftWriter`."""
        if not self._trial:
            return next(self.candidates(draft, site, names), None)
        passed: set[Readings] = set()
        tried = next(self.candidates(draft, site, names, partial(self._succeeds, draft, site, passed)), None)
        return None if tried is None else self._without_failed(draft, site, passed, tried)

    def candidates(
        self, draft: Draft, site: GenerationSite, names: tuple[object, ...], accepts: Accepts | None = None
    ) -> Iterator[Texts]:
        """Yield candidate instructions, one plan after another, that pass the quality checks.

        Args:
            draft, site, names: see `arramon_dataset.generation.DraftWriter`.
            accepts: called with the texts of each required language before those of the next one are written, and
                before all of them with a draft in the first language.
        """
        first, second = draft.turns
        end = poses_along(draft.start, first.path, first.actions)[-1]
        planners = self._planner(draft.start, first, 1, site), self._planner(end, second, 2, site)
        routes: list[Tokens] = []
        manner = manner_of(names)
        for number in range(PLANS):
            plan = _plan(draft, planners, (*names, number))
            if plan is None:
                return  # All draws failed; further ones would fail too.
            routes = routes or [turn.tokens() for turn in planners]
            texts = self._write(partial(_write_in, draft, plan, routes, manner), (*names, number), accepts)
            if texts is not None:
                yield texts

    def _planner(self, start: Pose, turn: Turn, number: int, site: GenerationSite) -> TurnPlanner:
        """Return the planner of a turn; the latest one for each number is cached."""
        kept = self._turns.get(number)
        if kept is None or kept.site is not site or kept.turn != turn:
            kept = self._turns[number] = TurnPlanner(start, turn, site)
        return kept

    def _write(self, write: _WritesPlan, names: tuple[object, ...], accepts: Accepts | None) -> Texts | None:
        """Return a plan's texts in all languages that express it, or None if a required one does not."""

        def first_of(code: str, drawings: int) -> tuple[Instructions, Instructions] | None:
            seeds = (names, *((*names, number) for number in range(1, drawings)))
            return next(filter(None, (write(code, seed) for seed in seeds)), None)

        if accepts is not None:
            # The follower fails with half of all plans, whatever their words: so it tries a draft first.
            code = self._languages[0]
            drafted = write(code, names, lang.Language.draft)
            if drafted is not None and not accepts(code, drafted):
                return None
        texts = {}
        for code in self._languages:
            written = first_of(code, DRAWINGS)
            if written is None or not (accepts is None or accepts(code, written)):
                return None
            texts[code] = written
        for code in self._further:
            written = first_of(code, FURTHER_DRAWINGS)
            if written is not None:
                texts[code] = written
        return dict(sorted(texts.items())) if self._further else texts

    def _succeeds(
        self,
        draft: Draft,
        site: GenerationSite,
        passed: set[Readings],
        code: str,
        written: tuple[Instructions, Instructions],
    ) -> bool:
        """Return whether the follower succeeds with a language's texts.

        The follower acts on a text's meaning alone, so texts with equal meanings are tried once: `passed` are those
        with which it has succeeded in this draft, to which this one is added.
        """
        read = _readings(written, code)
        if read not in passed:
            episode = draft.with_instructions({code: written})
            if not self._passes(episode, code, site.in_episode(episode.layout)):
                return False
            passed.add(read)
        return True

    def _without_failed(self, draft: Draft, site: GenerationSite, passed: set[Readings], texts: Texts) -> Texts:
        """Return the texts without those of further languages with which the follower fails."""
        return {
            code: written
            for code, written in texts.items()
            if code not in self._further or self._succeeds(draft, site, passed, code, written)
        }

    def _passes(self, episode: Episode, code: str, world: EpisodeWorld) -> bool:
        scores = play_or_stop_early(self.make_follower(), episode, code, world, EarlyStop(episode.turns, MIN_NDTW))
        return scores is not None and passes_trial(scores)


@dataclass(frozen=True, slots=True)
class WriterFactory:
    """Creates instruction writers that also write further languages; a `MakeWriter`.

    Attributes:
        further: codes of these languages.
        trial: whether the follower tries the texts.
    """

    further: tuple[str, ...]
    trial: bool

    def __call__(self) -> InstructionWriter:
        """Return an instruction writer for the required and the further languages."""
        return InstructionWriter(_languages(), type(load_agent(FOLLOWER)), self.trial, self.further)


def make_instruction_writer() -> InstructionWriter:
    """Return an instruction writer for the required languages; a `MakeWriter`.

    Raises:
        ValueError: if a language's data cannot express even the simplest meaning.
    """
    return InstructionWriter(_languages(), type(load_agent(FOLLOWER)))


def make_writer_without_trial() -> InstructionWriter:
    """Return an instruction writer for the required languages without trials by an agent; a `MakeWriter`.

    Raises:
        ValueError: if a language's data cannot express even the simplest meaning.
    """
    return InstructionWriter(_languages(), type(load_agent(FOLLOWER)), trial=False)


def _languages() -> tuple[str, ...]:
    """Return the codes of the required languages, each of which can express the simplest meanings."""
    thing = Thing("mug", "red", "dotted")
    for code in lang.required():
        for meaning in (
            Navigation((Rotate("right"),), thing),
            Assembly((), thing, (Where("behind", (Thing("ball"),)),)),
        ):
            lang.load(code).write(meaning, seeded(code))
    return lang.required()


def further_languages(requested: Sequence[str]) -> tuple[str, ...]:
    """Return the requested languages that are not required, sorted.

    Raises:
        BadInput: if a language does not exist, or a required one was not requested.
    """
    unknown, missing = sorted(set(requested) - {*lang.available()}), sorted({*lang.required()} - set(requested))
    if unknown:
        raise BadInput(f"there is no language {unknown[0]!r}; there are {', '.join(lang.available())}")
    if missing:
        always = ", ".join(lang.required())
        raise BadInput(f"every episode has {always}: expected {', '.join(missing)} in --languages too")
    return tuple(sorted(set(requested) - {*lang.required()}))


def generate_splits(
    data: Path,
    names: list[str] | None,
    *,
    scale: float,
    seed: int,
    jobs: int,
    write_line: Callable[[str], None],
    trial: bool = True,
    sections: int | None = None,
    secret: str = "",
    languages: Sequence[str] = (),
) -> list[Split]:
    """Generate the named splits (None: the paper's) for `arramon-server generate`; see `generation.command.generate`.

    Without the trial, an episode is kept once its texts pass the gate. `sections` is the number of sections of
    `train_extra`. `secret` seeds hidden splits in place of the host's secret, which is used if it is empty. Demands are
    written beside all splits except those for training. `languages` are the required ones and possibly further ones
    (default: the required ones).

    Raises:
        BadInput: see `further_languages`.
    """
    further = further_languages(languages or lang.required())
    made = generate(
        data,
        select_specs(names, sections),
        scale=scale,
        seed=seed,
        jobs=jobs,
        make_writer=_maker(trial, further),
        on_progress=throttled_progress(write_line),
        tried=trial,
        secret=secret,
        further={code: f"{code} (preview)" if lang.load(code).preview else code for code in further},
    )
    return [split if split.training else add_demands(data, split) for split in made]


def _maker(trial: bool, further: tuple[str, ...]) -> MakeWriter:
    if further:
        return WriterFactory(further, trial)
    return make_instruction_writer if trial else make_writer_without_trial


def throttled_progress(write_line: Callable[[str], None]) -> Callable[[GenerationProgress], None]:
    """Return a callback that writes each split's first and last progress, and one in REPORT_SECONDS between."""
    reported: dict[str, float] = {}

    def report(progress: GenerationProgress) -> None:
        since = progress.seconds - reported.get(progress.split, 0.0)
        if since >= REPORT_SECONDS or progress.done in (progress.kept, progress.total):
            reported[progress.split] = progress.seconds
            write_line(str(progress))

    return report


def passes_trial(scores: EpisodeScores) -> bool:
    """Return whether scores pass the paper's second validation stage, with the right objects picked up."""
    return all(turn["nDTW"] > MIN_NDTW and all(turn[name] == 1.0 for name in MUST_BE_ONE) for turn in scores.turns)


def _plan(draft: Draft, planners: tuple[TurnPlanner, TurnPlanner], names: tuple[object, ...]) -> Plan | None:
    """Return the meanings of both turns' instructions, or None if a planner fails."""
    room, planned = draft.decoys, []
    for number, turn in enumerate(draft.turns, start=1):
        navigation = planners[number - 1].navigation((*names, number))
        if navigation is None:
            return None
        randoms = (seeded(*names, number, "assembly", draw) for draw in range(DRAWS))
        assembly = next(filter(None, (_assembly(turn, room, random) for random in randoms)), None)
        if assembly is None:
            return None
        planned.append((navigation, assembly))
        room = (*room, PlacedObject(turn.target.type, turn.target_cell))
    return planned[0], planned[1]


def _assembly(turn: Turn, room: tuple[PlacedObject, ...], random: Random) -> Assembly | None:
    """Draw a meaning of an assembly instruction, and return it, or None if the gate rejects it."""
    meaning = plan_assembly(turn.target.type, turn.target_cell, room, random)
    cell = turn.target_cell.column, turn.target_cell.row
    return None if meaning is None or faults_of_assembly(meaning, cell, whole_room(room)) else meaning


def _write_in(
    draft: Draft,
    plan: Plan,
    routes: Sequence[Tokens],
    manner: Manner,
    code: str,
    names: tuple[object, ...],
    write: Write = lang.Language.write,
) -> tuple[Instructions, Instructions] | None:
    """Return a plan's texts in one language, or None if a text fails a check."""
    voice = lang.load(code).draw_voice(seeded(*names, code, "voice"), manner)
    turns = []
    for number, (turn, meanings, route) in enumerate(zip(draft.turns, plan, routes, strict=True), start=1):
        navigation = _phrase(code, "navigation", turn, meanings[0], voice, (*names, code, number), write)
        if navigation is None or contradicts_route(navigation, code, route):
            return None
        assembly = _phrase(code, "assembly", turn, meanings[1], voice, (*names, code, number), write)
        if assembly is None:
            return None
        turns.append(Instructions(navigation, assembly))
    return turns[0], turns[1]


def _phrase(
    code: str, phase: str, turn: Turn, meaning: Meaning, voice: Voice, names: tuple[object, ...], write: Write
) -> str | None:
    """Return one instruction, or None if it cannot be expressed or fails a blocking check."""
    try:
        text = write(lang.load(code), meaning, seeded(*names, phase), voice)
    except ValueError:
        return None  # The language cannot express a part, such as a number of paces; another plan may not need it.
    target = turn.target.type
    failures = check(
        text,
        code,
        phase,
        target=Thing(target.kind, target.colour, target.pattern),
        first_turn=initial_turn_angle(turn.actions),
    )
    return None if any_blocks(failures) or faults_of_text(text, code, meaning) else text


def initial_turn_angle(actions: tuple[Action, ...]) -> float:
    """Return the absolute angle in degrees by which a ground truth turns before its first step forward."""
    turned = 0.0
    for action in actions:
        if action not in (Action.LEFT, Action.RIGHT):
            break
        turned += TURN if action is Action.RIGHT else -TURN
    return abs(turned)


def _readings(texts: tuple[Instructions, Instructions], code: str) -> Readings:
    """Return the meanings of a language's texts; the text itself if it cannot be read."""
    speech = lang.load(code)
    read: list[Meaning | str] = []
    for turn in texts:
        for phase, text in (("navigation", turn.navigation), ("assembly", turn.assembly)):
            try:
                read.append(speech.read(text, phase))
            except lang.CannotRead:
                read.append(text)
    return tuple(read)
