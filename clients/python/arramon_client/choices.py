"""Turns what a participant asked for, and what the server offers, into the settings of a run."""

from collections.abc import Iterable, Sequence

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client.access import is_local
from arramon_client.agent import Agent
from arramon_client.errors import UsageError

DEFAULT_SENSORS = ("rgb", "depth")
DEFAULT_PARALLEL = 8

ENCODINGS = {
    "shared": types_pb2.ENCODING_SHARED,
    "raw": types_pb2.ENCODING_RAW,
    "zstd": types_pb2.ENCODING_ZSTD,
    "jpeg": types_pb2.ENCODING_JPEG,
}


def choose_split(info: evaluation_pb2.ServerInfo, language: str, split: str | None) -> evaluation_pb2.Split:
    """The split to play.

    Args:
        info: of the server.
        language: asked for.
        split: asked for; None for the only one that has the language.

    Raises:
        UsageError: if there is no such language or split, or more than one that could be meant.
    """
    if not info.splits:
        raise UsageError("the server serves no episodes: import or make some first (arramon-server --help)")
    languages = {name for each in info.splits for name in each.episodes}
    if language not in languages:
        raise UsageError(f"the server has no language {language!r}; it has {_listed(languages)}")
    if split is None:
        fitting = [each for each in info.splits if language in each.episodes]
        if len(fitting) > 1:
            names = _listed(each.name for each in fitting)
            raise UsageError(f"several splits have the language {language!r}; choose one with --split: {names}")
        return fitting[0]
    for each in info.splits:
        if each.name == split:
            if language not in each.episodes:
                raise UsageError(f"the split {split!r} has no language {language!r}; it has {_listed(each.episodes)}")
            return each
    raise UsageError(f"the server has no split {split!r}; it has {_listed(each.name for each in info.splits)}")


def choose_sensors(agent: Agent, asked: Sequence[str] | None, split: evaluation_pb2.Split) -> tuple[str, ...]:
    """The sensors to play with: those asked for, or the agent's own.

    Raises:
        UsageError: if the split does not offer one of them.
    """
    sensors = tuple(asked) if asked is not None else tuple(getattr(agent, "sensors", DEFAULT_SENSORS))
    missing = [name for name in sensors if name not in split.sensors]
    if missing:
        raise UsageError(
            f"the split {split.name!r} does not offer the sensor {_listed(missing)}; it offers {_listed(split.sensors)}"
        )
    return sensors


def choose_encoding(info: evaluation_pb2.ServerInfo, asked: str | None, address: str) -> types_pb2.Encoding.ValueType:
    """How images travel: as asked; otherwise as they are on this machine, best in shared memory, and else compressed.

    Raises:
        UsageError: if the server does not offer what was asked for.
    """
    if asked is not None:
        if ENCODINGS[asked] not in info.encodings:
            offered = _listed(name for name, encoding in ENCODINGS.items() if encoding in info.encodings)
            raise UsageError(f"the server does not offer the encoding {asked!r}; it offers {offered}")
        return ENCODINGS[asked]
    # Never JPEG unless it was asked for: what an agent scores must not depend on the link that it happened to have.
    for name in ("shared", "raw", "zstd") if is_local(address) else ("zstd", "raw"):
        if ENCODINGS[name] in info.encodings:
            return ENCODINGS[name]
    raise UsageError("the server offers no lossless encoding that this client knows; choose another with --encoding")


def choose_jpeg_quality(encoding: types_pb2.Encoding.ValueType, asked: int | None) -> int:
    """The quality of JPEG images, 1 to 100; 0 for the server's own choice.

    Raises:
        UsageError: if it was asked for, but images do not travel as JPEG.
    """
    if asked is not None and encoding != types_pb2.ENCODING_JPEG:
        raise UsageError("--quality is for --encoding jpeg: raw and zstd images lose nothing")
    return asked or 0


def choose_image_size(info: evaluation_pb2.ServerInfo, asked: int | None) -> int:
    """Side length of the images in pixels; 0 for the server's own choice.

    Raises:
        UsageError: if the server does not offer what was asked for.
    """
    if asked is not None and asked not in info.image_sizes:
        raise UsageError(f"the server does not offer images of {asked} pixels; it offers {_listed(info.image_sizes)}")
    return asked or 0


def choose_parallel(info: evaluation_pb2.ServerInfo, asked: int | None) -> int:
    """Episodes to have open at once.

    Raises:
        UsageError: if it is more than the server allows.
    """
    limit = info.max_episodes_per_stream or (asked or DEFAULT_PARALLEL)
    if asked is not None and asked > limit:
        raise UsageError(f"the server allows at most {limit} episodes at once, --parallel asks for {asked}")
    return asked or min(DEFAULT_PARALLEL, limit)


def _listed(names: Iterable[object]) -> str:
    return ", ".join(sorted(str(name) for name in names)) or "none"
