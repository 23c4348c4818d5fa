"""Where settings come from: a TOML file, then the environment, then flags; what comes later wins."""

import argparse
import difflib
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from server.config import SETTINGS, Config, Contradiction
from server.errors import BadFile, BadInput
from server.setting import Named, as_text

CONFIG = "ARRAMON_CONFIG"
"""The variable that names the file."""

OTHERS = frozenset((CONFIG, "ARRAMON_TOKEN", "ARRAMON_RELEASE", "ARRAMON_AGENT", "ARRAMON_LANG"))
"""Variables of the client, of the tests and of the Compose file, which are no settings of the server."""

COMMON = ("data", "journal", "log", "log_format")
"""Settings that every command takes as flags."""

_OF_KUBERNETES = re.compile(r"ARRAMON_(\w+_)?(SERVICE_HOST|SERVICE_PORT(_\w+)?|PORT(_\d+_\w+)?)")
"""Variables that Kubernetes sets in every pod beside a service named arramon."""

_FLAG = "setting:"
"""Begins the names under which parsed arguments hold settings, so that they never meet a command's own."""


@dataclass(frozen=True)
class Configured:
    """The settings in force.

    Attributes:
        origins: where each is from that is not at its default, such as `--steps` or `steps in arramon.toml`.
    """

    config: Config
    origins: Mapping[str, str]


def add_common_flags(parser: argparse.ArgumentParser) -> None:
    """Adds `--config` and the flags of the settings in `COMMON`."""
    parser.add_argument("--config", metavar="FILE", help=f"TOML file with settings (default: ${CONFIG})")
    for name in COMMON:
        _add_flag(parser, SETTINGS[name])


def add_flag(parser: argparse.ArgumentParser, name: str) -> None:
    """Adds the flag of one setting."""
    _add_flag(parser, SETTINGS[name])


def add_serving_flags(parser: argparse.ArgumentParser) -> None:
    """Adds the flags of all other settings."""
    for name in (name for name in SETTINGS if name not in COMMON):
        _add_flag(parser, SETTINGS[name])


def _add_flag(parser: argparse.ArgumentParser, named: Named) -> None:
    meaning = named.setting.meaning.replace("%", "%%")
    default = named.shown(named.default)
    options: dict[str, Any] = {"metavar": (named.setting.unit or named.name).upper().replace("_", "-")}
    if named.is_switch:
        options = {"action": argparse.BooleanOptionalAction}
    parser.add_argument(
        named.flag,
        dest=_FLAG + named.name,
        default=argparse.SUPPRESS,
        help=argparse.SUPPRESS if named.setting.internal else meaning + (f" (default: {default})" if default else ""),
        **options,
    )


def configured(arguments: Mapping[str, Any], environ: Mapping[str, str]) -> Configured:
    """Puts the settings together.

    Args:
        arguments: as parsed by a parser with these flags.
        environ: the environment.

    Raises:
        BadInput: for a setting that there is not, or one that is out of range; it says where that stands.
    """
    file = arguments.get("config") or environ.get(CONFIG)
    given: dict[str, tuple[str, str]] = {}
    for source in (_of_file(Path(file)) if file else (), _of_environment(environ), _of_flags(arguments)):
        given.update({name: (text, origin) for name, text, origin in source})
    values = {name: SETTINGS[name].parse(text, origin) for name, (text, origin) in given.items()}
    origins = {name: origin for name, (_, origin) in given.items()}
    try:
        return Configured(Config(**values), origins)
    except Contradiction as error:
        where = [f"{name}: {origins[name]}" for name in error.names if name in origins]
        raise BadInput(f"{error} ({'; '.join(where)})") from error


def environment_of(config: Config) -> dict[str, str]:
    """The variables that give another process these very settings, passwords included."""
    texts = {
        named.variable: named.text(getattr(config, named.name))
        for named in SETTINGS.values()
        if not named.setting.internal
    }
    return {variable: text for variable, text in texts.items() if text}


def without_settings(environ: Mapping[str, str]) -> dict[str, str]:
    """An environment in which no setting of the server is given."""
    ours = {named.variable for named in SETTINGS.values()} | {CONFIG}
    return {variable: text for variable, text in environ.items() if variable not in ours}


def _of_file(path: Path) -> Iterator[tuple[str, str, str]]:
    try:
        content = tomllib.loads(path.read_text("utf-8"))
    except OSError as error:
        raise BadFile(path, f"cannot be read: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise BadFile(path, f"is not TOML: {error}") from error
    for name, value in content.items():
        if name not in SETTINGS or SETTINGS[name].setting.internal:
            raise BadFile(path, f"there is no setting {name!r}{_meant(name)}")
        yield name, as_text(value), f"{name} in {path}"


def _of_environment(environ: Mapping[str, str]) -> Iterator[tuple[str, str, str]]:
    for variable, text in environ.items():
        # An empty variable counts as none: compose files and shells leave such behind.
        if not (variable.startswith("ARRAMON_") and text) or variable in OTHERS:
            continue
        name = variable.removeprefix("ARRAMON_").lower()
        if name in SETTINGS and not SETTINGS[name].setting.internal and variable.isupper():
            yield name, text, f"${variable}"
        elif not _OF_KUBERNETES.fullmatch(variable):
            meant = f"; did you mean ${SETTINGS[name].variable}?" if name in SETTINGS else _meant(name)
            raise BadInput(f"${variable}: there is no setting {name!r}{meant}")


def _of_flags(arguments: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    for argument, value in arguments.items():
        if argument.startswith(_FLAG):
            named = SETTINGS[argument.removeprefix(_FLAG)]
            no = named.is_switch and not value
            yield named.name, as_text(value), f"--no-{named.flag[2:]}" if no else named.flag


def _meant(name: str) -> str:
    close = difflib.get_close_matches(name, [each for each, named in SETTINGS.items() if not named.setting.internal], 1)
    return f"; did you mean {close[0]!r}?" if close else "; `arramon-server config` lists them"
