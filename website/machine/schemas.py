"""JSON Schemas of the project's files: from the models that read them, where there are any, else written here."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from arramon_server.configuration.config import Config
from arramon_server.configuration.setting import Setting, settings_of
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.provenance import Provenance
from arramon_server.episodes.split_files import EpisodeFileHeader
from arramon_server.sim.section import Section

DIALECT = "https://json-schema.org/draft/2020-12/schema"

Schema = dict[str, Any]

HASH: Schema = {"type": "string", "pattern": "^[0-9a-f]{64}$"}
RUN_ID: Schema = {"type": "string", "pattern": "^[0-9a-f]{32}$"}
WORDS: Schema = {"type": "array", "items": {"type": "string"}}
COUNT: Schema = {"type": "integer", "minimum": 0}
SHARE: Schema = {"type": "number", "minimum": 0, "maximum": 1}
COUNTS: Schema = {"type": "object", "additionalProperties": COUNT}
LIMITS: Schema = {
    "type": "object",
    "required": ["steps_per_phase", "step_seconds", "bank_seconds"],
    "properties": {"steps_per_phase": COUNT, "step_seconds": {"type": "number"}, "bank_seconds": {"type": "number"}},
}
INTERVAL: Schema = {
    "type": "object",
    "required": ["mean", "low", "high"],
    "properties": {"mean": SHARE, "low": SHARE, "high": SHARE},
}
ROWS: Schema = {
    "type": "object",
    "required": ["turn 1", "turn 2", "total"],
    "additionalProperties": {"type": "object", "additionalProperties": INTERVAL},
}
TURNS: Schema = {"type": "object", "additionalProperties": {"type": "object", "additionalProperties": SHARE}}
ACTIONS: Schema = {"type": "object", "additionalProperties": {"type": "string", "pattern": "^[0-3]*$"}}


def schemas() -> Mapping[str, Schema]:
    """Return all schemas by the name of their file, without its ending."""
    models = {
        "episode-file-header": ("First line of an episode file", EpisodeFileHeader),
        "episode": ("Every further line of an episode file", Episode),
        "section": ("File of a section", Section),
        "provenance": ("File of the provenance of a section's furniture", Provenance),
    }
    found = {name: {**TypeAdapter(model).json_schema(), "title": title} for name, (title, model) in models.items()}
    found |= {"settings": settings(), "receipt-file": receipt_file(), "receipt": receipt(), "results": results()}
    return {name: {"$schema": DIALECT, **schema} for name, schema in found.items()}


def settings() -> Schema:
    """Return the schema of the server's settings, as in its TOML file."""
    shown = {name: each for name, each in settings_of(Config).items() if not each.description.internal}
    return {
        "title": "Settings of arramon-server",
        "type": "object",
        "additionalProperties": False,
        "properties": {name: _setting(each) for name, each in shown.items()},
    }


def _setting(each: Setting) -> Schema:
    about = each.description
    number: Schema = {"minimum": about.least} if about.least is not None else {}
    if about.most is not None:
        number["maximum"] = about.most
    if about.choices:
        kind: Schema = {"enum": list(about.choices)}
    elif each.is_switch:
        kind = {"type": "boolean"}
    elif each.is_per_split:
        # A number or a text for all splits, or a table with a value for each.
        kind = {"type": ["integer", "string", "object"], **number}
    elif each.type in (int, float):
        kind = {"type": "integer" if each.type is int else "number", **number}
    elif each.type == tuple[int, ...]:
        kind = {"type": "array", "minItems": 1, "items": {"type": "integer", **number}}
    else:
        kind = {"type": "string"}
    shown = [] if each.default is None or isinstance(each.default, Path) or each.is_per_split else [each.default]
    return {
        "description": f"{about.meaning}. Expected: {each.expected}",
        **kind,
        **({"default": shown[0]} if shown else {}),
    }


def receipt_file() -> Schema:
    """Return the schema of a receipt's file."""
    return {
        "title": "File of a receipt",
        "type": "object",
        "required": ["format", "version", "payload", "signature", "public_key"],
        "properties": {
            "format": {"const": "arramon-receipt-file"},
            "version": {"const": 1},
            "payload": {"type": "string", "contentMediaType": "application/json"},
            "signature": {"type": "string", "pattern": "^[0-9a-f]{128}$"},
            "public_key": HASH,
        },
    }


