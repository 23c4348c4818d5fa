"""Weight files of the reader: safetensors with sizes and vocabulary in the metadata."""

import json
from dataclasses import asdict
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file

from agents.learning.reader.network import ReaderNetwork, Sizes
from agents.learning.reader.words import Vocabulary


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
        raise FileNotFoundError(f"there is no reader at {path}; train it: python -m agents.learning.train_reader")
    try:
        with safe_open(path, "pt") as file:
            about = file.metadata() or {}
            if not {"sizes", "words"} <= about.keys():
                raise ValueError(f"{path} holds no reader: its metadata has no 'sizes' and 'words'")
            network = ReaderNetwork(Sizes(**json.loads(about["sizes"])))
            network.load_state_dict({name: file.get_tensor(name).float() for name in network.state_dict()})
    except (SafetensorError, RuntimeError) as error:
        raise ValueError(f"{path} holds no reader: {error}") from error
    network.requires_grad_(requires_grad=False)
    network.eval()
    return network, Vocabulary(json.loads(about["words"]))
