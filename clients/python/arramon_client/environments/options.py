"""Options of the environments, parsed and checked from the arguments of `gymnasium.make`."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from arramon_client.environments.arguments import (
    check_choice,
    check_names,
    folder_path,
    listed,
    name_tuple,
    nonempty_text,
    whole_number,
)
from arramon_client.environments.backend import EXPERTS, REWARDS
from arramon_client.environments.errors import BadArgument
from arramon_client.environments.spaces import KEYS, OBSERVED_SENSORS
from arramon_client.environments.tokens import Tokenizer
from arramon_client.transport.access import Access
from arramon_client.world import ASSEMBLY, DEFAULT_SENSORS, NAVIGATION, PHASES

MIN_SIZE, MAX_SIZE, SIZE_STEP = 8, 448, 8
"""Image sizes available in this process, in pixels: the multiples of SIZE_STEP in this range, and SIZES."""

SIZES = (84,)
"""Further image sizes, common in reinforcement learning."""


@dataclass(frozen=True)
class Options:
    """The arguments of an environment. `docs/reference/environments.md` explains them.

    Attributes:
        lang: language of the instructions; or several, of which one is drawn for each episode.
        split: name of the split.
        sensors: some of `OBSERVED_SENSORS`, in any order.
        image_size: side length of images, in pixels.
        server: address of a host, HOST:PORT or unix:/PATH; None to play in this process.
        data: the data folder in this process; None for $ARRAMON_DATA or ./arramon-data.
        reward: one of `REWARDS`; None for "sparse" if rewards are available, otherwise "none".
        tokenizer: "bytes"; "words", with the vocabulary of the split (only in this process); or a `Tokenizer`.
        expert: one of `EXPERTS`, for `info["expert_action"]`; None for no expert.
        phases: phases that the agent plays.
        turn, start: turn and phase in which the agent begins.
        steps_per_phase: step limit of a phase; None for the default of the benchmark or the host.
        access: token and encryption, for a host.
        observe: keys of the observation, in any order; None for all. Sensors that are left out are not rendered.
    """

    lang: str | tuple[str, ...] = "en"
    split: str = "val_seen"
    sensors: tuple[str, ...] = DEFAULT_SENSORS
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
    observe: tuple[str, ...] | None = None

    @property
    def languages(self) -> tuple[str, ...]:
        """The languages, as a tuple even if there is only one."""
        return (self.lang,) if isinstance(self.lang, str) else self.lang


def make_options(own: Sequence[str] = (), keys: Sequence[str] = (), /, **given: object) -> Options:
    """Return checked options from the arguments of `gymnasium.make`.

    Args:
        own: names of further arguments that the caller handles itself, for error messages.
        keys: further keys of the caller's observations, which `observe` may name.
        given: the arguments, by name.

    Raises:
        UnknownArgument: if an argument is unknown.
        BadArgument: if an argument is invalid.
    """
    check_names(given, (*Options.__dataclass_fields__, *own))
    plain: dict[str, Any] = {}
    for name, value in given.items():
        if value is None and name in NONE_MEANS_DEFAULT:
            continue
        is_set = value is not None or name not in OPTIONAL
        plain[name] = CONVERTERS[name](value) if is_set and name in CONVERTERS else value
    if plain.get("observe") is not None:
        plain["observe"], plain["sensors"] = _observed(plain["observe"], plain.get("sensors"), keys)
    options = Options(**plain)
    _check(options)
    return options


def _languages(given: object) -> str | tuple[str, ...]:
    if isinstance(given, str) and given:
        return str(given)
    several = name_tuple("lang", given, '("en", "hi"), or one name')
    if not several or "" in several:
        raise BadArgument(f"lang is {given!r}, expected a language, or several")
    return several[0] if len(several) == 1 else several


CONVERTERS: Mapping[str, Callable[[object], object]] = {
    "lang": _languages,
    "split": lambda value: nonempty_text("split", value, "the name of a split"),
    "sensors": lambda value: name_tuple("sensors", value, '("rgb",)'),
    "image_size": lambda value: whole_number("image_size", value, "a number of pixels"),
    "server": lambda value: nonempty_text("server", value, "an address, HOST:PORT"),
    "data": lambda value: folder_path("data", value),
    "phases": lambda value: name_tuple("phases", value, '("assembly",)'),
    "turn": lambda value: whole_number("turn", value, "1, 2"),
    "steps_per_phase": lambda value: whole_number("steps_per_phase", value, "a number from 1", 1),
    "observe": lambda value: name_tuple("observe", value, '("rgb", "instruction_tokens")'),
}
"""Functions that convert an argument to its type in `Options`, or raise BadArgument."""

NONE_MEANS_DEFAULT = ("sensors", "phases", "access")
"""Arguments for which None selects the default."""

OPTIONAL = ("server", "data", "steps_per_phase", "observe")
"""Arguments that may be None."""


def _observed(
    chosen: tuple[str, ...], sensors: tuple[str, ...] | None, keys: Sequence[str]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the observed keys, and the sensors among them, after checking them."""
    known_keys = (*KEYS, *keys)
    for key in chosen:
        if key not in known_keys:
            raise BadArgument(f"there is no key {key!r} to observe; there are {listed(known_keys)}")
    if not set(chosen) & set(KEYS):
        raise BadArgument(f"observe is {chosen}, expected at least one of {listed(KEYS)}")
    wanted = tuple(key for key in chosen if key in OBSERVED_SENSORS)
    for key in wanted:
        if sensors is not None and key not in sensors:
            raise BadArgument(
                f"observe names {key!r}, but sensors is {sensors}: name it there too, or leave sensors out"
            )
    return chosen, wanted


