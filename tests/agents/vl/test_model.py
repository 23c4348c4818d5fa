"""The paper's models: parameter counts, and agreement with the paper's formulas."""

import pytest
import torch
from torch import Tensor

from arramon_agents.vl.config import ModelConfig
from arramon_agents.vl.model import START_ACTION, EncodedText, Model, PhaseModel

SMALL = ModelConfig(vocabulary=20, channels=6, positions=True, word_size=8, action_size=4, hidden=16)


@pytest.mark.parametrize(
    ("config", "millions"),
    [(ModelConfig(), 1.83), (ModelConfig(reads=False), 0.73), (ModelConfig(sees=False), 1.11)],
)
def test_sizes_are_the_papers(config: ModelConfig, millions: float) -> None:
    count = sum(parameter.numel() for parameter in Model(config).parameters())
    assert round(count / 1e6, 2) == millions


def inputs(steps: int = 5, tokens: int = 7) -> tuple[Tensor, Tensor, Tensor]:
    random = torch.Generator().manual_seed(3)
    words = torch.randint(1, 20, (2, tokens), generator=random)
    words[1, 4:] = 0
    cells = torch.rand(2, steps, 7, 7, 6, generator=random)
    before = torch.randint(0, 4, (2, steps), generator=random)
    before[:, 0] = START_ACTION
    return words, cells, before


def module(reader: str = "lstm", *, sees: bool = True, reads: bool = True) -> PhaseModel:
    torch.manual_seed(5)
    made = ModelConfig(**{**vars(SMALL), "reader": reader, "sees": sees, "reads": reads})
    return Model(made).of("navigation").eval()


@pytest.mark.parametrize(("sees", "reads"), [(True, True), (True, False), (False, True)])
def test_step_by_step_is_as_all_at_once(sees: bool, reads: bool) -> None:
    made = module(sees=sees, reads=reads)
    tokens, cells, before = inputs()
    text = made.read(tokens)
    together, _ = made.act(text, cells, before)
    state, alone = None, []
    for step in range(5):
        values, state = made.act(text, cells[:, step : step + 1], before[:, step : step + 1], state)
        alone.append(values)
    torch.testing.assert_close(torch.cat(alone, 1), together)


@pytest.mark.parametrize(("sees", "reads"), [(True, True), (True, False), (False, True)])
def test_values_at_some_steps_are_those_of_all(sees: bool, reads: bool) -> None:
    made = module(sees=sees, reads=reads)
    tokens, cells, before = inputs()
    text = made.read(tokens)
    at = torch.tensor([[0, 2, 4], [1, 3, 4]])
    rows = torch.arange(2)[:, None]
    some, _ = made.act(text, cells[rows, at], before, selected_steps=at)
    torch.testing.assert_close(some, made.act(text, cells, before)[0][rows, at])


def test_padding_changes_nothing() -> None:
    made = module()
    tokens, cells, before = inputs()
    both, _ = made.act(made.read(tokens), cells, before)
    short, _ = made.act(made.read(tokens[1:, :4]), cells[1:], before[1:])
    torch.testing.assert_close(short, both[1:])


def fused_first(made: PhaseModel, past: Tensor, seen: Tensor, text: EncodedText) -> list[Tensor]:
    """The paper's order: fuse every cell and every word, then attend. For one text without padding."""
    found = []
    for step in range(past.shape[1]):
        cells, words = seen[0, step], text.words[0]
        alike = torch.stack([torch.cat([made.similarity(cell * word) for word in words]) for cell in cells])
        by_cell, by_word = alike.softmax(1) @ words, alike.softmax(0).T @ cells
        fused = [
            made.fuse_cells(torch.cat([cells, by_cell, cells * by_cell], 1)),
            made.fuse_words(torch.cat([words, by_word, words * by_word], 1)),
        ]
        found.append([(each @ past[0, step]).softmax(0) @ each for each in fused])
    return [torch.stack([step[side] for step in found])[None] for side in (0, 1)]


def test_attention_is_as_if_everything_were_fused_first() -> None:
    made = module()
    tokens, _, _ = inputs()
    text = made.read(tokens[:1])
    random = torch.Generator().manual_seed(4)
    past, seen = torch.randn(1, 2, 16, generator=random), torch.randn(1, 2, 49, 16, generator=random)
    torch.testing.assert_close(made._attend_to_both(past, seen, text), fused_first(made, past, seen, text))


def test_places_of_cells_matter_only_with_positions() -> None:
    made = module()
    tokens, cells, before = inputs()
    text = made.read(tokens)
    mirrored = cells.flip(3)
    assert not torch.allclose(made.act(text, cells, before)[0], made.act(text, mirrored, before)[0])


def test_an_unknown_reader_is_named() -> None:
    with pytest.raises(ValueError, match="there is no reader 'gru'; there are lstm"):
        module("gru")
