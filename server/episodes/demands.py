"""File of instruction demands: what the instructions of generated episodes ask for, by their meaning.

`splits/NAME/demands.json` is made from `episodes.jsonl` by `arramon-server generate`, and is no part of the data's
hash: a serving process groups scores by it without knowing any language. It never leaves the server.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from arramon_server.episodes.split_files import read_bytes
from arramon_server.errors import BadFile

FILE = "demands.json"
"""Name of the file in a split's folder."""

FORMAT, VERSION = "arramon-demands", 1


@dataclass(frozen=True, slots=True)
class TurnDemands:
    """Demands of the two instructions of a turn, with the names of the languages' meanings.

    Attributes:
        steps: kinds of the navigation's steps in order: "turn", "turn_at", "turn_before", "turn_after", "face",
            "ahead", "to", "towards", "until", "beside", "past", "between" or "along".
        landmarks: sorts of the different things that the navigation names besides the target, in order: "building",
            "banner", "place" (such as a junction) or "object".
        relations: relations that the navigation states, such as "behind", in order.
        placements: relations that the assembly states, in order.
    """

    steps: tuple[str, ...]
    landmarks: tuple[str, ...]
    relations: tuple[str, ...]
    placements: tuple[str, ...]


Demands = Mapping[str, tuple[TurnDemands, TurnDemands]]
"""Episode id -> what both turns ask for."""


@dataclass(frozen=True, slots=True)
class _Content:
    format: str
    version: int
    data_hash: str
    episodes: dict[str, tuple[TurnDemands, TurnDemands]]


_CONTENT = TypeAdapter(_Content)


def write_demands(folder: Path, data_hash: str, demands: Demands) -> None:
    """Write the file of a split.

    Args:
        folder: folder of the split.
        data_hash: hash of the data from which the demands were made.
        demands: demands of every episode.

    Raises:
        OSError: if it cannot be written.
    """
    content = _Content(FORMAT, VERSION, data_hash, dict(demands))
    new = folder / f".{FILE}.new"
    new.write_bytes(_CONTENT.dump_json(content) + b"\n")
    new.replace(folder / FILE)


def read_demands(folder: Path, data_hash: str) -> Demands:
    """Read the file of a split; return nothing if it is missing, made from other data or by another version.

    Raises:
        BadFile: if its content is malformed.
    """
    path = folder / FILE
    if not path.exists():
        return {}
    try:
        content = _CONTENT.validate_json(read_bytes(path))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "the file"
        raise BadFile(path, f"{where}: {first['msg']}; delete it, or generate the split again") from error
    if (content.format, content.version, content.data_hash) != (FORMAT, VERSION, data_hash):
        return {}
    return content.episodes