def receipt() -> Schema:
    """Return the schema of a receipt: the payload of its file, versions 1 and 2."""
    run: Schema = {
        "type": "object",
        "required": ["run_id", "participant", "agent", "split", "hidden", "language", "sensors", "images", "state"],
        "properties": {
            **{name: {"type": "string"} for name in ("participant", "agent", "split", "language")},
            "run_id": RUN_ID,
            "hidden": {"type": "boolean"},
            "sensors": WORDS,
            "images": WORDS,
            "state": {"enum": ["COMPLETE", "CANCELLED"]},
            "created_at": {"type": "string", "format": "date-time"},
            "ended_at": {"type": "string", "format": "date-time"},
            "agent_arguments": {"type": "object"},
            "code": {"type": "object"},
        },
    }
    episode: Schema = {
        "type": "object",
        "required": ["episode_id", "head"],
        "properties": {
            "episode_id": {"type": "string"},
            "head": HASH,
            "cause": {"type": "string"},
            "steps": COUNT,
            "scores": TURNS,
            "ending": HASH,
        },
    }
    needed = [
        "format",
        "version",
        "run",
        "limits",
        "data_hash",
        "score_signature",
        "causes",
        "scores",
        "episodes",
        "digest",
    ]
    return {
        "title": "Receipt: the payload that a host has signed",
        "type": "object",
        "required": needed,
        "properties": {
            "format": {"const": "arramon-receipt"},
            "version": {"enum": [1, 2]},
            "run": run,
            "limits": LIMITS,
            "server_version": {"type": "string"},
            "protocol": {"type": "integer"},
            "data_hash": HASH,
            "score_signature": {"type": "string"},
            "causes": COUNTS,
            "reoffers": COUNT,
            "steps": COUNT,
            "intervals": {"type": "string"},
            "scores": ROWS,
            "attempts": {"type": "object", "properties": {"begun": COUNT, "number": COUNT}},
            "epoch": HASH,
            "episodes": {"type": "array", "items": episode},
            "voided": WORDS,
            "corrections": {"type": "array", "items": {"type": "object", "required": ["kind", "made_at", "reason"]}},
            "revision": {"type": "object", "required": ["number", "made_at", "supersedes"]},
            "digest": HASH,
        },
    }


def results() -> Schema:
    """Return the schema of the client's results file."""
    run: Schema = {
        "type": "object",
        "required": ["run_id", "participant", "agent", "split", "language", "sensors", "limits", "data_hash", "state"],
        "properties": {
            **{name: {"type": "string"} for name in ("participant", "agent", "split", "language", "state")},
            "run_id": RUN_ID,
            "sensors": WORDS,
            "limits": LIMITS,
            "data_hash": HASH,
            "episodes": COUNT,
            "episodes_ended": COUNT,
            "steps": COUNT,
            "causes": COUNTS,
        },
    }
    row: Schema = {"type": "object", "required": ["row"], "properties": {"row": {"type": "string"}}}
    episode: Schema = {
        "type": "object",
        "required": ["episode_id", "cause", "steps", "turns"],
        "properties": {"episode_id": {"type": "string"}, "cause": {"type": "string"}, "steps": COUNT, "turns": TURNS},
    }
    failure: Schema = {
        "type": "object",
        "required": ["episodes", "message", "details"],
        "properties": {"episodes": WORDS},
    }
    return {
        "title": "Results of a run, as the client saves them",
        "type": "object",
        "required": ["format", "signature", "run", "table", "metrics", "episodes"],
        "properties": {
            "format": {"const": 1},
            "signature": {"type": "string"},
            "run": run,
            "table": {"type": "array", "items": row},
            "metrics": ROWS,
            "episodes": {"type": "array", "items": episode},
            "agent_failures": {"type": "array", "items": failure},
            "agent_report": {"type": "object"},
            "actions": ACTIONS,
        },
    }
