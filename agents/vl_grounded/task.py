"""Training task of `vl_grounded`: the expert's walks as the visual encoder sees them, and rooms with the right cell."""

import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import functional

from arramon_agents.perception.encoder import GRID
from arramon_agents.perception.eyes.grid import CHANNEL_NAMES
from arramon_agents.perception.eyes.vocabulary import COLOURS, LOOK_GROUPS
from arramon_agents.reading.tokenizers import Tokenizer
from arramon_agents.training.batches import NO_ACTION, Epochs, padded
from arramon_agents.training.demonstrations import Demonstration
from arramon_agents.training.exchange import Version
from arramon_agents.training.trainer import Loss
from arramon_agents.vl.model import START, as_input
from arramon_agents.vl_grounded.look import as_named
from arramon_agents.vl_grounded.naming import KINDS, LOOKS
from arramon_agents.vl_grounded.network import Grounded
from arramon_agents.vl_grounded.odometry import odometry
from arramon_agents.vl_grounded.room_views import RoomView
from arramon_client.world import COLLECTIBLE_COLOURS, COLLECTIBLES, COLUMNS, NAVIGATION
from arramon_lang.room import RoomObject

NAMING, PLACING = 0.3, 1.0
"""Weights in the loss: of naming the object to pick up, and of the room; the walk has weight 1."""

MIDDLE = slice(2, 5)
"""Columns of cells straight ahead, which show the object when it is picked up."""


class Names(NamedTuple):
    """Indices in KINDS, COLOURS and LOOKS; -1 for unknown."""

    kind: int
    colour: int
    look: int


@dataclass(frozen=True, eq=False)
class Walk:
    """A navigation phase of the expert, with derived inputs.

    Attributes:
        demonstration: the phase.
        odometry: before each action, (S, NUMBERS).
        versions: of its instruction.
    """

    demonstration: Demonstration
    odometry: npt.NDArray[np.float32]
    versions: Sequence[Version]

    @classmethod
    def of(cls, demonstration: Demonstration, versions: Sequence[Version] = ()) -> "Walk":
        """Return a demonstration with its odometry; without versions its instruction is used unchanged."""
        places = odometry(demonstration.actions.tolist()[:-1])
        return cls(demonstration, places, versions or (Version(demonstration.texts),))

    def features(self, version: Version) -> npt.NDArray[np.uint8]:
        """Return the features, with things exchanged as in a version."""
        seen = self.demonstration.features
        return seen if version.exchange is None else seen[..., version.exchange.channels]


@dataclass(frozen=True, eq=False)
class Placing:
    """A room as seen, with the versions of its instruction."""

    view: RoomView
    versions: Sequence[Version]

    def things(self, version: Version) -> Sequence[RoomObject]:
        """Return the things in the room, exchanged as in a version."""
        return self.view.things if version.exchange is None else version.exchange.standing(self.view.things)


