"""Settings from file, environment and flags: precedence, validation and printing."""

import json
import os
import re
import subprocess
import sys
import tomllib
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from arramon_client.transport.connection import connect
from arramon_server import cli
from arramon_server.addresses import is_loopback
from arramon_server.cli import parser
from arramon_server.commands.config import as_table, as_toml
from arramon_server.configuration import config
from arramon_server.configuration.config import SETTINGS, Config, ContradictorySettings
from arramon_server.configuration.sources import ResolvedSettings, environment_of, load_configuration, without_settings
from arramon_server.errors import BadInput
from arramon_server.per_split import PerSplit
from arramon_server.sim.physics import has_pybullet, problem_of_camera
from arramon_server.split_times import SplitTimes
from tests import ROOT, tiny
from tests.physics import ANY_CAMERA
from tests.serving import Server

CLOSES = SplitTimes((("a", datetime(2030, 12, 1, 12, tzinfo=UTC)), ("b", datetime(2031, 1, 1, tzinfo=UTC))))

EVERYTHING: dict[str, tuple[str, Any]] = {
    "data": ("elsewhere", Path("elsewhere")),
    "listen": ("unix:/run/a", "unix:/run/a"),
    "journal": ("postgresql://u:p@h/n", "postgresql://u:p@h/n"),
    "fsync": ("false", False),
    "workers": ("3", 3),
    "camera": ("tiny", "tiny"),
    "image_sizes": ("64,32", (64, 32)),
    "steps": ("7", 7),
    "step_seconds": ("1.5", 1.5),
    "bank_seconds": ("1800", 1800.0),
    "keepalive_seconds": ("5", 5.0),
    "max_episodes_per_stream": ("9", 9),
    "max_calls": ("64", 64),
    "max_message_bytes": ("65536", 65536),
    "note_bytes": ("100", 100),
    "run_note_bytes": ("5000", 5000),
    "anonymous": ("true", True),
    "runs_per_day": ("4", PerSplit(4)),
    "runs_in_all": ("40,test_unseen=3", PerSplit(40, (("test_unseen", 3),))),
    "runs_at_once": ("a=0,b=2", PerSplit(None, (("a", 0), ("b", 2)))),
    "streams_at_once": ("8", PerSplit(8)),
    "tls_certificate": ("c.pem", Path("c.pem")),
    "tls_key": ("k.pem", Path("k.pem")),
    "trust_proxy": ("true", True),
    "signing_key": ("s.pem", Path("s.pem")),
    "web": ("127.0.0.1:8080", "127.0.0.1:8080"),
    "play_page": ("false", False),
    "play_image_sizes": ("256,128", (256, 128)),
    "play_landing_diagram": ("true", True),
    "play_frame_strip": ("true", True),
    "play_compass": ("true", True),
    "play_look_around": ("true", True),
    "play_zoom": ("true", True),
    "play_pictured_names": ("true", True),
    "play_ahead": ("true", True),
    "play_scene_words": ("true", True),
    "metrics": ("[::1]:9090", "[::1]:9090"),
    "host_name": ("Lab of streets", "Lab of streets"),
    "host_contact": ("mail@example.org", "mail@example.org"),
    "host_rules": ("https://example.org/rules", "https://example.org/rules"),
    "closes": ("a=2030-12-01T12:00:00Z,b=2031-01-01T00:00:00Z", CLOSES),
    "frozen": ("true", True),
    "drain_seconds": ("2.5", 2.5),
    "log": ("debug", "debug"),
    "log_format": ("json", "json"),
}
"""A text and the value that it stands for, of each setting; none is its default."""


@pytest.fixture(autouse=True)
def installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """What settings mean does not depend on what is installed."""
    if not has_pybullet():
        monkeypatch.setattr(config, "problem_of_camera", lambda _: "")


def load(*arguments: str, file: Path | None = None, **variables: Any) -> ResolvedSettings:
    named = ("--config", str(file)) if file else ()
    return load_configuration(vars(parser().parse_args(["serve", *named, *arguments])), variables)


def refusal(*arguments: str, file: Path | None = None, **variables: Any) -> str:
    with pytest.raises(BadInput) as caught:
        load(*arguments, file=file, **variables)
    return str(caught.value)


