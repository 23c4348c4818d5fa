"""Data augmentation: variants of demonstrations with the names of things permuted, and mirrored left to right.

Visual features, instructions and actions change consistently, so that agents do not memorise the few training sections.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from random import Random

import numpy as np

import arramon_lang as lang
from arramon_agents.perception.eyes.grid import CHANNEL_NAMES
from arramon_agents.training.demonstrations import PhaseDemonstration
from arramon_agents.training.name_permutation import NamePermutation, read_meaning
from arramon_client.agent import Action
from arramon_client.world import NAVIGATION
from arramon_lang.meaning import OTHER_SIDE, Face, Meaning, Navigation, Rotate, Step, Thing, Walk, Where

MIRRORED_SHARE = 0.5
"""Share of navigation variants that are mirrored. Rooms are never mirrored, as each of their walls has a fixed side."""

_OTHER_ACTION = np.arange(len(Action), dtype=np.uint8)
_OTHER_ACTION[[Action.LEFT, Action.RIGHT]] = Action.RIGHT, Action.LEFT


@dataclass(frozen=True)
class _Change:
    """Changes of a variant: permutation of names (None for none), whether it is mirrored, and its texts."""

    permutation: NamePermutation | None
    mirrored: bool
    texts: dict[str, str]


class Variants:
    """Variants of demonstrations. Seed and number determine a variant; it is made when first drawn.

    Args:
        demonstrations: the original demonstrations.
        languages: languages of the variants' texts; none for a model that does not read.
        count: number of variants of each demonstration, besides the original.
        channel_names: names of the visual features. Names are permuted only if these are the features of the encoder
            "eyes", or if there are no features.
        seed: seed of all random choices.
    """

    def __init__(
        self,
        demonstrations: Sequence[PhaseDemonstration],
        languages: Sequence[str],
        count: int,
        channel_names: Sequence[str] | None,
        seed: int,
    ) -> None:
        self._demonstrations, self._languages, self._count = demonstrations, tuple(languages), count
        self._exchanges = channel_names is None or tuple(channel_names) == CHANNEL_NAMES
        self._seed = seed
        self._changes: dict[tuple[int, int], _Change] = {}
        self._meanings: dict[int, Meaning] = {}

    def draw(self, row: int, chance: Random) -> PhaseDemonstration:
        """Return the original or a variant of a demonstration, chosen uniformly."""
        number = chance.randrange(self._count + 1) if self._count else 0
        return self.variant(row, number)

    def variant(self, row: int, number: int) -> PhaseDemonstration:
        """Return a variant of a demonstration; number 0 is the original."""
        shown = self._demonstrations[row]
        if number == 0:
            return shown
        if (row, number) not in self._changes:
            self._changes[row, number] = self._change(row, number)
        change = self._changes[row, number]
        features, actions = shown.features, shown.actions
        if change.permutation is not None and features.shape[-1]:
            features = features[..., change.permutation.channels]
        if change.mirrored:
            features, actions = features[:, :, ::-1], _OTHER_ACTION[actions]
        return replace(shown, texts=change.texts or shown.texts, actions=actions, features=features)

    def _change(self, row: int, number: int) -> _Change:
        shown = self._demonstrations[row]
        random = Random(f"{self._seed}/{shown.phase}/{shown.episode_id}/{shown.turn}/{number}")  # noqa: S311
        permutation = NamePermutation.draw(random) if self._exchanges else None
        mirrors = shown.phase == NAVIGATION and random.random() < MIRRORED_SHARE
        if not self._languages:
            return _Change(permutation, mirrors, {})
        try:
            meaning = self._meaning(row) if permutation is None else permutation.permute_meaning(self._meaning(row))
            if mirrors:
                assert isinstance(meaning, Navigation)
                meaning = mirrored(meaning)
            texts = {each: _draft(lang.load(each), meaning, random) for each in self._languages if each in shown.texts}
        except ValueError:  # A person's text that the grammar can't parse or write is not augmented.
            return _Change(None, False, {})
        return _Change(permutation, mirrors, texts)

    def _meaning(self, row: int) -> Meaning:
        """Return the meaning of a demonstration's instruction."""
        if row not in self._meanings:
            shown = self._demonstrations[row]
            self._meanings[row] = read_meaning(shown.texts, shown.phase)
        return self._meanings[row]


def _draft(language: lang.Language, meaning: Meaning, random: Random) -> str:
    """Return a text by a random speaker; `write`, which prefers what people say, takes five times as long."""
    return language.draft(meaning, random, language.draw_voice(random))


def mirrored(meaning: Navigation) -> Navigation:
    """Return the meaning of an instruction in the mirrored world."""
    return Navigation(tuple(map(_mirrored_step, meaning.steps)), _mirrored_thing(meaning.target))


def _mirrored_step(step: Step) -> Step:
    if isinstance(step, Walk):
        return replace(step, things=tuple(map(_mirrored_thing, step.things)), side=_other(step.side))
    if isinstance(step, Face):
        return Face(_mirrored_thing(step.thing))
    assert isinstance(step, Rotate)
    thing = _mirrored_thing(step.thing) if step.thing is not None else None
    return replace(step, direction=_other(step.direction), thing=thing)


def _mirrored_thing(thing: Thing) -> Thing:
    return replace(thing, where=tuple(map(_mirrored_where, thing.where)))


def _mirrored_where(where: Where) -> Where:
    return replace(where, relation=_other(where.relation), things=tuple(map(_mirrored_thing, where.things)))


def _other(said: str) -> str:
    return OTHER_SIDE.get(said, said)
