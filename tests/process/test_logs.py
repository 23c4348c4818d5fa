"""The log's format, and the absence of secrets from it."""

import json
import logging
import os
import re
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import grpc
import pytest
from grpc._cython import cygrpc  # type: ignore[attr-defined]

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_server import cli
from arramon_server.api.access_log import network_of
from arramon_server.configuration.secret_masking import mask_secrets
from arramon_server.process.logs import JsonFormatter, TextFormatter, configure
from tests import tiny
from tests.serving import METADATA, Server


def record(message: str, *values: object, level: int = logging.WARNING, **fields: object) -> logging.LogRecord:
    made = logging.getLogger("server.some").makeRecord("server.some", level, "f.py", 1, message, values, None)
    vars(made).update(fields, created=datetime(2026, 3, 1, 12, 0, 0, 250_000, UTC).timestamp())
    return made


def test_json_formatter_writes_one_json_object() -> None:
    line = JsonFormatter().format(record("worker %d died", 3, run_id="7f", worker=3, stream=None))
    assert json.loads(line) == {
        "time": "2026-03-01T12:00:00.250Z",
        "level": "warning",
        "logger": "server.some",
        "message": "worker 3 died",
        "run_id": "7f",
        "worker": 3,
        "stream": None,
    }


def test_text_formatter_writes_one_line() -> None:
    line = TextFormatter().format(record("worker %d died", 3, run_id="7f"))
    assert line == "2026-03-01T12:00:00.250Z WARNING server.some: worker 3 died run_id=7f"


@pytest.mark.parametrize("formatter", [JsonFormatter(), TextFormatter()])
def test_exception_is_logged_as_one_event_with_secrets_masked(formatter: logging.Formatter) -> None:
    try:
        raise ValueError("at postgresql://me:hunter2@db/x\nin two lines")
    except ValueError:
        made = record("broken")
        made.exc_info = sys.exc_info()
    line = formatter.format(made)
    assert "ValueError: at postgresql://me:***@db/x" in line
    if isinstance(formatter, JsonFormatter):
        assert "\n" not in line
        assert json.loads(line)["exception"].endswith("in two lines")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("postgresql://me:hunter2@db:5432/x", "postgresql://me:***@db:5432/x"),
        ("postgresql+psycopg://me:p:w@d@db/x", "postgresql+psycopg://me:***@db/x"),
        ("http://127.0.0.1:8080/a user@host", "http://127.0.0.1:8080/a user@host"),
        ("sqlite:////data/journal.db", "sqlite:////data/journal.db"),
        ("token arramon_0a1b2c_Se-cr_et0 and", "token arramon_0a1b2c_*** and"),
        ("authorization: Bearer abc.def", "authorization: Bearer ***"),
        ("'Bearer arramon_0a1b2c_Secret'", "'Bearer arramon_0a1b2c_***'"),
        ("postgresql://me@db/x?password=hunter2&sslmode=require", "postgresql://me@db/x?password=***&sslmode=require"),
        (
            "postgresql://me@db/x?sslmode=require&ssl%70assword=a;b",
            "postgresql://me@db/x?sslmode=require&ssl%70assword=***",
        ),
        ("host=db password=hunter2 user=me", "host=db password=*** user=me"),
        ("host=db password = 'hun ter2' user=me", "host=db password = *** user=me"),
        (r"password='it\'s hunter2' user=me", "password=*** user=me"),
        (r"password=a\ b user=me", "password=*** user=me"),
        ("PGPASSWORD=hunter2 psql", "PGPASSWORD=*** psql"),
        ("{'host': 'db', 'password': 'hunter2'}", "{'host': 'db', 'password': '***'}"),
        ('{"sslpassword": "hunter2", "port": 1}', '{"sslpassword": \'***\', "port": 1}'),
        ("password authentication failed for user", "password authentication failed for user"),
        ("runs_per_day: secret=3, token_id=7f", "runs_per_day: secret=3, token_id=7f"),
    ],
)
def test_secrets_in_texts_are_masked(text: str, expected: str) -> None:
    assert mask_secrets(text) == expected


def test_secrets_in_the_fields_of_an_event_are_masked() -> None:
    made = record('said "password=\'a"b hunter2\'"', url="postgresql://u:hunter2@h/x", options={"password": "hunter2"})
    line = JsonFormatter().format(made)
    event = json.loads(line)
    assert (event["url"], event["options"]) == ("postgresql://u:***@h/x", {"password": "***"})
    assert "hunter2" not in line
    assert "hunter2" not in TextFormatter().format(made)


@pytest.mark.parametrize(
    ("peer", "network"),
    [
        ("ipv4:203.0.113.77:4711", "203.0.113.0/24"),
        ("ipv6:%5B2001:db8:1:2::3%5D:4711", "2001:db8:1::/48"),
        ("unix:", "unix"),
        ("", "unknown"),
    ],
)
def test_peers_are_logged_by_network_only(peer: str, network: str) -> None:
    assert network_of(peer) == network