PUBLIC = (
    "listen", "anonymous", "runs_per_day", "runs_in_all", "runs_at_once", "streams_at_once", "tls_certificate",
    "tls_key", "trust_proxy", "web", "metrics", "closes", "frozen",
)  # fmt: skip
"""Settings that an embedded server takes from flags only."""


def test_an_embedded_server_takes_no_address_and_no_limit_of_a_public_one(tmp_path: Path) -> None:
    file = tmp_path / "arramon.toml"
    file.write_text('web = "0.0.0.0:80"\nlisten = "0.0.0.0:50551"\nanonymous = false\nruns_per_day = 1\nsteps = 7\n')
    variables = {f"ARRAMON_{name.upper()}": EVERYTHING[name][0] for name in PUBLIC} | {"ARRAMON_LOG": "debug"}
    found = load("--embedded", "--listen", "unix:/run/a", "--metrics", "127.0.0.1:1", file=file, **variables)
    assert replace(found.config, embedded=False) == replace(
        Config(), listen="unix:/run/a", metrics="127.0.0.1:1", steps=7, log="debug"
    )
    assert {name for name, setting in SETTINGS.items() if setting.description.of_public_server} == set(PUBLIC)
    assert load(file=file).config.web == "0.0.0.0:80"


def test_every_setting_has_a_non_default_test_value() -> None:
    assert set(EVERYTHING) == {name for name, setting in SETTINGS.items() if not setting.description.internal}
    assert all(value != SETTINGS[name].default for name, (_, value) in EVERYTHING.items())


def test_loading_without_any_source_gives_the_defaults() -> None:
    assert load() == ResolvedSettings(Config(), {})


def test_every_setting_is_read_from_flags() -> None:
    arguments = []
    for name, (text, value) in EVERYTHING.items():
        flag = "--" + name.replace("_", "-")
        arguments += [flag] if value is True else ["--no-" + flag[2:]] if value is False else [flag, text]
    assert load(*arguments).config == Config(**{name: value for name, (_, value) in EVERYTHING.items()})


def test_every_setting_round_trips_through_the_environment() -> None:
    variables: dict[str, Any] = {f"ARRAMON_{name.upper()}": text for name, (text, _) in EVERYTHING.items()}
    config = load(**variables).config
    assert config == Config(**{name: value for name, (_, value) in EVERYTHING.items()})
    assert environment_of(config) == variables
    assert without_settings({**variables, "ARRAMON_CONFIG": "f", "HOME": "/"}) == {"HOME": "/"}


# Some are not alone; they go together with others in the test before this one.
@pytest.mark.parametrize("name", [name for name in EVERYTHING if name not in ("tls_certificate", "tls_key", "frozen")])
def test_each_setting_is_passed_unchanged_to_another_process(name: str) -> None:
    config = replace(Config(), **{name: EVERYTHING[name][1]})
    variables: dict[str, Any] = {**environment_of(config)}
    assert load(**variables).config == config


def test_every_setting_is_read_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    values = {name: list(value) if isinstance(value, tuple) else value for name, (_, value) in EVERYTHING.items()}
    file.write_text("\n".join(f"{name} = {json.dumps(value, default=str)}" for name, value in values.items()))
    expected = Config(**{name: value for name, (_, value) in EVERYTHING.items()})
    assert load(file=file).config == expected
    assert load(ARRAMON_CONFIG=str(file)).config == expected


def test_tables_of_other_packages_are_left_to_them(tmp_path: Path) -> None:
    file = tmp_path / "arramon.toml"
    file.write_text("steps = 7\n[collections.street]\nverifiers = 2\n")
    assert load_configuration({"config": str(file)}, {}).config == Config(steps=7)
    file.write_text("collections = 3\n")
    with pytest.raises(BadInput, match="there is no setting 'collections'"):
        load_configuration({"config": str(file)}, {})


