"""Cache of text states: computed once, stored on disk in training, evicted at play."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from arramon_agents.pretrained import hidden_state_cache
from arramon_agents.pretrained.hidden_state_cache import HiddenStateCache


class Counting:
    """An encoder that counts what it encodes: each piece's state is the piece, four times."""

    size, pieces, longest, fingerprint = 4, 100, 6, "counting"

    def __init__(self) -> None:
        self.encoded: list[list[int]] = []

    def tokenize(self, text: str) -> list[int]:
        return [ord(letter) for letter in text]

    def encode(self, texts: Sequence[Sequence[int]]) -> list[npt.NDArray[np.float32]]:
        self.encoded += [list(text) for text in texts]
        return [np.repeat(np.array(text, np.float32)[:, None], 4, 1) for text in texts]


def test_each_text_is_encoded_once() -> None:
    encoder = Counting()
    kept = HiddenStateCache(encoder)
    found = kept.hidden_states([[1, 2, 3], [7], [1, 2, 3]])
    assert found[:, :, 0].tolist() == [[1, 2, 3], [7, 0, 0], [1, 2, 3]]
    kept.hidden_states([[7], [1, 2, 3]])
    assert encoder.encoded == [[1, 2, 3], [7]]


def test_those_asked_for_longest_ago_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hidden_state_cache, "MAX_CACHED_TEXTS", 2)
    encoder = Counting()
    kept = HiddenStateCache(encoder)
    for text in ([1], [2], [1], [3], [1], [2]):
        kept.hidden_states([text])
    assert encoder.encoded == [[1], [2], [3], [2]]


def test_what_is_prepared_is_read_from_disk_the_second_time(tmp_path: Path) -> None:
    first, second = Counting(), Counting()
    texts, told = [[1, 2], [3], [1, 2]], list[str]()
    HiddenStateCache(first).prepare(texts, tmp_path, told.append)
    assert told == ["states of texts: 2 of 2"]
    again = HiddenStateCache(second)
    mean, deviation = again.prepare([*texts, [5]], tmp_path, told.append)
    assert mean.tolist() == [2.75] * 4  # Of 1, 2, 3 and 5.
    np.testing.assert_allclose(deviation, [np.std([1, 2, 3, 5])] * 4, rtol=1e-5)
    assert again.hidden_states([[3], [1, 2]])[:, :, 0].tolist() == [[3, 0], [1, 2]]
    assert first.encoded == [[1, 2], [3]]
    assert second.encoded == [[5]]


def test_a_text_that_is_too_long_is_named() -> None:
    with pytest.raises(ValueError, match="a text has 7 pieces, expected at most 6"):
        HiddenStateCache(Counting()).hidden_states([[1] * 7])