def test_client_disconnects_are_not_logged_as_errors(capsys: pytest.CaptureFixture[str]) -> None:
    before = logging.root.handlers[:], logging.root.level
    said_by_grpc = logging.getLogger("grpc._cython.cygrpc")
    try:
        configure("info", "text")
        for error in (cygrpc.ExecuteBatchError("Failed grpc_call_start_batch"), ValueError("a defect")):
            try:
                raise error
            except (cygrpc.ExecuteBatchError, ValueError):
                said_by_grpc.exception("raised by servicer method [/arramon.v1.Evaluation/Play]")
    finally:
        logging.root.handlers, logging.root.level = before
    assert re.findall("[A-Za-z]+Error: .*", capsys.readouterr().err) == ["ValueError: a defect"]


def events(log: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in log.splitlines()]


def test_session_on_a_hidden_split_leaves_no_secret_in_the_log(tmp_path: Path) -> None:
    data, log = tmp_path / "data", tmp_path / "log"
    split = tiny.write(data, hidden=True)
    create = [sys.executable, "-m", "arramon_server", "token", "create", "Somebody", "--data", str(data)]
    token = subprocess.run(create, check=True, capture_output=True, text=True, timeout=240).stdout.strip()
    wrong = "arramon_000000000000_WrongSecret"
    options = ("--no-anonymous", "--log", "debug", "--log-format", "json")
    server = Server(data, "127.0.0.1:0", *options, log=log)
    try:
        command = [sys.executable, "-m", "arramon_client", "--agent", "agents.random_walk", "--lang", "en"]
        command += ["--server", server.address, "--sensors", "none", "--output", str(tmp_path / "results")]
        environment = {**os.environ, "ARRAMON_TOKEN": token}
        played = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=240)
        assert played.returncode == 0, played.stdout + played.stderr
        metadata = (*METADATA, ("authorization", f"Bearer {wrong}"))
        with grpc.insecure_channel(server.address) as channel, pytest.raises(grpc.RpcError):
            EvaluationStub(channel).GetRun(pb.GetRunRequest(run_id="x"), metadata=metadata)
    finally:
        assert server.stop() == 0
    said = log.read_text()
    found = events(said)
    calls = {event["method"].rpartition("/")[2]: event for event in found if event["message"] == "call ended"}
    assert {"account": "Somebody", "peer": "127.0.0.0/24"}.items() <= calls["Play"].items()
    assert calls["Play"]["status"] in ("OK", "CANCELLED")  # A client that knows the run's end hangs up, maybe first.
    assert calls["GetRun"]["status"] == "UNAUTHENTICATED"
    texts = {
        text for each in split.episodes.values() for turns in each.instructions.values() for text in texts_of(turns)
    }
    secrets = {token, token.split("_", 2)[2], wrong, "WrongSecret", *texts}
    secrets |= {str(item.type) for each in split.episodes.values() for turn in each.turns for item in turn.street}
    assert len(secrets) > 8
    for secret in secrets:
        assert secret not in said, secret


def texts_of(turns: Any) -> list[str]:
    return [text for turn in turns for text in (turn.navigation, turn.assembly)]


def test_unreachable_database_error_contains_no_password(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    command = [sys.executable, "-m", "arramon_server", "serve", "--data", str(tmp_path), "--log", "debug"]
    command += ["--log-format", "json", "--journal", "postgresql://me:hunter2@127.0.0.1:1/x"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240)
    assert done.returncode == 1
    assert "hunter2" not in done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert events(done.stderr)[-1]["message"].startswith("the journal cannot be used: ")


def test_info_log_of_a_command_has_no_lines_of_the_migrations(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    command = [sys.executable, "-m", "arramon_server", "token", "list", "--data", str(tmp_path), "--log", "info"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=True)
    assert done.stderr == ""


@pytest.mark.parametrize("by", ["flag", "variable", "file"])
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("serve",), "there are no episodes in "),
        (("serve", "--steps", "no"), "steps (--steps) is 'no', expected a whole number of steps"),
        (("token", "list", "--journal", "postgresql://u:hunter2@127.0.0.1:1/x"), "the journal cannot be used: "),
    ],
)
def test_an_error_that_ends_a_command_has_the_logs_format(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    by: str,
    arguments: tuple[str, ...],
    said: str,
) -> None:
    more: tuple[str, ...] = ("--data", str(tmp_path))
    if by == "flag":
        more += ("--log-format", "json")
    elif by == "variable":
        monkeypatch.setenv("ARRAMON_LOG_FORMAT", "json")
    else:
        (tmp_path / "arramon.toml").write_text('log_format = "json"\n')
        more += ("--config", str(tmp_path / "arramon.toml"))
    assert cli.main([*arguments, *more]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    event = json.loads(line)
    assert (event["level"], event["logger"]) == ("error", "arramon_server.cli")
    assert event["message"].startswith(said)
    assert "hunter2" not in line
