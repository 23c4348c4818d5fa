"""`--lang en,hi`: one run in each language, both tables, and the gap."""

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import cast

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client import arguments
from arramon_client.cli import main
from arramon_client.commands.play import PlayCommand
from arramon_client.errors import UsageError
from arramon_client.language_gap import INTERVALS, NO_INTERVALS, gap_table, gaps
from arramon_client.transport.connection import Server as Connected
from tests import tiny
from tests.serving import Server

AGENT = """
import os
class Agent:
    sensors = ()
    def __init__(self, beam=1): self.language = {}
    def begin(self, episode):
        if os.environ.get("STOP_IN") == episode.language: raise KeyboardInterrupt
        self.language[episode.episode_id] = episode.language
    def act(self, observations):
        return [3 if self.language[each.episode_id] == "hi" else each.step % 4 for each in observations]
"""


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    data = tmp_path_factory.mktemp("data")
    tiny.write(data)
    server = Server(data, "127.0.0.1:0")
    yield server
    assert server.stop() == 0


@pytest.fixture
def command(server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    (tmp_path / "both.py").write_text(AGENT)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    return ["--agent", "both.py", "--lang", "en,hi", "--server", server.address, "--quiet"]


def files() -> list[str]:
    return sorted(path.name for path in Path("arramon-results").iterdir() if path.is_file())


def test_both_tables_and_the_gap_are_printed(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(command) == 0
    shown = capsys.readouterr()
    assert "on tiny, en, " in shown.out
    assert "on tiny, hi, " in shown.out
    assert shown.out.index("on tiny, hi, ") < shown.out.index("gap between languages") < shown.out.index("en minus hi")
    assert NO_INTERVALS in shown.out
    assert shown.out.count("results: ") == shown.out.count("receipt: ") == 2
    assert len(files()) == 4
    assert main(["verify", *(f"arramon-results/{name}" for name in files() if "receipt" in name), *command[4:6]]) == 0
    assert capsys.readouterr().out.count("signed with the key of") == 2


def test_json_has_both_runs_and_the_gaps(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*command, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    first, second = content["runs"]
    assert (first["run"]["language"], second["run"]["language"]) == ("en", "hi")
    gap = next(each for each in content["gaps"] if each["metric"] == "nDTW")
    difference = first["metrics"]["total"]["nDTW"]["mean"] - second["metrics"]["total"]["nDTW"]["mean"]
    assert (gap["first"], gap["second"]) == ("en", "hi")
    assert gap["difference"] == pytest.approx(difference)
    assert gap["difference"] != 0


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize(("stopped", "runs", "saved"), [("en", 1, 0), ("hi", 2, 2)])
def test_what_was_stopped_in_either_language_is_resumed(
    command: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, stopped: str, runs: int,
    saved: int,
) -> None:  # fmt: skip
    monkeypatch.setenv("STOP_IN", stopped)
    assert main(command) == 130
    said = capsys.readouterr().err
    assert len(files()) == saved
    (resume,) = (line for line in said.splitlines() if "--resume" in line)
    ids = resume.split()[-1]
    assert len(ids.split(",")) == runs
    monkeypatch.delenv("STOP_IN")
    assert main(resume.split()[1:]) == 0
    shown = capsys.readouterr()
    assert "gap between languages" in shown.out
    assert {f"{each}.json" for each in ids.split(",")} <= set(files())
    assert len(files()) == 4


def ids_to_resume(said: str) -> list[str]:
    (resume,) = (line for line in said.splitlines() if "--resume" in line)
    return resume.split()[-1].split(",")


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("with_languages", [True, False])
def test_a_run_that_is_still_to_be_resumed_is_not_forgotten(
    command: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *, with_languages: bool
) -> None:
    """Resumed with both, and stopped while the first is played: pasted, the hint must not create a second run."""
    created = []
    for language in ("en", "hi"):
        monkeypatch.setenv("STOP_IN", language)
        assert main([*command[:2], "--lang", language, *command[4:]]) == 130
        created += ids_to_resume(capsys.readouterr().err)
    monkeypatch.setenv("STOP_IN", "en")
    both = command if with_languages else [*command[:2], *command[4:]]
    assert main([*both, "--resume", ",".join(created)]) == 130
    assert ids_to_resume(capsys.readouterr().err) == created
    monkeypatch.delenv("STOP_IN")
    assert main([*both, "--resume", ",".join(created)]) == 0
    assert "gap between languages" in capsys.readouterr().out


@pytest.mark.usefixtures("interruptible")
def test_all_runs_are_checked_before_any_is_played(
    command: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    created = []
    for language, argument in (("en", []), ("hi", ["--agent-arg", "beam=4"])):
        monkeypatch.setenv("STOP_IN", language)
        assert main([*command[:2], "--lang", language, *command[4:], *argument]) == 130
        created += ids_to_resume(capsys.readouterr().err)
    monkeypatch.delenv("STOP_IN")
    assert main([*command, "--resume", ",".join(created)]) == 2
    said = capsys.readouterr().err
    assert f"run {created[1]} was started with --agent-arg beam=4, not with no --agent-arg" in said
    assert "resume" not in said
    assert files() == []


def test_runs_of_two_splits_are_not_resumed_together() -> None:
    argv = ["--agent", "both.py", "--resume", f"{'1a' * 16},{'2b' * 16}", "--server", "nowhere:1"]
    command = PlayCommand(arguments.parse(argv), argv)
    runs = [pb.Run(run_id="1a" * 16, language="en", split="seen"), pb.Run(run_id="2b" * 16, language="hi", split="new")]
    with pytest.raises(UsageError, match="are of different splits, seen, new: resume them one by one"):
        command._languages(cast("Connected", None), runs)


def test_a_dry_run_plays_both(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*command, "--dry-run"]) == 0
    shown = capsys.readouterr()
    assert shown.out.count("2 episodes") == 2
    assert shown.err.count("this was a dry run: no errors") == 1


@pytest.mark.parametrize(("languages", "said"), [
    ("en,fr", "error: the server has no language 'fr'; it has en, hi"),
    ("fr,en", "error: the server has no language 'fr'; it has en, hi"),
])  # fmt: skip
def test_no_run_is_created_unless_all_languages_are_there(
    command: list[str], capsys: pytest.CaptureFixture[str], languages: str, said: str
) -> None:
    command[3] = languages
    assert main(command) == 2
    assert said in capsys.readouterr().err
    assert list(Path("arramon-results").iterdir()) == []


def report(language: str, scores: dict[str, float]) -> pb.Report:
    made = pb.Report(run=pb.Run(language=language))
    mean = sum(scores.values()) / len(scores)
    made.rows.add(name="total").scores.add(metric="nDTW", mean=mean)
    for episode_id, value in scores.items():
        episode = made.episodes.add(episode_id=episode_id)
        for turn in ("turn 1", "turn 2"):
            episode.turns.add(name=turn).scores.add(metric="nDTW", mean=value)
    return made


def test_the_interval_is_paired_by_episode() -> None:
    """Student's interval of the differences, here of ten: 2.262 standard errors."""
    first = {f"e{i}": 0.1 * (i % 10) for i in range(10)}
    second = {name: value - (0.02 if int(name[1:]) % 2 else 0.04) for name, value in first.items()}
    (gap,) = gaps(report("en", first), report("hi", second))
    assert gap.difference == pytest.approx(0.03)
    assert gap.low == pytest.approx(0.03 - 2.262 * 0.010541 / 10**0.5, abs=1e-4)
    assert gap.high == pytest.approx(0.03 + 2.262 * 0.010541 / 10**0.5, abs=1e-4)
    few = {name: first[name] for name in list(first)[:9]}
    (gap,) = gaps(report("en", few), report("hi", few))
    assert (gap.difference, gap.low, gap.high) == (0, None, None)


@pytest.mark.parametrize(("episodes", "caption"), [(10, INTERVALS), (9, NO_INTERVALS)])
def test_the_caption_names_intervals_only_where_there_are_some(episodes: int, caption: str) -> None:
    scores = {f"e{i}": 0.1 * i for i in range(episodes)}
    assert gap_table([report("en", scores), report("hi", scores)]).caption == caption
