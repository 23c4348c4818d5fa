"""The server's command line: output, exit statuses and error messages."""

import argparse
import json
import re
import signal
import socket
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from arramon_server.cli import FAMILIES
from tests import ROOT, tiny
from tests.dataset import recovered_split
from tests.forked import run
from tests.release_format import record
from tests.serving import Server


def error(*arguments: object) -> str:
    """What a command that must fail says, without its name; nothing else may be printed."""
    done = run(*arguments)
    assert (done.returncode, done.stdout) == (1, ""), done
    assert "Traceback" not in done.stderr
    return done.stderr.removeprefix("arramon-server: ").strip()


def test_serve_without_episodes_suggests_generating_them(tmp_path: Path) -> None:
    said = error("serve", "--data", tmp_path)
    assert said.startswith(f"there are no episodes in {tmp_path}; make some with `arramon-server generate")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ["--rooms", "3", "--split", "train"],
            "--rooms generates the split rooms only; leave out --split, --sections and --secret",
        ),
        (["--rooms", "0"], "the number of room tasks is 0; expected at least 1"),
        (
            ["--split", "train_extra"],
            "the split 'train_extra' needs a number of sections: give it with --sections",
        ),
    ],
)
def test_generate_refuses_what_does_not_fit_together(tmp_path: Path, arguments: list[str], said: str) -> None:
    assert error("generate", "--data", tmp_path, *arguments) == said


