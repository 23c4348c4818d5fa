"""Training data of the learned reader: pairs of text and meaning in every language.

New meanings are made from those of a split by exchanging things and combining steps; grammars write their texts. Some
are written once more in a form that people type: with typing errors, in keywords, romanised, with English words.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from random import Random

import arramon_lang as lang
from arramon_agents.perception.eyes.vocabulary import LOOK_GROUPS
from arramon_agents.simulated.training_split import read_training_split
from arramon_client.world import ASSEMBLY, BANNER_COLOURS, COLLECTIBLE_COLOURS, COLLECTIBLES, FURNITURE, NAVIGATION
from arramon_dataset.forms.forms import FORMS, FormWriter, draw_voices
from arramon_dataset.parallel import process_pool
from arramon_lang.meaning import TURNS, Assembly, Face, Meaning, Navigation, Rotate, Step, Thing, Walk, Where
from arramon_server.sim.assets.furniture import COLOURS

NAVIGATION_SHARE = 0.7
"""Share of navigation texts: they are longer and more varied than assembly texts."""

COMBINED_SHARE = 0.4
"""Share of navigation texts that combine the steps of two meanings."""

REPLACED_SHARE = 0.8
"""Share of texts in which things are replaced."""

REDRAWN_SHARE = 0.25
"""Share of directions, sides and ordinals that are redrawn where things are replaced."""

FORM_SHARE = 0.8
"""Share of new texts that are written once more, in a form."""

FORM_WEIGHTS = {"typing": 2.0, "romanised": 3.0}
"""Relative frequency of each form among those of its language; 1 for the others, which are nearer to plain texts."""

CHUNK = 200
"""Number of texts that a process is given at a time."""

INTERSECTION_ARMS = (3, 4)
"""Possible numbers of streets at an intersection, which cannot be parsed from every text."""

ORDINALS = ("first", "second", "third", "last")

_LOOKS = {group.name: group.looks for group in LOOK_GROUPS}


@dataclass(frozen=True, slots=True)
class TextSample:
    """An instruction with its meaning.

    Attributes:
        text: the instruction.
        language: language code.
        meaning: meaning of the instruction.
    """

    text: str
    language: str
    meaning: Meaning


def read_samples(data: Path, split: str) -> list[TextSample]:
    """Return a split's instructions in the required languages, with their meanings parsed by the languages' grammars.

    Args:
        data: data folder.
        split: name of the split.

    Raises:
        UsageError: if there is no such split, or a file of it is invalid.
    """
    samples = []
    for episode in read_training_split(data, split).episodes.values():
        for language in lang.required():
            for turn in episode.instructions.get(language, ()):
                for phase, text in (("navigation", turn.navigation), ("assembly", turn.assembly)):
                    samples.append(TextSample(text, language, lang.load(language).read(text, phase)))
    return samples


def draw_samples(
    plans: Sequence[Meaning], languages: Sequence[str], count: int, seed: int, processes: int = 1
) -> Iterator[TextSample]:
    """Yield new texts with their meanings, alternating between languages; after some comes the same text in a form.

    The texts do not depend on the number of processes.

    Args:
        plans: meanings to start from.
        languages: language codes.
        count: number of new texts, without those in a form.
        seed: seed of all random choices.
        processes: number of processes.
    """
    walks = [plan for plan in plans if isinstance(plan, Navigation)]
    rooms = [plan for plan in plans if isinstance(plan, Assembly)]
    draw = partial(_draw, walks, rooms, tuple(languages), seed)
    if processes <= 1:
        for number in range(count):
            yield from draw(number)
        return
    with process_pool(processes, "writes texts") as pool:
        for drawn in pool.map(draw, range(count), chunksize=CHUNK):
            yield from drawn


def _draw(
    walks: Sequence[Navigation], rooms: Sequence[Assembly], languages: Sequence[str], seed: int, number: int
) -> list[TextSample]:
    """Return the new text of a number, and its form if it has one."""
    random = Random(f"{seed}/{number}")  # noqa: S311 - nothing here is a secret
    language = languages[number % len(languages)]
    while True:
        in_street = not rooms or (walks and random.random() < NAVIGATION_SHARE)
        meaning: Meaning = random.choice(walks) if in_street else random.choice(rooms)
        if isinstance(meaning, Navigation) and random.random() < COMBINED_SHARE:
            meaning = _splice(meaning, random.choice(walks), random)
        if random.random() < REPLACED_SHARE:
            meaning = randomise_things(meaning, random)
        try:
            text = lang.load(language).write(meaning, random)
        except ValueError:  # The language has no words for it.
            continue
        found = [TextSample(text, language, meaning)]
        return [*found, *_in_a_form(found[0], random)] if random.random() < FORM_SHARE else found


def _in_a_form(sample: TextSample, random: Random) -> list[TextSample]:
    """Return a text in a form of its language, if it can be written in the form."""
    forms = [form for form, languages in FORMS.items() if sample.language in languages]
    if not forms:
        return []
    (form,) = random.choices(forms, [FORM_WEIGHTS.get(form, 1.0) for form in forms])
    writer = FormWriter(form, sample.language, random, draw_voices(sample.language, random))
    phase = NAVIGATION if isinstance(sample.meaning, Navigation) else ASSEMBLY
    try:
        return [replace(sample, text=writer.write(sample.text, phase))]
    except ValueError:  # The grammar does not read it, or has no words for what it reads.
        return []


def write_in_all_languages(plans: Sequence[Meaning], languages: Sequence[str], seed: int) -> Iterator[TextSample]:
    """Yield a text for each meaning in each language that can express it.

    Args:
        plans: the meanings.
        languages: language codes.
        seed: seed of all random choices.
    """
    for number, meaning in enumerate(plans):
        for language in languages:
            random = Random(f"{seed}/{number}/{language}")  # noqa: S311 - nothing here is a secret
            try:
                yield TextSample(lang.load(language).write(meaning, random), language, meaning)
            except ValueError:
                continue


def randomise_things(meaning: Meaning, random: Random) -> Meaning:
    """Replace the things of a meaning by random ones, and redraw some directions.

    All mentions of a thing are replaced by the same thing.
    """
    others: dict[str, tuple[str, str, str]] = {}
    arms: dict[str, int] = {}

    def other(thing: Thing) -> Thing:
        key = thing.identity or repr(thing)
        if key not in others:
            others[key] = _other(thing, random)
            arms[key] = random.choice(INTERSECTION_ARMS) if thing.kind == "intersection" else 0
        kind, colour, look = others[key]
        # Name the new thing by the same attributes as the old one.
        colour, look = colour if thing.colour else "", look if thing.look else ""
        where = tuple(replace(each, things=tuple(map(other, each.things))) for each in thing.where)
        which = drawn(thing.which, ORDINALS) if thing.which in ORDINALS else thing.which
        kind = kind if thing.kind else ""
        return replace(thing, kind=kind, colour=colour, look=look, which=which, where=where, arms=arms[key])

    def drawn(said: str, values: Sequence[str]) -> str:
        return random.choice(values) if said and random.random() < REDRAWN_SHARE else said

    def step_with(step: Step) -> Step:
        if isinstance(step, Walk):
            return replace(step, things=tuple(map(other, step.things)), side=drawn(step.side, ("left", "right")))
        if isinstance(step, Face):
            return Face(other(step.thing))
        thing = other(step.thing) if step.thing is not None else None
        return replace(step, direction=drawn(step.direction, TURNS), thing=thing)

    if isinstance(meaning, Navigation):
        return Navigation(tuple(map(step_with, meaning.steps)), other(meaning.target))
    wheres = tuple(Where(each.relation, tuple(map(other, each.things)), each.exactly) for each in meaning.where)
    return Assembly(meaning.turns, other(meaning.thing), wheres)


def _splice(meaning: Navigation, second: Navigation, random: Random) -> Navigation:
    """Combine the first steps of one meaning with the last steps of another."""
    renamed = _with_new_identities(second)
    steps = (
        *meaning.steps[: random.randint(0, len(meaning.steps))],
        *renamed.steps[random.randint(0, len(renamed.steps)) :],
    )
    return Navigation(steps or meaning.steps, renamed.target)


def _with_new_identities(meaning: Navigation) -> Navigation:
    """Return a meaning with new identities of things, so that they differ from those of another meaning."""

    def renamed(thing: Thing) -> Thing:
        where = tuple(replace(each, things=tuple(map(renamed, each.things))) for each in thing.where)
        return replace(thing, identity=f"{thing.identity}'" if thing.identity else "", where=where)

    steps: list[Step] = []
    for step in meaning.steps:
        if isinstance(step, Walk):
            steps.append(replace(step, things=tuple(map(renamed, step.things))))
        elif isinstance(step, Face):
            steps.append(Face(renamed(step.thing)))
        else:
            steps.append(Rotate(step.direction, step.at, renamed(step.thing)) if step.thing is not None else step)
    return Navigation(tuple(steps), renamed(meaning.target))


def _other(thing: Thing, random: Random) -> tuple[str, str, str]:
    """Draw kind, colour and look of a thing that can replace another."""
    if thing.kind in COLLECTIBLES or not thing.kind:
        return random.choice(COLLECTIBLES), random.choice(COLLECTIBLE_COLOURS), random.choice(_LOOKS["pattern"])
    if thing.kind == "building":
        return "building", thing.colour, random.choice(_LOOKS["facade"])
    if thing.kind == "wall":
        return "wall", "", random.choice(_LOOKS["wall"])
    if thing.kind == "banner":
        return "banner", random.choice(BANNER_COLOURS), random.choice(_LOOKS["shape"])
    if thing.kind == "shop_sign":
        return "shop_sign", "", random.choice(_LOOKS["shop"])
    if thing.kind in FURNITURE:
        kind = random.choice(_like(thing))
        return kind, random.choice(COLOURS[kind]) if thing.colour else "", ""
    return thing.kind, thing.colour, thing.look


def _like(thing: Thing) -> Sequence[str]:
    """Return the kinds of furniture that can replace a thing: those with colours, if its colour is named, or all."""
    kinds: Mapping[str, tuple[str, ...]] = COLOURS
    plain = [kind for kind in FURNITURE if kind not in ("banner", "shop_sign")]
    return [kind for kind in kinds if kind in plain] if thing.colour else plain
