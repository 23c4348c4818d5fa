"""Sources of settings: a TOML file, the environment and flags; later sources override earlier ones.

pydantic-settings 2.16 does not fit: it ignores unknown variables with the prefix, rejects empty ones, names no file,
variable or flag in its errors, and does not report where a value came from. Each source would need its own class.
"""

import argparse
import difflib
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arramon_server.configuration.config import SETTINGS, Config, ContradictorySettings
from arramon_server.configuration.setting import Setting, as_text
from arramon_server.errors import BadFile, BadInput

CONFIG = "ARRAMON_CONFIG"
"""Environment variable that names the settings file."""

OTHER_VARIABLES = frozenset(
    (
        CONFIG,
        "ARRAMON_TOKEN",
        "ARRAMON_RELEASE",
        "ARRAMON_AGENT",
        "ARRAMON_LANG",
        "ARRAMON_LANGUAGES",
        "ARRAMON_COLLECT_TEXTS",
    )
)
"""Variables of the client, the languages, the tests and the Compose file, which are not settings of the server."""

COMMON_SETTINGS = ("data", "journal", "log", "log_format")
"""Settings that every command accepts as flags."""

_KUBERNETES_VARIABLE = re.compile(r"ARRAMON_(\w+_)?(SERVICE_HOST|SERVICE_PORT(_\w+)?|PORT(_\d+_\w+)?)")
"""Names of variables that Kubernetes sets in every pod of a namespace with a service setting arramon."""

PACKAGE_TABLES = frozenset(("collections",))
"""Tables of the settings file that commands of other packages read, such as `[collections.NAME]`."""

_PREFIX = "setting:"
"""Prefix of settings among parsed arguments, so that they never clash with a command's own arguments."""


@dataclass(frozen=True)
class ResolvedSettings:
    """The settings in force and their origins.

    Attributes:
        config: the settings.
        origins: source of each setting that was given, such as `--steps` or `steps in arramon.toml`.
    """

    config: Config
    origins: Mapping[str, str]


def add_common_flags(parser: argparse.ArgumentParser) -> None:
    """Add `--config` and the flags of the settings in `COMMON_SETTINGS`."""
    parser.add_argument("--config", metavar="FILE", help=f"TOML file with settings (default: ${CONFIG})")
    for name in COMMON_SETTINGS:
        _add_flag(parser, SETTINGS[name])


def add_flag(parser: argparse.ArgumentParser, name: str) -> None:
    """Add the flag of one setting."""
    _add_flag(parser, SETTINGS[name])


def add_serving_flags(parser: argparse.ArgumentParser) -> None:
    """Add the flags of all settings that are not in `COMMON_SETTINGS`."""
    for name in (name for name in SETTINGS if name not in COMMON_SETTINGS):
        _add_flag(parser, SETTINGS[name])


def _add_flag(parser: argparse.ArgumentParser, setting: Setting) -> None:
    meaning = setting.description.meaning.replace("%", "%%")
    default = setting.masked_text(setting.default)
    options: dict[str, Any] = {"metavar": (setting.description.unit or setting.name).upper().replace("_", "-")}
    if setting.is_switch:
        options = {"action": argparse.BooleanOptionalAction}
    elif setting.is_per_split:  # The flag may be repeated, for different splits.
        options["action"] = "append"
    parser.add_argument(
        setting.flag,
        dest=_PREFIX + setting.name,
        default=argparse.SUPPRESS,
        help=argparse.SUPPRESS
        if setting.description.internal
        else meaning + (f" (default: {default})" if default else ""),
        **options,
    )


def load_configuration(arguments: Mapping[str, Any], environ: Mapping[str, str]) -> ResolvedSettings:
    """Return the settings from all sources.

    Args:
        arguments: parsed by a parser with these flags.
        environ: the environment.

    Raises:
        BadInput: if a setting does not exist, is out of range, or contradicts another; the message names its source.
    """
    file = settings_file(arguments, environ)
    flags = list(_of_flags(arguments))
    is_embedded = any((name, text) == ("embedded", "true") for name, text, _ in flags)
    given: dict[str, tuple[str, str]] = {}
    for source in (_of_file(file) if file else (), _of_environment(environ)):
        given.update({name: (text, origin) for name, text, origin in source if not (is_embedded and _is_public(name))})
    given.update({name: (text, origin) for name, text, origin in flags})
    values = {name: SETTINGS[name].parse(text, origin) for name, (text, origin) in given.items()}
    origins = {name: origin for name, (_, origin) in given.items()}
    try:
        return ResolvedSettings(Config(**values), origins)
    except ContradictorySettings as error:
        where = [f"{name}: {origins[name]}" for name in error.names if name in origins]
        raise BadInput(f"{error} ({'; '.join(where)})") from error


