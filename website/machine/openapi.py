"""OpenAPI description of the JSON that the server's pages offer to everyone."""

from typing import Any

from arramon_server import __version__
from website.machine.schemas import ACTIONS, COUNT, RUN_ID, WORDS, Schema, schemas

RUN_PARAMETER: Schema = {
    "name": "run",
    "in": "path",
    "required": True,
    "schema": RUN_ID,
    "description": "id of a published run",
}


def openapi() -> dict[str, Any]:
    """Return the description."""
    return {
        "openapi": "3.1.0",
        "info": {
            "title": "ArraMon leaderboard",
            "version": __version__,
            "description": "Downloads of the pages of `arramon-server serve --web`. Runs are played over gRPC.",
        },
        "paths": {
            "/standings.json": {"get": _get("A list of the leaderboard", "Standings", *_LIST)},
            "/epochs.json": {"get": _get("Epochs of hidden splits", "Epochs")},
            "/runs/{run}/actions.json": {"get": _get("Actions of a published run", "Actions", RUN_PARAMETER)},
            "/runs/{run}/receipt.json": {"get": _get("Receipt of a run", "ReceiptFile", RUN_PARAMETER, _NUMBER)},
        },
        "components": {"schemas": {
            "Standings": _STANDINGS, "Epochs": _EPOCHS, "Actions": _ACTIONS,
            "ReceiptFile": {name: value for name, value in schemas()["receipt-file"].items() if name != "$schema"},
        }},
    }  # fmt: skip


def _get(summary: str, schema: str, *parameters: Schema) -> Schema:
    content = {"application/json": {"schema": {"$ref": f"#/components/schemas/{schema}"}}}
    return {
        "summary": summary,
        "parameters": list(parameters),
        "responses": {"200": {"description": summary, "content": content}, "404": {"description": "there is none"}},
    }


def _query(name: str, about: str) -> Schema:
    return {"name": name, "in": "query", "schema": {"type": "string"}, "description": about}


_LIST = (
    _query("split", "name of a split"),
    _query("language", "code of a language, or `both`"),
    _query("sort", "a metric, such as `ndtw`, `ctc-3` or `ptc`"),
)

_NUMBER: Schema = {
    "name": "number", "in": "query", "schema": COUNT, "description": "number of a receipt that was superseded",
}  # fmt: skip

_NUMBER_OR_NONE: Schema = {"type": ["number", "null"]}

_STANDING: Schema = {
    "type": "object",
    "required": [
        "rank",
        "tied",
        "participant",
        "agent",
        "languages",
        "sensors",
        "coverage",
        "marks",
        "rows",
        "entries",
    ],
    "properties": {
        "rank": {"type": ["integer", "null"]},
        "tied": {"type": "boolean"},
        "participant": {"type": "string"},
        "agent": {"type": "string"},
        "languages": WORDS,
        "sensors": WORDS,
        "coverage": _NUMBER_OR_NONE,
        "marks": WORDS,
        "rows": {"type": "object"},
        "entries": {"type": "array", "items": {"type": "object", "required": ["run_id", "language", "signature"]}},
        "last_rank": {"type": ["integer", "null"]},
        "runs_begun": COUNT,
        "runs_published": COUNT,
        "seconds_a_step": _NUMBER_OR_NONE,
        "gap": {"type": ["object", "null"]},
        "seeds": {"type": ["object", "null"]},
        "declared_cost": {"type": "object"},
    },
}

_STANDINGS: Schema = {
    "type": "object",
    "required": ["format", "version", "split", "language", "sort", "standings", "references", "corrections", "frozen"],
    "properties": {
        "format": {"const": "arramon-standings"},
        "version": {"const": 1},
        **{name: {"type": "string"} for name in ("split", "language", "sort")},
        "standings": {"type": "array", "items": _STANDING},
        "references": {"type": "array", "items": {"type": "object"}},
        "corrections": {"type": "array", "items": {"type": "object", "required": ["kind", "made_at", "reason"]}},
    },
}

_EPOCHS: Schema = {
    "type": "object",
    "required": ["format", "version", "epochs"],
    "properties": {
        "format": {"type": "string"},
        "version": {"type": "integer"},
        "epochs": {"type": "array", "items": {"type": "object"}},
    },
}

_ACTIONS: Schema = {
    "type": "object",
    "required": ["actions"],
    "properties": {"actions": ACTIONS},
}
