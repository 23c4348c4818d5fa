"""The reader's training task: texts as word ids, meanings as rows of slots, the loss, and scores."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import functional

from arramon_agents.reading.reader.network import ReaderNetwork
from arramon_agents.reading.reader.slots import EMPTY, SLOTS, Row
from arramon_agents.reading.reader.vocabulary import UNKNOWN
from arramon_agents.training.trainer import Loss

UNKNOWN_SHARE = 0.02
"""Probability of replacing a word by the unknown word in training."""

POOL = 50
"""Number of batches per pool: examples are sorted by length within a pool, to reduce padding."""

SCORE_BATCH = 256
"""Batch size of evaluation."""


@dataclass(frozen=True, eq=False)
class Examples:
    """Texts with their meanings.

    Attributes:
        texts: word ids, (n, most words) int64, padded with 0.
        rows: value ids, (n, most rows, slots) int64, with the end row.
        lengths: (n,) number of rows of each text, with the end row.
        languages: language of each text.
    """

    texts: Tensor
    rows: Tensor
    lengths: Tensor
    languages: tuple[str, ...]

    @classmethod
    def of(cls, texts: Sequence[list[int]], rows: Sequence[list[Row]], languages: Sequence[str]) -> "Examples":
        """Return examples from word ids, and rows without the end row."""
        most_words, most_rows = max(map(len, texts)), max(map(len, rows)) + 1
        padded = torch.tensor([text + [0] * (most_words - len(text)) for text in texts])
        filled = torch.tensor([[*one, *[EMPTY] * (most_rows - len(one))] for one in rows])
        return cls(padded, filled, torch.tensor([len(one) + 1 for one in rows]), tuple(languages))

    def digest(self) -> str:
        """Return the SHA-256 of texts and rows."""
        digest = hashlib.sha256()
        for part in (self.texts, self.rows):
            digest.update(f"{tuple(part.shape)}".encode() + part.numpy().tobytes())
        return digest.hexdigest()


class ReadingTask:
    """Training task: predict the rows of texts.

    Args:
        network: network to train.
        examples: training examples, reshuffled in each epoch.
        batch: number of examples in a batch.
        seed: seed of the order.
        device: device of the network.
    """

    def __init__(self, network: ReaderNetwork, examples: Examples, batch: int, seed: int, device: str = "cpu") -> None:
        self.network, self._examples, self._batch, self._seed = network, examples, batch, seed
        self._device = device
        self._epoch, self._places = 0, self._order(0)

    def loss(self, step: int) -> Loss:
        """Return the cross-entropy of a batch: the mean over rows, summed over slots."""
        chosen = self._chosen(step)
        texts, rows, lengths = (
            part[chosen] for part in (self._examples.texts, self._examples.rows, self._examples.lengths)
        )
        texts = texts[:, : int((texts != 0).sum(1).max())]
        rows = rows[:, : int(lengths.max())]
        hidden = (torch.rand(texts.shape) < UNKNOWN_SHARE) & (texts != 0)
        counted = (torch.arange(rows.shape[1]) < lengths[:, None]).to(self._device)
        rows = rows.to(self._device)
        logits = self.network(texts.masked_fill(hidden, UNKNOWN).to(self._device), rows)
        losses = [
            functional.cross_entropy(logits[name][counted], rows[:, :, number][counted])
            for number, name in enumerate(SLOTS)
        ]
        return Loss(torch.stack(losses).sum())

    def _chosen(self, step: int) -> Tensor:
        """Return the indices of the examples in a batch; a batch may span two epochs."""
        places = []
        for number in range(step * self._batch, (step + 1) * self._batch):
            epoch, place = divmod(number, len(self._examples.texts))
            if epoch != self._epoch:
                self._epoch, self._places = epoch, self._order(epoch)
            places.append(int(self._places[place]))
        return torch.tensor(places)

    def _order(self, epoch: int) -> npt.NDArray[np.int64]:
        """Return a random order of all examples in which examples of similar length are in the same batch."""
        random = np.random.default_rng((self._seed, epoch))
        places = random.permutation(len(self._examples.texts))
        words = (self._examples.texts != 0).sum(1).numpy()
        batches: list[npt.NDArray[np.int64]] = []
        for first in range(0, len(places), POOL * self._batch):
            pool = places[first : first + POOL * self._batch]
            pool = pool[np.argsort(words[pool], kind="stable")]
            batches += [pool[place : place + self._batch] for place in range(0, len(pool), self._batch)]
        return np.concatenate([batches[place] for place in random.permutation(len(batches))])


@dataclass(frozen=True, slots=True)
class ReadingScores:
    """Exact-match accuracies in [0, 1].

    Attributes:
        rows: accuracy of rows, without end rows.
        texts: accuracy of whole texts: all rows correct.
        count: number of texts.
    """

    rows: float
    texts: float
    count: int


def score(network: ReaderNetwork, examples: Examples) -> Mapping[str, ReadingScores]:
    """Return the scores of examples by language."""
    network.eval()
    device = next(network.parameters()).device
    right: dict[str, list[tuple[int, int, bool]]] = {}
    for first in range(0, len(examples.texts), SCORE_BATCH):
        some = slice(first, first + SCORE_BATCH)
        texts = examples.texts[some]
        found = network.read(texts.to(device)).cpu()
        for row, truth, length, language in zip(
            found, examples.rows[some], examples.lengths[some].tolist(), examples.languages[some], strict=True
        ):
            said = functional.pad(row, (0, 0, 0, max(0, length - len(row))), value=-1)[:length]
            same = (said == truth[:length]).all(1)
            # End rows, which have no other slots, count for the accuracy of whole texts only.
            has_ended = bool(said[length - 1, 0] == 0)
            rows = same[: length - 1]
            right.setdefault(language, []).append((int(rows.sum()), len(rows), bool(rows.all()) and has_ended))
    return {
        language: ReadingScores(
            sum(hits for hits, _, _ in each) / sum(rows for _, rows, _ in each),
            sum(whole for _, _, whole in each) / len(each),
            len(each),
        )
        for language, each in right.items()
    }