def test_flags_override_the_environment_which_overrides_the_file(tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    file.write_text("steps = 1\nruns_per_day = 1\nruns_in_all = 1")
    found = load("--runs-in-all", "3", file=file, ARRAMON_RUNS_PER_DAY="2", ARRAMON_RUNS_IN_ALL="2", ARRAMON_STEPS="")
    assert (found.config.steps, found.config.runs_per_day, found.config.runs_in_all) == (1, PerSplit(2), PerSplit(3))
    assert found.origins == {
        "steps": f"steps in {file}",
        "runs_per_day": "$ARRAMON_RUNS_PER_DAY",
        "runs_in_all": "--runs-in-all",
    }


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("steps", "0", "a whole number of steps from 1 to 10000"),
        ("steps", "many", "a whole number of steps from 1 to 10000"),
        ("workers", "257", "a whole number from 1 to 256"),
        ("bank_seconds", "-1", "a number of seconds from 0 to 31536000"),
        ("bank_seconds", "nan", "a number of seconds from 0 to 31536000"),
        ("drain_seconds", "inf", "a number of seconds from 0 to 3600"),
        ("camera", "none", "one of raster, tiny"),
        ("log", "loud", "one of debug, info, warning, error"),
        ("image_sizes", "224,8", "whole numbers of pixels from 16 to 1024, separated by commas"),
        ("web", "unix:/run/web", "host:port"),
        ("listen", "0.0.0.0", "host:port or unix:/path"),
    ],
)
def test_out_of_range_values_are_refused_from_every_source(tmp_path: Path, name: str, text: str, expected: str) -> None:
    flag, variable, file = "--" + name.replace("_", "-"), "ARRAMON_" + name.upper(), tmp_path / "a.toml"
    file.write_text(f"{name} = {json.dumps(text)}")
    assert refusal(flag, text) == f"{name} ({flag}) is '{text}', expected {expected}"
    variables: dict[str, Any] = {variable: text}
    assert refusal(**variables) == f"{name} (${variable}) is '{text}', expected {expected}"
    assert refusal(file=file) == f"{name} ({name} in {file}) is '{text}', expected {expected}"


def test_non_boolean_variables_are_refused() -> None:
    assert refusal(ARRAMON_FSYNC="perhaps") == "fsync ($ARRAMON_FSYNC) is 'perhaps', expected true or false"


@pytest.mark.parametrize("value", ["true", "[1]", "1979-05-27", "{a = 1}"])
def test_values_of_the_wrong_type_in_the_file_are_refused(tmp_path: Path, value: str) -> None:
    file = tmp_path / "a.toml"
    file.write_text(f"steps = {value}" if value != "[1]" else "steps = [1, 2]")
    assert refusal(file=file).startswith(f"steps (steps in {file}) is ")


THREE_ON_THE_HIDDEN_ONE = PerSplit(None, (("test_unseen", 3),))


@pytest.mark.parametrize(
    ("toml", "expected"),
    [
        ("3", PerSplit(3)),
        ("{test_unseen = 3}", THREE_ON_THE_HIDDEN_ONE),
        ("{default = 5, test_unseen = 3}", PerSplit(5, (("test_unseen", 3),))),
        ('"5,test_unseen=3"', PerSplit(5, (("test_unseen", 3),))),
        ('{"a split" = 1}', PerSplit(None, (("a split", 1),))),
        ("0", PerSplit(0)),
        ("{default = 0, a = 1}", PerSplit(0, (("a", 1),))),
    ],
)
def test_per_split_limits_are_read_from_and_written_to_a_file(tmp_path: Path, toml: str, expected: PerSplit) -> None:
    file = tmp_path / "a.toml"
    file.write_text(f"runs_per_day = {toml}")
    assert load(file=file).config.runs_per_day == expected
    file.write_text(as_toml(load(file=file)))
    assert load(file=file).config.runs_per_day == expected


def test_per_split_limits_are_read_from_flags_and_environment() -> None:
    assert load("--runs-per-day", "test_unseen=3").config.runs_per_day == THREE_ON_THE_HIDDEN_ONE
    assert load(ARRAMON_RUNS_PER_DAY="test_unseen=3").config.runs_per_day == THREE_ON_THE_HIDDEN_ONE
    several = load("--runs-per-day", "5", "--runs-per-day", "b=1", "--runs-per-day", "a=0,c=7").config.runs_per_day
    assert several == PerSplit(5, (("a", 0), ("b", 1), ("c", 7)))
    assert [several.of(split) for split in ("a", "b", "c", "d")] == [0, 1, 7, 5]


