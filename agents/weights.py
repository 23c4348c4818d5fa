"""Files of weights: safetensors with a JSON header, never pickle; reading with checks, writing, and finding them.

A header has the format's name and version, what is needed to build the network (sizes, vocabulary, names of tokenizer
and visual encoder), and metadata of the training ("about"). Each network reads and writes its own fields.
"""

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

import safetensors
import torch
from safetensors.torch import save_file
from torch import Tensor, nn

from arramon.strict_json import NotJsonError, read_json

SHIPPED = Path(__file__).parent
"""Folder of the agents; each agent's folder has its shipped weights and model card."""

WEIGHTS, CARD = "weights.safetensors", "card.md"
"""Names of the shipped files in an agent's folder."""

SUFFIX = ".safetensors"

HEADER = "arramon"
"""Metadata key of the header."""

LARGEST = 1 << 20
"""Maximum of a size in a file. The network is built before its tensors are checked, so sizes must be bounded."""

Content = TypeVar("Content")
Network = TypeVar("Network", bound=nn.Module)


class BadWeights(ValueError):
    """A file of weights cannot be read, or is incompatible with this version."""


@dataclass(frozen=True)
class WeightsFile:
    """Content of a file of weights.

    Attributes:
        path: path of the file.
        what: description of the content, for messages.
        tensors: tensors by name.
        header: header as JSON values.
    """

    path: Path
    what: str
    tensors: Mapping[str, Tensor]
    header: Mapping[str, Any]

    def wrong(self, problem: object) -> BadWeights:
        """Return the exception for a problem with the file."""
        return BadWeights(f"{self.path} does not hold the weights of {self.what}: {problem}")

    def value(self, name: str, kind: type[Content]) -> Content:
        """Return a field of the header.

        Raises:
            BadWeights: if it is missing or of another type.
        """
        value = self.header.get(name)
        if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
            raise self.wrong(f"its header has no {name!r} that is a {kind.__name__}")
        return value

    def sizes(self, name: str, kind: type[Content]) -> Content:
        """Return a field of the header as a dataclass with int, float (in [0, 1)), bool and str fields.

        Raises:
            BadWeights: if it has other fields, or values of a wrong type or range.
        """
        given, known = self.value(name, dict), {each.name: each for each in fields(kind)}  # type: ignore[arg-type]
        if not given.keys() <= known.keys():
            raise self.wrong(f"its header has {name!r} with {', '.join(given)}; expected {', '.join(known)}")
        for field, value in given.items():
            if problem := _problem(value, known[field].type):
                raise self.wrong(f"its header has the size {field} {value!r}, expected {problem}")
        try:
            return kind(**given)
        except TypeError as error:
            raise self.wrong(f"its header has {name!r} without a size: {error}") from error

    def build(self, make: Callable[[], Network]) -> Network:
        """Build a network with sizes from the header.

        Raises:
            BadWeights: if it cannot be built with these sizes.
        """
        try:
            return make()
        except (RuntimeError, AssertionError, MemoryError) as error:
            raise self.wrong(f"no network has the sizes in its header: {error}") from error

    def blob(self, name: str) -> bytes:
        """Return bytes that are stored as a tensor.

        Raises:
            BadWeights: if there is no such tensor.
        """
        if name not in self.tensors or self.tensors[name].dtype != torch.uint8:
            raise self.wrong(f"it has no {name}")
        return self.tensors[name].numpy().tobytes()

    def fill(self, network: nn.Module, prefix: str = "") -> None:
        """Load the tensors with a prefix into a network, in float32, and set evaluation mode.

        Raises:
            BadWeights: if a tensor is missing, has another shape, or does not belong to the network.
        """
        filled = {}
        for name, value in network.state_dict().items():
            found = self.tensors.get(prefix + name)
            if found is None:
                raise self.wrong(f"it has no tensor {prefix + name}")
            if found.shape != value.shape:
                expected = tuple(value.shape)
                raise self.wrong(f"its tensor {prefix + name} has the shape {tuple(found.shape)}, expected {expected}")
            filled[name] = found.to(value.dtype)
        for name, found in self.tensors.items():
            if name.startswith(prefix) and name.removeprefix(prefix) not in filled and found.dtype != torch.uint8:
                raise self.wrong(f"it has a tensor {name}, which the network does not have")
        network.load_state_dict(filled)
        network.eval()


