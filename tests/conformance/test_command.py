"""The command `arramon-client conformance`: exit status, output, and number of runs."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client import cli
from arramon_client.conformance.checks import CHECKS
from arramon_client.transport.access import Access
from arramon_client.transport.connection import METADATA, connect
from arramon_server.runs.accounts.quotas import Quota, Quotas
from arramon_server.runs.storage.database import Database
from tests import ROOT
from tests.api.people import token_of
from tests.conformance.breakers.faults import answers, sets
from tests.conformance.forwarder import Fault, Forwarder
from tests.serving import Server

DOCS = ROOT / "docs" / "reference" / "conformance.md"


def command(address: str, token: str, *more: str) -> int:
    return cli.main(["conformance", "--server", address, "--token", token, *more])


def test_a_failed_check_is_printed_and_written(
    forwarder: Forwarder, token: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = ("--only", "runs.created,steps.forfeit", "--json", str(tmp_path / "results.json"))
    forwarder.install(Fault())
    assert command(forwarder.address, token, *names) == 0
    assert "2 passed, 0 failed, 0 skipped" in capsys.readouterr().out
    forwarder.install(answers("CreateRun", sets(agent="another")))
    assert command(forwarder.address, token, *names) == 1
    said = capsys.readouterr().out
    assert "2 checks, which create up to 2 runs, at most 1 at once, and cancel them" in said
    assert "FAIL  runs.created: CreateRun returns" in said
    assert "      agent of a new run is 'another', expected 'conformance'\n" in said
    assert "pass  steps.forfeit: " in said
    assert "1 passed, 1 failed, 0 skipped" in said
    written = json.loads((tmp_path / "results.json").read_text())
    assert (written["split"], written["language"], written["protocol"]) == ("tiny", "en", 1)
    assert [(each["name"], each["outcome"], bool(each["reason"])) for each in written["checks"]] == [
        ("runs.created", "failed", True),
        ("steps.forfeit", "passed", False),
    ]


def test_the_needed_runs_are_printed_and_checked_against_the_quota(
    server: Server, capsys: pytest.CaptureFixture[str]
) -> None:
    token, needed = token_of(server.data, "bea"), sum(check.runs for check in CHECKS)
    database = Database(f"sqlite:///{server.data / 'journal.db'}")
    quotas = Quotas(database, lambda *_: Quota())
    try:
        quotas.set("bea", "tiny", {"runs_per_day": needed - 1})
        assert command(server.address, token) == 2
        said = capsys.readouterr()
        assert f"create up to {needed} runs, at most 2 at once" in said.out
        assert f"need {needed} runs on split 'tiny', and the quota runs_per_day leaves {needed - 1}" in said.err
        quotas.set("bea", "tiny", {"runs_per_day": None, "runs_at_once": 1})
        assert command(server.address, token, "--only", "runs") == 2
        assert "need 2 runs on split 'tiny', and the quota runs_at_once leaves 1 of 1" in capsys.readouterr().err
        quotas.set("bea", "tiny", {"runs_in_all": 1, "runs_at_once": None})
        with connect(server.address, Access(token=token)) as reached:
            assert not reached.stub.ListRuns(pb.ListRunsRequest(), metadata=METADATA).runs
        assert command(server.address, token, "--only", "steps.repeat") == 0
        assert command(server.address, token, "--only", "steps.repeat") == 2
        assert "the quota runs_in_all leaves 0 of 1" in capsys.readouterr().err
        assert command(server.address, token, "--only", "information") == 0
    finally:
        database.close()


def test_a_hidden_split_gets_the_applicable_checks(
    server: Server, token: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(server.address, token, "--split", "secret", "--lang", "hi") == 0
    said = capsys.readouterr().out
    assert "; split secret, hi\n" in said
    skipped = re.findall(r"skip  (\S+): .*\n      (.*)", said)
    assert {name for name, _ in skipped} == {
        "runs.order", "runs.chosen", "refusals.chosen",
        "steps.turn", "steps.forward", "limits.open_episodes", "sensors.oracle", "sensors.segmentation",
    }  # fmt: skip
    assert all("would make it run" in reason for _, reason in skipped)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--split", "val_seen"), "error: the server has no split 'val_seen'; it has secret (en, hi), tiny (en, hi)"),
        (("--lang", "fr"), "error: the server has no split 'at all' in 'fr'; it has secret (en, hi), tiny (en, hi)"),
        (("--only", "steps.repat"), "error: there is no check or group 'steps.repat', expected some of account, "),
        (("--timeout", "never"), "'never' is not a number of seconds above 0"),
    ],
)
def test_invalid_options_are_refused(
    server: Server, token: str, more: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(server.address, token, *more) == 2
    assert said in capsys.readouterr().err


def test_unreachable_server_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["conformance", "--server", f"unix:{tmp_path}/none"]) == 1
    assert "no server answers at" in capsys.readouterr().err


def test_no_server_module_is_imported() -> None:
    code = "import sys, arramon_client.conformance.command; sys.exit(bool({'server', 'pybullet'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-P", "-c", code]).returncode == 0


def test_the_documentation_lists_every_check_and_its_promise() -> None:
    listed = re.findall(r"^\| `([a-z]+\.[a-z_]+)` \| (.*) \|$", DOCS.read_text(), re.MULTILINE)
    assert listed == [(check.name, check.promise) for check in CHECKS]
