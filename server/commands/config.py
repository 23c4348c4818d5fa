"""The command `config`: prints the settings in force and where each comes from."""

import argparse
import json

from arramon_server.commands import Commands
from arramon_server.configuration.config import SETTINGS
from arramon_server.configuration.setting import Setting
from arramon_server.configuration.sources import ResolvedSettings, add_serving_flags
from arramon_server.per_split import PerSplit
from arramon_server.split_times import SplitTimes


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command."""
    config = commands.add_parser("config", parents=[common], help="print the settings in force, as a TOML file")
    config.add_argument("--table", action="store_true", help="print a Markdown table of all settings instead")
    add_serving_flags(config)
    config.set_defaults(command=_config)


def _config(arguments: argparse.Namespace) -> None:
    print(as_table() if arguments.table else as_toml(arguments.configuration))


def as_table() -> str:
    """Return a Markdown table of all settings."""
    rows = [
        f"| `{setting.name}` | {setting.expected} | {_default(setting)} | {setting.description.meaning} |"
        for setting in SETTINGS.values()
        if not setting.description.internal
    ]
    return "\n".join(["| setting | expected | default | meaning |", "| --- | --- | --- | --- |", *rows])


def as_toml(configuration: ResolvedSettings) -> str:
    """Return the settings in force as TOML, with the origin of each. Passwords are masked."""
    lines = []
    for setting in SETTINGS.values():
        if not setting.description.internal:
            value = getattr(configuration.config, setting.name)
            is_set = value is not None and value != PerSplit()
            given = f"{setting.name} = {_toml(setting, value)}" if is_set else f"# {setting.name}"
            lines.append(f"{given}  # {configuration.origins.get(setting.name, 'default')}")
    return "\n".join(lines)


def _default(setting: Setting) -> str:
    text = setting.masked_text(setting.default)
    return f"`{text}`" if text else "not set" if setting.default in (None, PerSplit()) else "empty"


def _toml(setting: Setting, value: object) -> str:
    if isinstance(value, PerSplit | SplitTimes):
        return value.as_toml()
    if isinstance(value, bool | int | float | tuple):
        return json.dumps(value)
    return json.dumps(setting.masked_text(value), ensure_ascii=False)