def test_serve_reports_a_port_in_use(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        address = f"127.0.0.1:{other.getsockname()[1]}"
        done = run("serve", "--data", tmp_path, "--listen", address)
    assert done.returncode == 1
    assert done.stderr.strip().endswith(f"cannot listen on '{address}': Address already in use")


@pytest.mark.parametrize("listen", ["nonsense", "127.0.0.1:99999", ":50551", "unix:"])
def test_serve_refuses_malformed_addresses(tmp_path: Path, listen: str) -> None:
    said = error("serve", "--data", tmp_path, "--listen", listen)
    assert said == f"listen (--listen) is '{listen}', expected host:port or unix:/path"


def test_serve_reports_unusable_addresses(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    for address, why in (
        ("unix:/no/such/folder/socket", "No such file or directory"),
        ("192.0.2.1:50551", "Cannot assign requested address"),
    ):
        assert error("serve", "--data", tmp_path, "--listen", address) == f"cannot listen on '{address}': {why}"


def test_key_command_announces_a_new_key(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    path = tmp_path / "signing-key.pem"
    first, second = run("key", "--data", tmp_path), run("key", "--data", tmp_path)
    assert first.stderr == f"no key at {path}: creating a new one\n"
    assert (second.stdout, second.stderr) == (first.stdout, "")


def test_serve_reports_an_unusable_journal_path(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    (tmp_path / "journal.db").mkdir()
    done = run("serve", "--data", tmp_path)
    assert done.returncode == 1
    assert "the journal cannot be used: unable to open database file" in done.stderr


def test_serve_reports_a_broken_journal(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    (tmp_path / "journal.db").write_bytes(b"this is no database, but it is long enough to look like a file" * 40)
    done = run("serve", "--data", tmp_path)
    assert done.returncode == 1
    assert "the journal cannot be used: file is not a database" in done.stderr


def test_serve_refuses_an_out_of_range_step_limit(tmp_path: Path) -> None:
    assert error("serve", "--data", tmp_path, "--steps", 0) == (
        "steps (--steps) is '0', expected a whole number of steps from 1 to 10000"
    )


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signals_drain_and_exit_0(tmp_path: Path, number: signal.Signals) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path, anew=True)
    server.process.send_signal(number)
    assert server.stop() == 0


def test_health_command_distinguishes_running_and_stopped_servers(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path)
    try:
        healthy = run("health", "--address", server.address)
        assert (healthy.returncode, healthy.stdout) == (0, f"{server.address} serves\n")
    finally:
        server.stop()
    assert error("health", "--address", server.address) == f"no answer from {server.address}: UNAVAILABLE"


def write(path: Path, records: Any) -> Path:
    path.write_text(json.dumps(records))
    return path


def test_import_prints_the_split_it_wrote(tmp_path: Path) -> None:
    file = write(tmp_path / "mine.json", [record(7), record(8)])
    done = run("import-release", file, "--data", tmp_path / "data")
    assert done.returncode == 0
    assert re.fullmatch(r"split mine \(open\): 2 in en; 1 section; data [0-9a-f]{12}\n", done.stdout)


def test_demands_are_of_generated_splits_that_are_there(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    assert error("demands", "gone", "--data", tmp_path) == f"there is no split 'gone' in {tmp_path}"
    assert error("demands", "tiny", "--data", tmp_path).startswith("split 'tiny' is tests; what instructions ask for ")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "is not JSON: "),
        ('[{"mapId": 1', "is not JSON: "),
        ("{}", "input should be a valid list"),
        ("[]", "contains no episodes"),
        ("[{}]", "[0].mapId: field required"),
    ],
)
def test_import_refuses_files_in_another_format(tmp_path: Path, content: str, message: str) -> None:
    file = tmp_path / "bad.json"
    file.write_text(content)
    said = error("import-release", file, "--data", tmp_path / "data")
    assert said.startswith(f"{file}: ")
    assert message in said
    assert not (tmp_path / "data").exists()


def test_import_reports_a_missing_file(tmp_path: Path) -> None:
    said = error("import-release", tmp_path / "gone.json", "--data", tmp_path)
    assert said == f"{tmp_path / 'gone.json'}: cannot be read: No such file or directory"


def test_import_refuses_an_unknown_language(tmp_path: Path) -> None:
    file = write(tmp_path / "mine.json", [record(7)])
    assert (
        error("import-release", file, "--data", tmp_path, "--lang", "fr")
        == "there is no language 'fr'; there are en, hi, te"
    )


def test_import_reports_an_unwritable_folder(tmp_path: Path) -> None:
    file = write(tmp_path / "mine.json", [record(7)])
    said = error("import-release", file, "--data", file)
    assert said == f"cannot write to {file}/splits/mine: Not a directory"


def test_show_writes_pictures_and_reports_what_is_missing(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    done = run("show", "3", "--data", tmp_path, "--output", tmp_path / "pictures")
    names = ("map.png", "views.png", "instructions.txt")
    assert done.stdout.split() == [str(tmp_path / "pictures" / f"tiny-3-{name}") for name in names]
    texts = (tmp_path / "pictures" / "tiny-3-instructions.txt").read_text().splitlines()
    assert [line.partition(": ")[0] for line in texts[:2]] == ["en, turn 1, navigation", "en, turn 1, assembly"]
    assert error("show", "99", "--data", tmp_path) == "there is no episode '99' in tiny"
    assert error("show", "3", "--split", "x", "--data", tmp_path) == "there is no split 'x'; there are tiny"
    blocked = tmp_path / "pictures" / "tiny-3-map.png"
    assert error("show", "3", "--data", tmp_path, "--output", blocked).startswith(f"cannot write {blocked}")


def test_show_draws_a_section_and_lists_what_was_recovered(tmp_path: Path) -> None:
    recovered_split.write(tmp_path)
    pictures = tmp_path / "pictures"
    done = run("show", "--section", "1", "--data", tmp_path, "--output", pictures)
    assert done.stdout.split() == [str(pictures / f"own-section-1-{name}") for name in ("map.png", "recovered.txt")]
    assert (pictures / "own-section-1-recovered.txt").read_text().splitlines() == [
        "  31.4 votes  red barrier              at (1.5, 1.0)",
        "  12.0 votes  brick building           at (0.0, 12.0)",
        "   8.6 votes  traffic light            at (-15.0, -12.0)",
    ]
    assert error("show", "--section", "9", "--data", tmp_path) == "there is no section '9' in own"
    for both in ((), ("0", "--section", "1")):
        assert error("show", *both, "--data", tmp_path).startswith("expected either an episode or a section to show")


@pytest.mark.parametrize("family", FAMILIES)
def test_each_command_family_defines_its_listed_commands(family: str) -> None:
    commands = argparse.ArgumentParser().add_subparsers()
    import_module(f"arramon_server.commands.{family}").add(commands, argparse.ArgumentParser(add_help=False))
    assert tuple(commands.choices) == FAMILIES[family]


def test_help_lists_the_commands_of_every_family() -> None:
    assert {command for its in FAMILIES.values() for command in its} <= set(run("--help").stdout.split())
    modules = {path.stem for path in ROOT.glob("server/commands/*.py")}
    assert modules - {"__init__", "journal", "split_description"} == set(FAMILIES)


def test_token_list_does_not_import_rendering_libraries(tmp_path: Path) -> None:
    code = (
        f"import sys; from arramon_server.cli import main; main(['token', 'list', '--data', {str(tmp_path)!r}]); "
        "print([name for name in ('numba', 'grpc', 'scipy') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=240, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize(("word", "said"), [
    ("sevre", "arramon-server: unknown command 'sevre'; did you mean 'serve'?\n"),
    ("xyzzy", "arramon-server: unknown command 'xyzzy'; expected serve, health, config, "),
])  # fmt: skip
def test_an_unknown_command_is_named_with_the_nearest(word: str, said: str) -> None:
    done = run(word)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(said)
