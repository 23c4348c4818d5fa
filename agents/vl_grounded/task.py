"""Training task of `vl_grounded`: imitate the expert's walks, and predict target cells of rooms."""

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
from arramon_agents.reading.tokenizers import TextTokenizer
from arramon_agents.training.batches import NO_ACTION, EpochBatches, padded
from arramon_agents.training.demonstrations import PhaseDemonstration
from arramon_agents.training.name_permutation import InstructionVersion
from arramon_agents.training.trainer import Loss
from arramon_agents.vl.model import START_ACTION, as_input
from arramon_agents.vl_grounded.attributes import KINDS, LOOKS
from arramon_agents.vl_grounded.look_around import attributes_in_rooms
from arramon_agents.vl_grounded.network import Grounded
from arramon_agents.vl_grounded.odometry import odometry
from arramon_agents.vl_grounded.room_views import RoomView
from arramon_client.world import COLLECTIBLE_COLOURS, COLLECTIBLES, COLUMNS, NAVIGATION
from arramon_lang.cell_grading import RoomObject

NAMING, PLACING = 0.3, 1.0
"""Loss weights: of the auxiliary loss (attributes of the target object) and of placement; navigation has weight 1."""

MIDDLE = slice(2, 5)
"""Columns of image cells straight ahead, which show the target object when it is picked up."""


class AttributeIndices(NamedTuple):
    """Attributes of a thing as indices in KINDS, COLOURS and LOOKS; -1 for unknown."""

    kind: int
    colour: int
    look: int


@dataclass(frozen=True, eq=False)
class DemonstratedWalk:
    """A navigation phase played by the expert.

    Attributes:
        demonstration: features and actions.
        odometry: odometry features before each action, (S, ODOMETRY_SIZE).
        versions: augmented versions of its instruction.
    """

    demonstration: PhaseDemonstration
    odometry: npt.NDArray[np.float32]
    versions: Sequence[InstructionVersion]

    @classmethod
    def of(cls, demonstration: PhaseDemonstration, versions: Sequence[InstructionVersion] = ()) -> "DemonstratedWalk":
        """Add odometry to a demonstration; without versions its instruction is used unchanged."""
        places = odometry(demonstration.actions.tolist()[:-1])
        return cls(demonstration, places, versions or (InstructionVersion(demonstration.texts),))

    def features(self, version: InstructionVersion) -> npt.NDArray[np.uint8]:
        """Return the visual features, with the names of a version of the instruction."""
        seen = self.demonstration.features
        return seen if version.permutation is None else seen[..., version.permutation.channels]


@dataclass(frozen=True, eq=False)
class DemonstratedPlacement:
    """An assembly room as seen, with augmented versions of its instruction."""

    view: RoomView
    versions: Sequence[InstructionVersion]

    def things(self, version: InstructionVersion) -> Sequence[RoomObject]:
        """Return the objects in the room, with the names of a version of the instruction."""
        return (
            self.view.things if version.permutation is None else version.permutation.permute_objects(self.view.things)
        )