def settings_file(arguments: Mapping[str, Any], environ: Mapping[str, str]) -> Path | None:
    """Return the path of the settings file; None if none is named."""
    file = arguments.get("config") or environ.get(CONFIG)
    return Path(file) if file else None


def wants_json(arguments: Mapping[str, Any], environ: Mapping[str, str]) -> bool:
    """Return whether the log is JSON, even if some setting is wrong: errors are written in the log's format.

    Args:
        arguments: parsed by a parser with these flags; with "settings" if they could be read.
        environ: the environment.
    """
    if isinstance(settings := arguments.get("settings"), Config):
        return settings.log_format == "json"
    given = arguments.get(f"{_PREFIX}log_format", environ.get(SETTINGS["log_format"].variable))
    if given is not None:
        return bool(given == "json")
    file = settings_file(arguments, environ)
    try:
        return any(name == "log_format" and text == "json" for name, text, _ in (_of_file(file) if file else ()))
    except BadInput:
        return False


def environment_of(config: Config) -> dict[str, str]:
    """Return environment variables that give another process the same settings, including passwords."""
    texts = {
        setting.variable: setting.text(getattr(config, setting.name))
        for setting in SETTINGS.values()
        if not setting.description.internal
    }
    return {variable: text for variable, text in texts.items() if text}


def without_settings(environ: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without the variables of the server's settings."""
    ours = {setting.variable for setting in SETTINGS.values()} | {CONFIG}
    return {variable: text for variable, text in environ.items() if variable not in ours}


def _of_file(path: Path) -> Iterator[tuple[str, str, str]]:
    try:
        content = tomllib.loads(path.read_text("utf-8"))
    except OSError as error:
        raise BadFile(path, f"cannot be read: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise BadFile(path, f"is not TOML: {error}") from error
    for name, value in content.items():
        if name in PACKAGE_TABLES and isinstance(value, Mapping):
            continue
        if name not in SETTINGS or SETTINGS[name].description.internal:
            raise BadFile(path, f"there is no setting {name!r}{_suggestion(name)}")
        yield name, as_text(value), f"{name} in {path}"


def _of_environment(environ: Mapping[str, str]) -> Iterator[tuple[str, str, str]]:
    for variable, text in environ.items():
        # An empty variable counts as not set: Compose files and shells leave empty variables behind.
        if not (variable.startswith("ARRAMON_") and text) or variable in OTHER_VARIABLES:
            continue
        name = variable.removeprefix("ARRAMON_").lower()
        if name in SETTINGS and not SETTINGS[name].description.internal and variable.isupper():
            yield name, text, f"${variable}"
        elif not _KUBERNETES_VARIABLE.fullmatch(variable):
            meant = f"; did you mean ${SETTINGS[name].variable}?" if name in SETTINGS else _suggestion(name)
            raise BadInput(f"${variable}: there is no setting {name!r}{meant}")


def _is_public(name: str) -> bool:
    """Return whether a setting is that of a public server."""
    return SETTINGS[name].description.of_public_server


def _of_flags(arguments: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    for argument, value in arguments.items():
        if argument.startswith(_PREFIX):
            setting = SETTINGS[argument.removeprefix(_PREFIX)]
            no = setting.is_switch and not value
            yield setting.name, as_text(value), f"--no-{setting.flag[2:]}" if no else setting.flag


def _suggestion(name: str) -> str:
    close = difflib.get_close_matches(
        name, [each for each, setting in SETTINGS.items() if not setting.description.internal], 1
    )
    return f"; did you mean {close[0]!r}?" if close else "; `arramon-server config` lists them"
