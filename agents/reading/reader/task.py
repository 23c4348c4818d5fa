"""The reader's training task: texts as codes of words, meanings as rows of slots, the loss, and scores."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from random import Random

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import functional

from arramon_agents.reading.reader.network import ReaderNetwork
from arramon_agents.reading.reader.slots import EMPTY, SLOTS, Row
from arramon_agents.reading.reader.spelling import misspell
from arramon_agents.reading.reader.vocabulary import CODE_SIZE, UNKNOWN, Vocabulary
from arramon_agents.training.trainer import Loss

UNKNOWN_SHARE = 0.02
"""Probability of replacing a word by an unknown one without n-grams in training."""

SPELLED_SHARE = 0.12
"""Probability of leaving only its n-grams of a word in training, so that they alone tell the word."""

HASTY_SHARE, TYPING_ERRORS = 0.3, 0.15
"""Share of texts with typing errors in training, drawn anew in each epoch, and share of their words that have one."""

MISSPELLINGS = 6
"""Number of misspellings of a word."""

POOL = 50
"""Number of batches per pool: examples are sorted by length within a pool, to reduce padding."""

SCORE_BATCH = 256
"""Batch size of evaluation."""


@dataclass(frozen=True, eq=False)
class Examples:
    """Texts with their meanings.

    Attributes:
        texts: numbers of words, (n, most words) int64, padded with 0.
        codes: (words, CODE_SIZE) int64, code of each number; all 0 for number 0.
        misspellings: (words, MISSPELLINGS) int64, numbers of each word's misspellings.
        rows: value ids, (n, most rows, slots) int64, with the end row.
        lengths: (n,) number of rows of each text, with the end row.
        languages: language of each text.
    """

    texts: Tensor
    codes: Tensor
    misspellings: Tensor
    rows: Tensor
    lengths: Tensor
    languages: tuple[str, ...]

    @classmethod
    def of(
        cls,
        texts: Sequence[Sequence[str]],
        rows: Sequence[list[Row]],
        languages: Sequence[str],
        vocabulary: Vocabulary,
    ) -> "Examples":
        """Return examples from texts, split into words (at least one each), and rows without the end row."""
        numbers = {word: number for number, word in enumerate(dict.fromkeys(w for text in texts for w in text), 1)}
        misspellings = [[0] * MISSPELLINGS]
        letters = "".join(sorted({letter for word in numbers for letter in word}))
        for word in tuple(numbers):
            random = Random(word)  # noqa: S311 - nothing here is a secret
            wrong = [misspell(word, letters, random) for _ in range(MISSPELLINGS)]
            misspellings.append([numbers.setdefault(one, len(numbers) + 1) for one in wrong])
        codes = [(0,) * CODE_SIZE, *map(vocabulary.code, numbers)]
        most_words, most_rows = max(map(len, texts)), max(map(len, rows)) + 1
        padded = [[numbers[word] for word in text] + [0] * (most_words - len(text)) for text in texts]
        filled = [[*one, *[EMPTY] * (most_rows - len(one))] for one in rows]
        lengths = [len(one) + 1 for one in rows]
        texts_and_words = torch.tensor(padded), torch.tensor(codes), torch.tensor(misspellings)
        return cls(*texts_and_words, torch.tensor(filled), torch.tensor(lengths), tuple(languages))

    def digest(self) -> str:
        """Return the SHA-256 of texts and rows."""
        digest = hashlib.sha256()
        for part in (self.texts, self.codes, self.misspellings, self.rows):
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
        counted = (torch.arange(rows.shape[1]) < lengths[:, None]).to(self._device)
        rows = rows.to(self._device)
        logits = self.network(self._noisy(texts).to(self._device), rows)
        losses = [
            functional.cross_entropy(logits[name][counted], rows[:, :, number][counted])
            for number, name in enumerate(SLOTS)
        ]
        return Loss(torch.stack(losses).sum())

    def _noisy(self, texts: Tensor) -> Tensor:
        """Return the codes of texts, (B, words) to (B, words, CODE_SIZE), with typing errors and unknown words."""
        hasty = (torch.rand(len(texts), 1) < HASTY_SHARE) & (torch.rand(texts.shape) < TYPING_ERRORS)
        which = torch.randint(MISSPELLINGS, texts.shape)
        wrong = self._examples.misspellings[texts].gather(2, which[:, :, None])[:, :, 0]
        codes = self._examples.codes[torch.where(hasty, wrong, texts)]
        is_word, chance = texts != 0, torch.rand(texts.shape)
        codes[..., 0][(chance < UNKNOWN_SHARE + SPELLED_SHARE) & is_word] = UNKNOWN
        codes[..., 1:][(chance < UNKNOWN_SHARE) & is_word] = 0
        return codes

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
        texts = examples.codes[examples.texts[some]]
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