class GroundedTask:
    """Training task: imitate the expert's actions, and predict the cell in which it places the object.

    Args:
        network: network to train.
        tokenizer: tokenizer of the instructions.
        languages: languages of the instructions.
        walks: walks of the expert.
        placings: rooms with target cells.
        batch: number of walks in a batch; it has twice as many rooms.
        inflection: loss weight of the steps at which the expert's action changes; the others have weight 1.
        seed: seed of order, languages and versions.
        device: device of the network.

    Attributes:
        epoch_steps: number of updates in an epoch of the walks.
    """

    def __init__(
        self,
        network: Grounded,
        tokenizer: TextTokenizer,
        languages: Sequence[str],
        walks: Sequence[DemonstratedWalk],
        placings: Sequence[DemonstratedPlacement],
        batch: int,
        inflection: float,
        seed: int,
        device: str = "cpu",
    ) -> None:
        self.network, self._device = network, device
        self._tokenizer, self._languages, self._inflection, self._seed = tokenizer, tuple(languages), inflection, seed
        self._walks, self._placings, self._batch = walks, placings, batch
        self._numbers: dict[str, list[int]] = {}
        self._epochs = EpochBatches([walk.demonstration for walk in walks], NAVIGATION, batch, seed)
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

    def _loss_of_walks(self, walks: Sequence[DemonstratedWalk], chance: random.Random) -> Tensor:
        network, steps = self.network, max(len(walk.demonstration.actions) for walk in walks)
        versions = [chance.choice(walk.versions) for walk in walks]
        tokens = self._draw_tokens(versions, chance)
        cells = np.zeros((len(walks), steps, *walks[0].demonstration.features.shape[1:]), np.uint8)
        previous_actions = np.full((len(walks), steps), START_ACTION, np.int64)
        actions = np.full((len(walks), steps), NO_ACTION, np.int64)
        places = np.zeros((len(walks), steps, walks[0].odometry.shape[1]), np.float32)
        named = []
        for row, (walk, version) in enumerate(zip(walks, versions, strict=True)):
            count, seen = len(walk.demonstration.actions), walk.features(version)
            cells[row, :count], places[row, :count] = seen, walk.odometry
            previous_actions[row, 1:count] = walk.demonstration.actions[:-1]
            actions[row, :count] = walk.demonstration.actions
            named.append(attributes_ahead(seen[-1]))
        words = network.reading(tokens)
        target = network.street.read_target(words, tokens)
        frames, previous, moved, targets = (
            each.to(self._device)
            for each in (as_input(cells), *map(torch.from_numpy, (previous_actions, places, actions)))
        )
        inputs = network.street.step_inputs(network.reading, target, frames, previous, moved)
        logits = network.street(network.reading, words, tokens, inputs)
        is_step = targets != NO_ACTION
        weights = torch.where(targets == previous, 1.0, self._inflection)[is_step]
        losses = functional.cross_entropy(logits[is_step], targets[is_step], reduction="none")
        naming = sum(
            (
                functional.cross_entropy(part, names, ignore_index=-1, reduction="sum")
                for part, names in zip(
                    network.reading.logits(target), torch.tensor(named, device=self._device).unbind(1), strict=True
                )
            ),
            start=torch.zeros((), device=self._device),
        )
        return (losses * weights).sum() / weights.sum() + NAMING * naming / len(walks)

    def _loss_of_rooms(self, placings: Sequence[DemonstratedPlacement], chance: random.Random) -> Tensor:
        network = self.network
        versions = [chance.choice(placing.versions) for placing in placings]
        tokens = self._draw_tokens(versions, chance)
        rooms = [placing.things(version) for placing, version in zip(placings, versions, strict=True)]
        things = attributes_in_rooms(rooms).to(self._device)
        logits = network.room(network.reading, network.reading(tokens), tokens, things)
        cells = [placing.view.target[1] * COLUMNS + placing.view.target[0] for placing in placings]
        targets = torch.tensor(cells, device=self._device)
        return functional.cross_entropy(logits, targets)

    def _draw_tokens(self, versions: Sequence[InstructionVersion], chance: random.Random) -> Tensor:
        """Return the token ids of each instruction in one of its languages, chosen uniformly, (B, T)."""
        there = [[language for language in self._languages if language in version.texts] for version in versions]
        return self._tokens([version.texts[chance.choice(each)] for version, each in zip(versions, there, strict=True)])

    def _tokens(self, texts: Sequence[str]) -> Tensor:
        for text in texts:
            if text not in self._numbers:
                self._numbers[text] = self._tokenizer.encode(text)
        return padded([self._numbers[text] for text in texts]).to(self._device)


_NEAR = CHANNEL_NAMES.index("nearness of collectible")
_KIND, _COLOUR, _LOOK = (
    [CHANNEL_NAMES.index(f"{group}:{name}") for name in names]
    for group, names in (
        ("kind", COLLECTIBLES), ("colour", COLLECTIBLE_COLOURS), ("pattern", LOOK_GROUPS[0].looks),
    )
)  # fmt: skip


def attributes_ahead(features: npt.NDArray[np.uint8]) -> AttributeIndices:
    """Return the attributes of the nearest collectible ahead in a frame, as the visual encoder sees them.

    Args:
        features: (7, 7, C).
    """
    ahead = features[:, MIDDLE]
    nearest = ahead[..., _NEAR].argmax()
    cell = ahead.reshape(GRID * ahead.shape[1], -1)[nearest]
    if not cell[_NEAR]:
        return AttributeIndices(-1, -1, -1)
    kind, colour, look = (int(cell[places].argmax()) for places in (_KIND, _COLOUR, _LOOK))
    return AttributeIndices(
        KINDS.index(COLLECTIBLES[kind]),
        COLOURS.index(COLLECTIBLE_COLOURS[colour]),
        LOOKS.index(("pattern", LOOK_GROUPS[0].looks[look])),
    )
