"""Alignment loss: independent of padding, and not minimised by collapsed encodings."""

import random
from dataclasses import replace
from pathlib import Path

import torch

from arramon_agents.vl.alignment import alignment_loss, other_texts
from arramon_agents.vl.batches import tokenize_batch
from arramon_agents.vl.model import START_ACTION, EncodedText
from arramon_agents.vl.train import Imitation
from tests.agents.training_fixtures import demonstrations, place, recipe


def text(*rows: list[list[float]]) -> EncodedText:
    words = torch.nn.utils.rnn.pad_sequence([torch.tensor(row) for row in rows], batch_first=True, padding_value=9.0)
    lengths = torch.tensor([len(row) for row in rows])
    return EncodedText(words, torch.arange(words.shape[1]) >= lengths[:, None])


def test_the_loss_is_small_where_each_text_finds_its_own() -> None:
    one = text([[1.0, 0.0]], [[0.0, 1.0], [0.0, 3.0]])
    assert alignment_loss(one, text([[0.5, 0.0], [2.0, 0.0]], [[0.0, 0.1]])) < 0.001
    assert alignment_loss(one, text([[0.0, 1.0]], [[1.0, 0.0]])) > 5
    alike = text([[1.0, 1.0]], [[1.0, 1.0]])
    torch.testing.assert_close(alignment_loss(alike, alike), torch.tensor(2.0).log())
    assert alignment_loss(one.of([]), one.of([])) == 0


def test_the_second_text_is_in_another_language() -> None:
    first, second = demonstrations(count=2)[::2]
    del second.texts["hi"]
    chance = random.Random(1)
    given = [first.texts["en"], second.texts["en"]]
    assert other_texts([first, second], given, ("en", "hi"), chance) == ([0], [first.texts["hi"]])
    assert other_texts([first, second], [first.texts["hi"], given[1]], ("en", "hi"), chance) == ([0], [given[0]])


def test_training_pulls_languages_together(tmp_path: Path) -> None:
    """Hindi is learned by alignment alone, and then what Hindi asks for is done."""
    found = {}
    for align in (0.0, 1.0):
        chosen = replace(recipe(sees=False, passes=40), languages=("en",), align=align, tokenizer="sentencepiece")
        made = Imitation(chosen, place(tmp_path / str(align)), demonstrations())
        made.run()
        module = made.policy.model.eval().of("navigation")
        tokens = tokenize_batch(["बाएँ जाएँ", "दाएँ जाएँ"], made.policy.tokenizer)
        values, _ = module.act(module.read(tokens), torch.zeros(2, 1, 7, 7, 0), torch.full((2, 1), START_ACTION))
        found[align] = values[:, 0].argmax(-1).tolist()
    assert found[1.0] == [1, 2]
    assert found[0.0] != [1, 2]
