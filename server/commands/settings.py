"""`config`: the settings in force, and where each is from."""

import argparse
import json

from server.commands import Commands
from server.config import SETTINGS
from server.configuring import Configured, add_serving_flags
from server.setting import Named


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Adds it."""
    config = commands.add_parser("config", parents=[common], help="print the settings in force, as a TOML file")
    config.add_argument("--table", action="store_true", help="print in Markdown what can be set, instead")
    add_serving_flags(config)
    config.set_defaults(command=_config)


def _config(arguments: argparse.Namespace) -> None:
    print(as_table() if arguments.table else as_toml(arguments.configured))


def as_table() -> str:
    """All settings in Markdown."""
    rows = [
        f"| `{named.name}` | {named.expected} | {_default(named)} | {named.setting.meaning} |"
        for named in SETTINGS.values()
        if not named.setting.internal
    ]
    return "\n".join(["| setting | expected | default | meaning |", "| --- | --- | --- | --- |", *rows])


def as_toml(configured: Configured) -> str:
    """The settings in force, each with where it is from. Passwords are masked."""
    lines = []
    for named in SETTINGS.values():
        if not named.setting.internal:
            value = getattr(configured.config, named.name)
            given = "# " + named.name if value is None else f"{named.name} = {_toml(named, value)}"
            lines.append(f"{given}  # {configured.origins.get(named.name, 'default')}")
    return "\n".join(lines)


def _default(named: Named) -> str:
    text = named.shown(named.default)
    return f"`{text}`" if text else "not set" if named.default is None else "empty"


def _toml(named: Named, value: object) -> str:
    if isinstance(value, bool | int | float | tuple):
        return json.dumps(value)
    return json.dumps(named.shown(value), ensure_ascii=False)