def _check(options: Options) -> None:
    for sensor in options.sensors:
        if sensor not in OBSERVED_SENSORS:
            raise BadArgument(f"there is no sensor {sensor!r}; there are {listed(OBSERVED_SENSORS)}")
    check_choice("reward", options.reward, (*REWARDS, None))
    check_choice("expert", options.expert, (*EXPERTS, None))
    check_choice("start", options.start, PHASES)
    check_choice("turn", options.turn, (1, 2))
    if not options.phases:
        raise BadArgument(f"phases is empty, expected some of {listed(PHASES)}")
    for phase in options.phases:
        check_choice("phases", phase, PHASES)
    if (options.turn, options.start) == (2, ASSEMBLY) and ASSEMBLY not in options.phases:
        raise BadArgument(
            f"phases is {options.phases}, expected {ASSEMBLY!r} among them, as the episode begins with its last phase"
        )
    _check_objects(options)
    _check_size(options)
    if options.server is not None:
        if len(options.languages) > 1:
            raise BadArgument(f"lang is {options.lang}, but a run on a host has one language: name one")
        local = {name: getattr(options, name) for name in ("expert", "data")} | {
            "reward": None if options.reward == "none" else options.reward,
            "phases": None if set(options.phases) == set(PHASES) else options.phases,
            "turn": None if options.turn == 1 else options.turn,
            "start": None if options.start == NAVIGATION else options.start,
        }
        for name, value in local.items():
            if value is not None:
                raise BadArgument(
                    f"{name} is {value!r}, which a host does not support: play in this process (server=None)"
                )


def _check_objects(options: Options) -> None:
    tokenizer = options.tokenizer
    if isinstance(tokenizer, str):
        check_choice("tokenizer", tokenizer, ("bytes", "words"))
    elif not all(hasattr(tokenizer, name) for name in ("name", "size", "length", "encode")):
        expected = "'bytes', 'words', or an object with name, size, length, encode"
        raise BadArgument(f"tokenizer is {tokenizer!r}, expected {expected}")
    if not isinstance(options.access, Access):
        raise BadArgument(f"access is {options.access!r}, expected an Access, e.g. Access(token=...)")


def _check_size(options: Options) -> None:
    size = options.image_size
    if options.server is None and size not in SIZES and (size % SIZE_STEP or not MIN_SIZE <= size <= MAX_SIZE):
        raise BadArgument(
            f"image_size is {size}, expected a multiple of {SIZE_STEP} from {MIN_SIZE} to {MAX_SIZE}, "
            f"or {listed(SIZES)}"
        )
