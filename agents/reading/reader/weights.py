"""Weight files of the reader: safetensors with sizes and vocabulary in the metadata."""

import json
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file

from arramon.strict_json import NotJsonError, read_json
from arramon_agents.reading.reader.network import ReaderNetwork, Sizes
from arramon_agents.reading.reader.words import Vocabulary

LARGEST = 1 << 20
"""Maximum of a size in a file: a network of any size would be allocated before its tensors are found to be missing."""


def write_reader(path: Path, network: ReaderNetwork, vocabulary: Vocabulary) -> None:
    """Write a reader for use, its numbers in half precision."""
    tensors = {name: value.to(torch.float16).contiguous() for name, value in network.state_dict().items()}
    about = {"sizes": json.dumps(asdict(network.sizes)), "words": json.dumps(vocabulary.words, ensure_ascii=False)}
    save_file(tensors, path, about)


def read_reader(path: Path) -> tuple[ReaderNetwork, Vocabulary]:
    """Return a reader's network, ready for use, and its vocabulary.

    Raises:
        FileNotFoundError: if there is no such file.
        ValueError: if it holds no reader.
    """
    if not path.is_file():
        command = "python -m arramon_agents.learning.train_reader"
        raise FileNotFoundError(f"there is no reader at {path}; train it: {command}")
    try:
        with safe_open(path, "pt") as file:
            about = file.metadata() or {}
            if not {"sizes", "words"} <= about.keys():
                raise ValueError(f"{path} holds no reader: its metadata has no 'sizes' and 'words'")
            words = _words(read_json(about["words"]))
            network = ReaderNetwork(_sizes(read_json(about["sizes"])))
            network.load_state_dict({name: file.get_tensor(name).float() for name in network.state_dict()})
    except (SafetensorError, RuntimeError, NotJsonError) as error:
        raise ValueError(f"{path} holds no reader: {error}") from error
    except _WrongMetadataError as error:
        raise ValueError(f"{path} holds no reader: its metadata has {error}") from error
    network.requires_grad_(requires_grad=False)
    network.eval()
    return network, Vocabulary(words)


class _WrongMetadataError(Exception):
    """The metadata has a value of the wrong type or range; the message follows "its metadata has ..."."""


def _words(value: Any) -> list[str]:
    if not isinstance(value, list) or not all(isinstance(word, str) for word in value):
        raise _WrongMetadataError("'words' that are no list of texts")
    return value


def _sizes(value: Any) -> Sizes:
    names = {field.name: field for field in fields(Sizes)}
    if not isinstance(value, dict) or not {"words"} <= value.keys() <= names.keys():
        raise _WrongMetadataError(f"'sizes' that are no object with {', '.join(names)}")
    for name, size in value.items():
        is_share = name == "dropout"
        if isinstance(size, bool) or not isinstance(size, int | float if is_share else int):
            raise _WrongMetadataError(
                f"the size {name} {size!r}, expected a {'number' if is_share else 'whole number'}"
            )
        if not (0.0 <= size < 1.0 if is_share else 1 <= size <= LARGEST):
            raise _WrongMetadataError(
                f"the size {name} {size!r}, expected {'0 to 1' if is_share else f'1 to {LARGEST}'}"
            )
    return Sizes(**value)