def read_weights_file(path: Path, what: str, *formats: str | int | None) -> WeightsFile:
    """Return the content of a file of weights.

    Args:
        path: the file.
        what: description of the expected content, for messages.
        formats: accepted names of the format; None accepts a file without one, like the shipped reader and eyes.

    Raises:
        BadWeights: if there is no such file, or it cannot be read or has another format.
    """
    if not path.is_file():
        raise BadWeights(f"there are no weights of {what} at {path}")
    file = WeightsFile(path, what, *read_tensors(path))
    if file.header.get("format") not in formats:
        raise file.wrong(f"it has the format {file.header.get('format')!r}, expected {formats[0]!r}")
    return file


def write_weights_file(
    path: Path,
    networks: Mapping[str, nn.Module],
    header: Mapping[str, Any],
    blobs: Mapping[str, bytes] | None = None,
    dtype: torch.dtype = torch.float16,
) -> None:
    """Write networks to a file, atomically.

    Args:
        path: the file.
        networks: networks by the prefix of their tensors' names.
        header: JSON values, including "format".
        blobs: bytes to store as tensors, by name.
        dtype: type of floating-point tensors in the file.
    """
    tensors = {
        prefix + name: (value.detach().to("cpu", dtype) if value.is_floating_point() else value.cpu()).contiguous()
        for prefix, network in networks.items()
        for name, value in network.state_dict().items()
    }
    kept = {name: torch.frombuffer(bytearray(data), dtype=torch.uint8) for name, data in (blobs or {}).items()}
    write_tensors(path, tensors | kept, header)


def write_tensors(path: Path, tensors: Mapping[str, Tensor], header: Mapping[str, Any]) -> None:
    """Write tensors with a JSON header to a file, atomically."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}")
    save_file(dict(tensors), part, {HEADER: json.dumps(header, ensure_ascii=False)})
    part.chmod(0o644)  # safetensors makes files for the owner alone.
    part.replace(path)


def read_tensors(path: Path) -> tuple[dict[str, Tensor], dict[str, Any]]:
    """Return tensors and JSON header of a file; if it has no header, its metadata with values read as JSON.

    Raises:
        BadWeights: if it cannot be read.
    """
    header = read_header(path)
    try:
        with safetensors.safe_open(path, framework="pt") as file:
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - not a mapping
    except (OSError, safetensors.SafetensorError) as error:
        raise BadWeights(f"{path} is no file of weights: {error}") from error
    return tensors, header


def read_header(path: Path) -> dict[str, Any]:
    """Return the JSON header of a file, as `read_tensors` does, without reading its tensors.

    Raises:
        BadWeights: if it cannot be read.
    """
    try:
        with safetensors.safe_open(path, framework="pt") as file:
            metadata = file.metadata() or {}
        header = {name: read_json(text) for name, text in metadata.items()}
    except (OSError, safetensors.SafetensorError, NotJsonError) as error:
        raise BadWeights(f"{path} is no file of weights: {error}") from error
    found = header.get(HEADER, header)
    if not isinstance(found, dict):
        raise BadWeights(f"{path} is no file of weights: its header is no JSON object")
    return found


def find_weights(name: str) -> Path:
    """Return the path of an agent's shipped weights, or of a file.

    Raises:
        BadWeights: if neither exists.
    """
    shipped = SHIPPED / name / WEIGHTS
    for path in (shipped, Path(name)):
        if path.is_file():
            return path
    raise BadWeights(f"there are no weights {name!r}: neither a file {name} nor {shipped}")


def file_of(folder: Path, agent: str) -> Path:
    """Return the path of an agent's weights in the folder of all agents, or in an output folder of `arramon-train`."""
    shipped = folder / agent / WEIGHTS
    return shipped if shipped.is_file() else folder / f"{agent}{SUFFIX}"


def find_initial(init: str, agent: str) -> Path:
    """Return the path of weights to fine-tune, given a file, or a folder with a file named after the agent.

    Raises:
        BadWeights: if there is no such file.
    """
    given = Path(init)
    return find_weights(str(file_of(given, agent)) if given.is_dir() else init)


def _problem(value: object, kind: object) -> str:
    """Return the description of a valid size if this one is invalid, else empty."""
    if kind is int:
        is_right = isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= LARGEST
        return "" if is_right else f"a whole number from 0 to {LARGEST}"
    if kind is float:
        is_right = isinstance(value, int | float) and not isinstance(value, bool) and 0.0 <= value < 1.0
        return "" if is_right else "a number from 0 to 1"
    if kind is bool:
        return "" if isinstance(value, bool) else "true or false"
    return "" if isinstance(value, str) else "a name"