@pytest.mark.parametrize("text", ["a=", "=3", "a=-1", "a=x", "a=1,a=2", "3,4", "a=1000000001", "1.5", "a=1,", "a=٣"])
def test_malformed_limits_are_refused(text: str) -> None:
    expected = "a whole number of runs from 0 to 1000000000, or SPLIT=NUMBER, separated by commas"
    assert refusal("--runs-per-day", text) == f"runs_per_day (--runs-per-day) is {text!r}, expected {expected}"


@pytest.mark.parametrize("toml", [
    '"a=2030-12-01 12:00,b=2031-01-01"',
    "{a = 2030-12-01T17:30:00+05:30, b = 2031-01-01}",
    '{a = "2030-12-01T12:00Z", b = 2031-01-01T00:00:00Z}',
])  # fmt: skip
def test_times_of_splits_are_read_from_and_written_to_a_file(tmp_path: Path, toml: str) -> None:
    file = tmp_path / "a.toml"
    file.write_text(f"closes = {toml}")
    assert load(file=file).config.closes == CLOSES
    file.write_text(as_toml(load(file=file)))
    assert load(file=file).config.closes == CLOSES
    assert load("--closes", "b=2031-01-01", "--closes", "a=2030-12-01T12:00Z").config.closes == CLOSES


@pytest.mark.parametrize(
    "text", ["2030-12-01", "a=", "a=tomorrow", "a=2030-13-01", "a=2030-12-01,a=2031-01-01", "=2030-01-01"]
)
def test_malformed_times_are_refused(text: str) -> None:
    with pytest.raises(
        BadInput, match=r"^closes \(--closes\) is .*, expected SPLIT=TIME, such as test_unseen=2030-12-01T12"
    ):
        load("--closes", text)


def test_a_frozen_leaderboard_needs_a_time_at_which_it_closes() -> None:
    with pytest.raises(BadInput, match=r"^frozen is set but closes is not; .* \(frozen: --frozen\)$"):
        load("--frozen")


@pytest.mark.parametrize("text", ["two\nlines", "e\x1b[31m", "a" * 501, "bidi\u202e"])
def test_the_host_says_one_line_of_visible_text(text: str) -> None:
    with pytest.raises(BadInput, match="expected one line of at most 500 characters"):
        load("--host-name", text)


def test_limits_on_unknown_splits_are_refused(tmp_path: Path) -> None:
    """A split with a misspelt name would have no limit, and nobody would know."""
    tiny.write(tmp_path)
    done = run(tmp_path, "serve", "--listen", "127.0.0.1:0", "--runs-at-once", "tiny=1,tinny=2")
    assert (done.returncode, done.stderr) == (
        1,
        f"arramon-server: runs_at_once names the split 'tinny', which is not in {tmp_path}; existing splits: tiny\n",
    )