class GroundedTask:
    """Training task: choose the expert's actions, and find the cell in which it places the object.

    Args:
        network: to be trained.
        tokenizer: of the instructions.
        languages: of the instructions.
        walks: of the expert.
        placings: rooms.
        batch: number of walks in a step; twice as many rooms.
        inflection: weight of the steps at which the expert's action changes; the others have 1.
        seed: of order, languages and versions.

    Attributes:
        epoch_steps: number of steps of an epoch of the walks.
    """

    def __init__(
        self,
        network: Grounded,
        tokenizer: Tokenizer,
        languages: Sequence[str],
        walks: Sequence[Walk],
        placings: Sequence[Placing],
        batch: int,
        inflection: float,
        seed: int,
    ) -> None:
        self.network = network
        self._tokenizer, self._languages, self._inflection, self._seed = tokenizer, tuple(languages), inflection, seed
        self._walks, self._placings, self._batch = walks, placings, batch
        self._numbers: dict[str, list[int]] = {}
        self._epochs = Epochs([walk.demonstration for walk in walks], NAVIGATION, batch, seed)
        self.epoch_steps = self._epochs.count

    def loss(self, step: int) -> Loss:
        """Return the loss of a batch of walks and one of rooms."""
        chance = random.Random(f"{self._seed}/{step}")  # noqa: S311 - not for secrets
        walks = [self._walks[row] for row in self._epochs.batch(step)]
        total = self._loss_of_walks(walks, chance)
        if self._placings:
            placings = chance.choices(self._placings, k=2 * self._batch)
            total = total + PLACING * self._loss_of_rooms(placings, chance)
        return Loss(total)

    def _loss_of_walks(self, walks: Sequence[Walk], chance: random.Random) -> Tensor:
        network, steps = self.network, max(len(walk.demonstration.actions) for walk in walks)
        versions = [chance.choice(walk.versions) for walk in walks]
        tokens = self._read(versions, chance)
        cells = np.zeros((len(walks), steps, *walks[0].demonstration.features.shape[1:]), np.uint8)
        before = np.full((len(walks), steps), START, np.int64)
        actions = np.full((len(walks), steps), NO_ACTION, np.int64)
        places = np.zeros((len(walks), steps, walks[0].odometry.shape[1]), np.float32)
        named = []
        for row, (walk, version) in enumerate(zip(walks, versions, strict=True)):
            count, seen = len(walk.demonstration.actions), walk.features(version)
            cells[row, :count], places[row, :count] = seen, walk.odometry
            before[row, 1:count], actions[row, :count] = walk.demonstration.actions[:-1], walk.demonstration.actions
            named.append(names_ahead(seen[-1]))
        words = network.reading(tokens)
        target = network.street.read_target(words, tokens)
        given = network.street.see(
            network.reading, target, as_input(cells), torch.from_numpy(before), torch.from_numpy(places)
        )
        values = network.street(network.reading, words, tokens, given)
        right = torch.from_numpy(actions)
        is_step = right != NO_ACTION
        weights = torch.where(right == torch.from_numpy(before), 1.0, self._inflection)[is_step]
        losses = functional.cross_entropy(values[is_step], right[is_step], reduction="none")
        naming = sum(
            (
                functional.cross_entropy(logits, names, ignore_index=-1, reduction="sum")
                for logits, names in zip(network.reading.logits(target), torch.tensor(named).unbind(1), strict=True)
            ),
            start=torch.zeros(()),
        )
        return (losses * weights).sum() / weights.sum() + NAMING * naming / len(walks)

    def _loss_of_rooms(self, placings: Sequence[Placing], chance: random.Random) -> Tensor:
        network = self.network
        versions = [chance.choice(placing.versions) for placing in placings]
        tokens = self._read(versions, chance)
        there = as_named([placing.things(version) for placing, version in zip(placings, versions, strict=True)])
        values = network.room(network.reading, network.reading(tokens), tokens, there)
        right = torch.tensor([placing.view.target[1] * COLUMNS + placing.view.target[0] for placing in placings])
        return functional.cross_entropy(values, right)

    def _read(self, versions: Sequence[Version], chance: random.Random) -> Tensor:
        """Return the token ids of texts, each in one of its languages, chosen uniformly, (B, T)."""
        there = [[language for language in self._languages if language in version.texts] for version in versions]
        return self._tokens([version.texts[chance.choice(each)] for version, each in zip(versions, there, strict=True)])

    def _tokens(self, texts: Sequence[str]) -> Tensor:
        for text in texts:
            if text not in self._numbers:
                self._numbers[text] = self._tokenizer.encode(text)
        return padded([self._numbers[text] for text in texts])


_NEAR = CHANNEL_NAMES.index("nearness of collectible")
_KIND, _COLOUR, _LOOK = (
    [CHANNEL_NAMES.index(f"{group}:{name}") for name in names]
    for group, names in (
        ("kind", COLLECTIBLES), ("colour", COLLECTIBLE_COLOURS), ("pattern", LOOK_GROUPS[0].looks),
    )
)  # fmt: skip


def names_ahead(features: npt.NDArray[np.uint8]) -> Names:
    """Return the names of the nearest collectible ahead in a frame.

    Args:
        features: (7, 7, C).
    """
    ahead = features[:, MIDDLE]
    nearest = ahead[..., _NEAR].argmax()
    cell = ahead.reshape(GRID * ahead.shape[1], -1)[nearest]
    if not cell[_NEAR]:
        return Names(-1, -1, -1)
    kind, colour, look = (int(cell[places].argmax()) for places in (_KIND, _COLOUR, _LOOK))
    return Names(
        KINDS.index(COLLECTIBLES[kind]),
        COLOURS.index(COLLECTIBLE_COLOURS[colour]),
        LOOKS.index(("pattern", LOOK_GROUPS[0].looks[look])),
    )
