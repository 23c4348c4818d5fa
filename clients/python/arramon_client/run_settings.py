"""Choice of a run's settings from the participant's options and the server's offers."""

from collections.abc import Iterable, Sequence

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client.agent import Agent
from arramon_client.errors import UsageError
from arramon_client.transport.access import is_local
from arramon_client.world import DEFAULT_SENSORS

DEFAULT_PARALLEL = 8

ENCODINGS = {
    "shared": types_pb2.ENCODING_SHARED,
    "raw": types_pb2.ENCODING_RAW,
    "zstd": types_pb2.ENCODING_ZSTD,
    "jpeg": types_pb2.ENCODING_JPEG,
}


def choose_split(
    info: evaluation_pb2.ServerInfo, language: str, split: str | None, languages: Sequence[str] | None = None
) -> evaluation_pb2.Split:
    """Return the split to play.

    Args:
        info: the server's information.
        language: requested language.
        split: requested split; None for the only one that has the language.
        languages: all requested languages, all of which a split chosen by default must have; None for only `language`.

    Raises:
        UsageError: if there is no such language or split, or if `split` is None and several have the language.
    """
    if not info.splits:
        raise UsageError("the server has no episodes: import or generate some first (arramon-server --help)")
    known = {name for each in info.splits for name in each.episodes}
    for code in (language, *(languages or ())):
        if code not in known:
            raise UsageError(f"the server has no language {code!r}; it has {_listed(known)}")
    if split is None:
        requested = languages or (language,)
        fitting = [each for each in info.splits if all(code in each.episodes for code in requested)]
        listed = (
            f"the language {language!r}" if len(requested) == 1 else f"the languages {', '.join(map(repr, requested))}"
        )
        if not fitting:
            raise UsageError(f"no split of the server has {listed}")
        if len(fitting) > 1:
            names = _listed(each.name for each in fitting)
            raise UsageError(f"several splits have {listed}; select one with --split: {names}")
        return fitting[0]
    for each in info.splits:
        if each.name == split:
            if language not in each.episodes:
                raise UsageError(f"the split {split!r} has no language {language!r}; it has {_listed(each.episodes)}")
            return each
    raise UsageError(f"the server has no split {split!r}; it has {_listed(each.name for each in info.splits)}")


def choose_sensors(agent: Agent, requested: Sequence[str] | None, split: evaluation_pb2.Split) -> tuple[str, ...]:
    """Return the sensors to play with: those requested, or else the agent's.

    Raises:
        UsageError: if the split does not offer one of them, or the agent's `sensors` is not a sequence of names.
    """
    return check_sensors(requested if requested is not None else _own_sensors(agent), split)


def check_sensors(requested: Sequence[str], split: evaluation_pb2.Split) -> tuple[str, ...]:
    """Return the requested sensors after checking that the split offers them.

    Raises:
        UsageError: if it does not, or if they are one text instead of a sequence of names.
    """
    if isinstance(requested, str):
        raise UsageError(f'sensors is {requested!r}, expected a sequence of names, e.g. ("rgb",), or () for none')
    sensors = tuple(requested)
    missing = [name for name in sensors if name not in split.sensors]
    if missing:
        raise UsageError(
            f"the split {split.name!r} does not offer the sensor {_listed(missing)}; it offers {_listed(split.sensors)}"
        )
    return sensors


def _own_sensors(agent: Agent) -> tuple[str, ...]:
    own: object = getattr(agent, "sensors", DEFAULT_SENSORS)
    # A string must be rejected: it is a sequence of one-letter strings.
    if isinstance(own, list | tuple | set | frozenset) and all(isinstance(name, str) for name in own):
        return tuple(own)
    raise UsageError(
        f'the agent\'s attribute sensors is {own!r}, expected a tuple of names, e.g. ("rgb",), or () for none'
    )


def choose_encoding(
    info: evaluation_pb2.ServerInfo, requested: str | None, address: str
) -> types_pb2.Encoding.ValueType:
    """Return the encoding of images: the one requested, else shared memory or raw if local, else Zstandard or raw.

    Raises:
        UsageError: if the server does not offer the requested encoding, or no lossless one.
    """
    if requested is not None:
        if ENCODINGS[requested] not in info.encodings:
            offered = _listed(name for name, encoding in ENCODINGS.items() if encoding in info.encodings)
            raise UsageError(f"the server does not offer the encoding {requested!r}; it offers {offered}")
        return ENCODINGS[requested]
    # JPEG only on request: an agent's score must not depend on its network connection.
    for name in ("shared", "raw", "zstd") if is_local(address) else ("zstd", "raw"):
        if ENCODINGS[name] in info.encodings:
            return ENCODINGS[name]
    raise UsageError("the server offers no lossless encoding that this client knows; choose another with --encoding")


def choose_jpeg_quality(encoding: types_pb2.Encoding.ValueType, requested: int | None) -> int:
    """Return the quality of JPEG images, 1 to 100; 0 for the server's default.

    Raises:
        UsageError: if a quality was requested, but the encoding is not JPEG.
    """
    if requested is not None and encoding != types_pb2.ENCODING_JPEG:
        raise UsageError("--quality requires --encoding jpeg: the other encodings are lossless")
    return requested or 0


def choose_image_size(info: evaluation_pb2.ServerInfo, requested: int | None) -> int:
    """Return the side length of images in pixels; 0 for the server's default.

    Raises:
        UsageError: if the server does not offer the requested size.
    """
    if requested is not None and requested not in info.image_sizes:
        raise UsageError(
            f"the server does not offer images of {requested} pixels; it offers {_listed(info.image_sizes)}"
        )
    return requested or 0


def choose_parallel(info: evaluation_pb2.ServerInfo, requested: int | None, copies: int = 1) -> int:
    """Return the number of episodes to play in parallel, by all copies of the agent together.

    Raises:
        UsageError: if the requested number exceeds the server's limit.
    """
    default = DEFAULT_PARALLEL * copies
    limit = info.max_episodes_per_stream or (requested or default)
    if requested is not None and requested > limit:
        raise UsageError(f"--parallel is {requested}, but the server allows at most {limit} parallel episodes")
    return requested or min(default, limit)


def _listed(names: Iterable[object]) -> str:
    return ", ".join(sorted(str(name) for name in names)) or "none"
