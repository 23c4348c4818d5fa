"""Options of the environments: from the arguments of `gymnasium.make` to settings and an opened player."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from importlib.metadata import entry_points
from pathlib import Path
from typing import cast

from arramon_client.environments.backend import (
    ASSEMBLY,
    EXPERTS,
    NAVIGATION,
    PHASES,
    REWARDS,
    Backend,
    Player,
    Settings,
)
from arramon_client.environments.errors import BadArgument, NoBackend
from arramon_client.environments.tokens import ByteTokenizer, Tokenizer, WordTokenizer
from arramon_client.errors import ArramonClientError, UsageError
from arramon_client.local.embedded import default_data
from arramon_client.transport.access import Access

BACKENDS = "arramon.environments"
"""Entry-point group in which the server package registers its backend."""

SMALLEST, LARGEST, STRIDE = 8, 448, 8
"""Sizes of images in this process, in pixels: multiples of STRIDE, and SIZES."""

SIZES = (84,)
"""Further sizes, which learners commonly use."""

SENSORS = ("rgb", "depth", "segmentation", "pose")
"""Sensors of the environments, in the order of the observation."""


@dataclass(frozen=True)
class Options:
    """The arguments of an environment. `docs/environments.md` explains them.

    Attributes:
        lang: language of the instructions.
        split: name of the split.
        sensors: names of `SENSORS`, in any order.
        image_size: side length of images, in pixels.
        server: address of a host, HOST:PORT or unix:/PATH; None to play in this process.
        data: the data folder in this process; None for $ARRAMON_DATA or ./arramon-data.
        reward: one of `REWARDS`; None for "sparse" where there can be rewards.
        tokenizer: "bytes", "words", which takes the words of the split (in this process), or a `Tokenizer`.
        expert: one of `EXPERTS`, for `info["expert_action"]`.
        phases: that the agent plays.
        turn, start: where the agent begins.
        steps_per_phase: the step limit of a phase; None for the benchmark's, or the host's.
        access: token and encryption, on a host.
    """

    lang: str = "en"
    split: str = "val_seen"
    sensors: tuple[str, ...] = ("rgb", "depth")
    image_size: int = 224
    server: str | None = None
    data: Path | None = None
    reward: str | None = None
    tokenizer: str | Tokenizer = "bytes"
    expert: str | None = None
    phases: tuple[str, ...] = PHASES
    turn: int = 1
    start: str = NAVIGATION
    steps_per_phase: int | None = None
    access: Access = field(default_factory=Access)


def make_options(**given: object) -> Options:
    """Return checked options from the arguments of `gymnasium.make`.

    Raises:
        BadArgument: if one is unknown or wrong in itself.
    """
    known = Options.__dataclass_fields__
    for name in given:
        if name not in known:
            raise BadArgument(f"there is no argument {name!r}; there are {_listed(known)}")
    for name in ("sensors", "phases", "access"):
        if given.get(name, ...) is None:
            del given[name]
    for name, example in (("sensors", '("rgb",)'), ("phases", '("assembly",)')):
        value = given.get(name, ())
        if isinstance(value, str) or not isinstance(value, Sequence):
            raise BadArgument(f"{name} is {value!r}, expected a tuple of names, e.g. {example}")
        if name in given:
            given[name] = tuple(value)
    if given.get("data") is not None:
        given["data"] = Path(str(given["data"]))
    options = Options(**given)  # type: ignore[arg-type]  # checked one by one
    _check(options)
    return options


def _check(options: Options) -> None:
    for sensor in options.sensors:
        if sensor not in SENSORS:
            raise BadArgument(f"there is no sensor {sensor!r}; there are {_listed(SENSORS)}")
    _among("reward", options.reward, (*REWARDS, None))
    _among("expert", options.expert, (*EXPERTS, None))
    _among("start", options.start, PHASES)
    _among("turn", options.turn, (1, 2))
    if not options.phases:
        raise BadArgument(f"phases is empty, expected some of {_listed(PHASES)}")
    for phase in options.phases:
        _among("phases", phase, PHASES)
    if (options.turn, options.start) == (2, ASSEMBLY) and ASSEMBLY not in options.phases:
        raise BadArgument(
            f"phases is {options.phases}, expected {ASSEMBLY!r} among them, as the episode begins with its last one"
        )
    _check_objects(options)
    _check_size(options)
    steps = options.steps_per_phase
    if steps is not None and (not isinstance(steps, int) or isinstance(steps, bool) or steps < 1):
        raise BadArgument(f"steps_per_phase is {steps!r}, expected a number from 1")
    if options.server is not None:
        local = {name: getattr(options, name) for name in ("expert", "data")} | {
            "reward": None if options.reward == "none" else options.reward,
            "phases": None if set(options.phases) == set(PHASES) else options.phases,
            "turn": None if options.turn == 1 else options.turn,
            "start": None if options.start == NAVIGATION else options.start,
        }
        for name, value in local.items():
            if value is not None:
                raise BadArgument(
                    f"{name} is {value!r}, but on a host there is none: play in this process (server=None)"
                )


def _check_objects(options: Options) -> None:
    tokenizer = options.tokenizer
    if isinstance(tokenizer, str):
        _among("tokenizer", tokenizer, ("bytes", "words"))
    elif not all(hasattr(tokenizer, name) for name in ("name", "size", "length", "encode")):
        expected = "'bytes', 'words', or an object with name, size, length, encode"
        raise BadArgument(f"tokenizer is {tokenizer!r}, expected {expected}")
    if not isinstance(options.access, Access):
        raise BadArgument(f"access is {options.access!r}, expected an Access, e.g. Access(token=...)")


def _check_size(options: Options) -> None:
    size = options.image_size
    if not isinstance(size, int) or isinstance(size, bool):
        raise BadArgument(f"image_size is {size!r}, expected a number of pixels")
    if options.server is None and size not in SIZES and (size % STRIDE or not SMALLEST <= size <= LARGEST):
        raise BadArgument(
            f"image_size is {size}, expected a multiple of {STRIDE} from {SMALLEST} to {LARGEST}, or {_listed(SIZES)}"
        )


def _among(name: str, value: object, allowed: Sequence[object]) -> None:
    if value not in allowed or isinstance(value, bool):
        raise BadArgument(f"{name} is {value!r}, expected {_listed(repr(each) for each in allowed)}")


@dataclass(frozen=True)
class Opened:
    """What an environment plays with.

    Attributes:
        player: plays the episodes.
        settings: as the player has them.
        tokenizer: of the instructions.
        options: as they were given.
    """

    player: Player
    settings: Settings
    tokenizer: Tokenizer
    options: Options


def open_player(options: Options) -> Opened:
    """Open a player for an environment.

    Raises:
        NoBackend: if there is no host, and the server package is not installed.
        BadArgument: if the split does not have what the options name.
        ArramonClientError: if the host does not answer, or refuses.
    """
    backend = open_backend(options)
    settings = Settings(
        language=options.lang,
        split=options.split,
        sensors=tuple(name for name in SENSORS if name in options.sensors),
        image_size=options.image_size,
        reward=options.reward or "none",
        expert=options.expert,
        phases=options.phases,
        turn=options.turn,
        start=options.start,
        steps_per_phase=options.steps_per_phase,
    )
    try:
        player = backend.player(settings)
        split = player.split
        for sensor in settings.sensors:
            if sensor not in split.sensors:
                raise BadArgument(
                    f"the split {split.name!r} does not offer the sensor {sensor!r}; it offers {_listed(split.sensors)}"
                )
        if split.hidden and options.reward not in (None, "none"):
            raise BadArgument(f"the split {split.name!r} is hidden: it has no rewards; use reward='none'")
        if split.hidden and options.expert is not None:
            raise BadArgument(f"the split {split.name!r} is hidden: it has no expert; use expert=None")
        if options.reward is None and not split.hidden and options.server is None:
            settings = replace(settings, reward="sparse")
            player = backend.player(settings)
        tokenizer = _tokenizer(options, backend, player)
    except UsageError as error:
        raise BadArgument(str(error)) from error
    return Opened(player, settings, tokenizer, options)


def open_backend(options: Options) -> Backend:
    """Return the backend of a host, or the server package's own.

    Raises:
        NoBackend: if there is no host, and the server package is not installed.
        ArramonClientError: if the host does not answer.
    """
    if options.server is not None:
        from arramon_client.environments.remote import RemoteBackend

        return RemoteBackend(options.server, options.access)
    registered = next(iter(entry_points(group=BACKENDS)), None)
    if registered is None:
        raise NoBackend(
            "without server=... an environment plays in this process, but arramon-server is not installed: install it, "
            "or name a host with server='HOST:PORT'"
        )
    try:
        backend = cast(Backend, registered.load()(options.data or default_data()))
    except ArramonClientError as error:
        raise BadArgument(str(error)) from error
    return backend


def _tokenizer(options: Options, backend: Backend, player: Player) -> Tokenizer:
    if not isinstance(options.tokenizer, str):
        return options.tokenizer
    if options.tokenizer == "words":
        return WordTokenizer.of(backend.instructions(options.split, options.lang))
    return ByteTokenizer(player.split.texts[options.lang].longest_utf8)


def _listed(names: object) -> str:
    return ", ".join(str(name) for name in names)  # type: ignore[attr-defined]