def test_documented_examples_are_valid_settings(tmp_path: Path) -> None:
    documented = PerSplit(None, (("test_unseen_e1", 3),))
    text = (ROOT / "docs" / "reference" / "configuration.md").read_text()
    (example,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    file = tmp_path / "a.toml"
    file.write_text(example)
    assert load(file=file).config.runs_per_day == documented
    (flags,) = re.findall(r"```sh\narramon-server serve (.*?)\n```", text, re.DOTALL)
    assert load(*flags.split()).config.runs_per_day == documented


def test_unknown_settings_are_refused_with_a_suggestion(tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    file.write_text("step = 3")
    assert refusal(file=file) == f"{file}: there is no setting 'step'; did you mean 'steps'?"
    file.write_text("shared_port = true")
    assert refusal(file=file).startswith(f"{file}: there is no setting 'shared_port'")
    assert refusal(ARRAMON_WROKERS="2") == "$ARRAMON_WROKERS: there is no setting 'wrokers'; did you mean 'workers'?"
    said = "$ARRAMON_workers: there is no setting 'workers'; did you mean $ARRAMON_WORKERS?"
    assert refusal(ARRAMON_workers="2") == said


def test_empty_paths_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    file.write_text('data = ""')
    assert refusal(file=file) == f"data (data in {file}) is '', expected a path"


@pytest.mark.parametrize("journal", ["nonsense", "mysql://a:b@host/name", "/var/lib/journal.db"])
def test_journal_urls_of_other_databases_are_refused(journal: str) -> None:
    said = refusal("--journal", journal)
    assert said == "journal (--journal) is invalid, expected sqlite:///PATH or postgresql://USER:...@HOST/NAME"
    assert refusal(ARRAMON_XYZ="2") == "$ARRAMON_XYZ: there is no setting 'xyz'; `arramon-server config` lists them"


def test_unrelated_environment_variables_are_ignored() -> None:
    of_kubernetes = ("SERVICE_HOST", "SERVICE_PORT_GRPC", "PORT", "PORT_50551_TCP_ADDR", "WEB_SERVICE_PORT")
    variables: dict[str, Any] = {f"ARRAMON_{name}": "tcp://10.0.0.1:80" for name in of_kubernetes}
    assert load(**variables, ARRAMON_TOKEN="t", ARRAMON_RELEASE="r", HOME="/root") == load()


def test_missing_and_malformed_files_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    assert refusal(file=file) == f"{file}: cannot be read: No such file or directory"
    file.write_text("steps: 3")
    assert refusal(file=file).startswith(f"{file}: is not TOML: ")


def test_contradictory_settings_are_refused_naming_their_sources() -> None:
    assert refusal("--tls-key", "k", ARRAMON_ANONYMOUS="false") == (
        "tls_key is set but tls_certificate is not; expected both or neither (tls_key: --tls-key)"
    )
    assert refusal("--web", "h:1", ARRAMON_LISTEN="h:1") == (
        "web and listen are both h:1; expected different ones (web: --web; listen: $ARRAMON_LISTEN)"
    )
    with pytest.raises(ContradictorySettings, match="tls_certificate is set but tls_key is not"):
        Config(tls_certificate=Path("c"))


def test_the_reference_camera_is_refused_without_pybullet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(config, "problem_of_camera", problem_of_camera)
    monkeypatch.setitem(sys.modules, "pybullet", None)
    assert refusal("--camera", "tiny") == (
        "camera is 'tiny', which needs pybullet, and that is not installed: pip install 'arramon-server[pybullet]' "
        "compiles it, with a C++ compiler. Expected raster without it (camera: --camera)"
    )
    assert load().config.camera == "raster"


@pytest.mark.parametrize(
    ("given", "shown"),
    [
        ("postgresql://host:hunter2@db/x", "postgresql://host:***@db/x"),
        ("postgresql://host:hun/ter2@db/x", "postgresql://host:***@db/x"),
        ("postgresql://host:a@hunter2@db/x", "postgresql://host:***@db/x"),
        ("postgresql://host:a hunter2@db/x", "postgresql://host:***@db/x"),
        ("postgresql://host:what?hunter2@db/x", "postgresql://host:***@db/x"),
        ("postgresql://host@db/x?password=a hunter2", "postgresql://host@db/x?password=***"),
        ("postgresql://host@db/x?password=hunter2", "postgresql://host@db/x?password=***"),
        ("postgresql:///x?host=db&password=hunter2&user=u", "postgresql:///x?host=db&password=***&user=u"),
        ("postgresql://db/x?sslpassword=hunter2;&sslmode=require", "postgresql://db/x?sslpassword=***&sslmode=require"),
        ("postgresql://db/x?PassWord=hunter2", "postgresql://db/x?PassWord=***"),
        ("postgresql://db/x?pass%77ord=hunter2", "postgresql://db/x?pass%77ord=***"),
        ("postgresql://db/x?password=it's hunter2", "postgresql://db/x?password=***"),
        ("postgresql://db/x?unheard_of=hunter2", "postgresql://db/x?unheard_of=***"),
        ("postgresql://db/x?oauth_client_secret=hunter2&port=1", "postgresql://db/x?oauth_client_secret=***&port=1"),
        ("sqlite:////a/b@c/j.db", "sqlite:////a/b@c/j.db"),
    ],
)
def test_config_command_masks_passwords_of_every_form(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, given: str, shown: str
) -> None:
    file = tmp_path / "arramon.toml"
    file.write_text(f"journal = {json.dumps(given)}\n")
    assert cli.main(["config", "--journal", given]) == 0
    assert f'journal = "{shown}"  # --journal' in capsys.readouterr().out.splitlines()
    assert cli.main(["config", "--config", str(file)]) == 0
    assert f'journal = "{shown}"  # journal in {file}' in capsys.readouterr().out.splitlines()
    monkeypatch.setenv("ARRAMON_JOURNAL", given)
    assert cli.main(["config"]) == 0
    assert f'journal = "{shown}"  # $ARRAMON_JOURNAL' in capsys.readouterr().out.splitlines()


UNREACHABLE = "127.0.0.1:1"
"""Nothing listens there."""


@pytest.mark.parametrize(
    "url",
    [
        f"postgresql://u:hunter2@{UNREACHABLE}/x",
        f"postgresql://u@{UNREACHABLE}/x?password=hunter2&sslpassword=hunter2",
        f"postgresql://u:a@hunter2@{UNREACHABLE}/x",
        f"postgresql://u@{UNREACHABLE}/x?pasword=hunter2",
        "mysql://u:hunter2@db/x",
        "postgresql://u:hunter2@db:port/x",
        "hunter2",
    ],
)
@pytest.mark.parametrize(
    "command",
    [
        ("serve", "--listen", "127.0.0.1:0"),
        ("backup", "new"),
        ("import", "file"),
        ("export", "file"),
        ("runs",),
        ("token", "list"),
    ],
)
def test_no_command_prints_the_database_password(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, command: list[str], url: str
) -> None:
    tiny.write(tmp_path / "data")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_bytes(b"")
    assert cli.main([*command, "--data", "data", "--journal", url]) == 1
    said = capsys.readouterr()
    assert said.err.startswith("arramon-server: ")
    assert "hunter2" not in said.out + said.err


def test_usage_errors_mask_what_was_typed(capsys: pytest.CaptureFixture[str]) -> None:
    for typed in (["config", "--jornal", "postgresql://u:hunter2@db/x"], ["token", "list", "password=hunter2"]):
        with pytest.raises(SystemExit):
            cli.main(typed)
        assert "hunter2" not in capsys.readouterr().err


def run(data: Path, *arguments: str, **variables: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "arramon_server", *arguments, "--data", str(data)]
    environment = {**os.environ, **variables}
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=240, check=False)


def test_printed_configuration_can_be_loaded_as_a_file(tmp_path: Path) -> None:
    config = Config(**{name: value for name, (_, value) in EVERYTHING.items() if name != "journal"})
    file = tmp_path / "a.toml"
    for each in (config, Config()):
        file.write_text(as_toml(ResolvedSettings(each, {})))
        assert load(file=file).config == each
    assert tomllib.loads(as_toml(ResolvedSettings(config, {})))["image_sizes"] == [64, 32]


def test_documented_settings_table_matches_the_code() -> None:
    text = (ROOT / "docs" / "reference" / "configuration.md").read_text()
    assert as_table() in text, "renew it with: arramon-server config --table"
    assert text.count("\n| `") == len(EVERYTHING)


def test_serve_reports_invalid_settings_before_starting(tmp_path: Path) -> None:
    done = run(tmp_path, "serve", ARRAMON_STEP="3")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == "arramon-server: $ARRAMON_STEP: there is no setting 'step'; did you mean 'steps'?\n"


def test_workers_get_the_same_settings(tmp_path: Path) -> None:
    """The step limit of the runs that each worker makes is that of the file, which only the parent has read."""
    tiny.write(tmp_path)
    file = tmp_path / "a.toml"
    some = "steps = 17\nworkers = 2\nimage_sizes = [64]\nmax_episodes_per_stream = 5\n"
    file.write_text(f'{some}camera = "{ANY_CAMERA}"')
    server = Server(tmp_path, "127.0.0.1:0", "--config", str(file))
    try:
        with connect(server.address) as found:
            addresses = list(found.info.addresses)
        assert len(addresses) == 2
        for address in addresses:
            with connect(address) as worker:
                assert worker.info.limits.steps_per_phase == 17
                assert (list(worker.info.image_sizes), worker.info.max_episodes_per_stream) == ([64], 5)
    finally:
        assert server.stop() == 0


@pytest.mark.parametrize(
    ("address", "loopback"),
    [
        ("unix:/run/a", True),
        ("127.0.0.1:1", True),
        ("localhost:1", True),
        ("[::1]:1", True),
        ("10.1.2.3:1", False),
        ("0.0.0.0:1", False),
        ("[::]:1", False),
        ("8.8.8.8:1", False),
    ],
)
def test_loopback_addresses_are_recognised(address: str, loopback: bool) -> None:
    assert is_loopback(address) == loopback
