"""Logging to standard error as lines of text or JSON objects, with secrets masked."""

import json
import logging
import sys
from datetime import UTC, datetime
from typing import Any

from arramon_server.configuration.secret_masking import MASK, is_secret, mask_secrets

_OWN = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "taskName"}
"""Attributes that every log record has; all others are fields of the event."""

_GRPC = logging.getLogger("grpc._cython.cygrpc")
"""Logger of gRPC's asynchronous server."""

_ALEMBIC = logging.getLogger("alembic")
"""Logger of the migrations."""


def configure(level: str, log_format: str) -> None:
    """Log events of `level` and above to standard error, in the form "text" or "json"."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonFormatter() if log_format == "json" else TextFormatter())
    logging.basicConfig(level=level.upper(), handlers=[handler], force=True)
    _GRPC.addFilter(_is_relevant)
    _ALEMBIC.setLevel(logging.DEBUG if level == "debug" else logging.WARNING)  # its lines are of no use to a host


def _is_relevant(record: logging.LogRecord) -> bool:
    """Return False for errors that gRPC logs when a client leaves before its call's last message is sent."""
    return not (record.exc_info and type(record.exc_info[1]).__name__ == "ExecuteBatchError")


def json_error_line(logger: str, message: str) -> str:
    """Return an error as a line of the JSON log."""
    return JsonFormatter().format(logging.LogRecord(logger, logging.ERROR, "", 0, message, None, None))


class TextFormatter(logging.Formatter):
    """Formats lines like `2026-03-01T12:00:00.000Z WARNING arramon_server.process.lifecycle: draining run_id=7f`."""

    def format(self, record: logging.LogRecord) -> str:
        """Return one line, followed by the lines of a traceback."""
        fields = "".join(f" {name}={value}" for name, value in _fields(record).items())
        line = f"{_time(record)} {record.levelname} {record.name}: {record.getMessage()}{fields}"
        if record.exc_info:
            line += "\n" + self.formatException(record.exc_info)
        return mask_secrets(line)


class JsonFormatter(logging.Formatter):
    """Formats one JSON object per line: time (RFC 3339, UTC), level, logger, message, and the event's fields."""

    def format(self, record: logging.LogRecord) -> str:
        """Return one line."""
        event: dict[str, Any] = {
            "time": _time(record),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
            **_fields(record),
        }
        if record.exc_info:
            event["exception"] = self.formatException(record.exc_info)
        return json.dumps(_masked(event), ensure_ascii=False)


def _fields(record: logging.LogRecord) -> dict[str, Any]:
    return {name: value for name, value in vars(record).items() if name not in _OWN}


def _masked(value: Any) -> Any:
    """Return plain data with secrets masked. In the final JSON text, masking could cut through an escape sequence."""
    if value is None or isinstance(value, bool | int | float):
        return value
    if isinstance(value, dict):
        pairs = ((str(name), each) for name, each in value.items())
        return {name: MASK if is_secret(name) else _masked(each) for name, each in pairs}
    if isinstance(value, list | tuple):
        return [_masked(each) for each in value]
    return mask_secrets(str(value))


def _time(record: logging.LogRecord) -> str:
    return datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
