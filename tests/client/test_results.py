"""The score table and the results file."""

import json
from pathlib import Path

import pytest
from rich.console import Console

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client import AgentError, AgentFailure, OutputError, UsageError
from arramon_client.plugin.agent_calls import run_report
from arramon_client.results import check_output, reported_cost, score_table, write_results
from tests.client.fake import METRICS, RUN


@pytest.fixture
def report() -> pb.Report:
    rows = [
        pb.Row(
            name=name,
            scores=[
                pb.Score(metric=m, mean=(i + 1) / 10, low=i / 10, high=(i + 2) / 10) for i, m in enumerate(METRICS)
            ],
        )
        for name in ("turn 1", "turn 2", "total")
    ]
    run = pb.Run(
        run_id=RUN, agent="vl", split="val_seen", language="hi", episodes=2, steps=31, state=pb.RUN_STATE_COMPLETE
    )
    turns = [pb.Row(name="turn 1", scores=[pb.Score(metric="nDTW", mean=0.5, low=0.5, high=0.5)])]
    episode = pb.EpisodeScores(episode_id="e1", cause=types_pb2.CAUSE_STEP_LIMIT, turns=turns, steps=31)
    return pb.Report(run=run, signature="arramon 0.1.0 | val_seen | hi", rows=rows, episodes=[episode])


def rendered(report: pb.Report, width: int) -> str:
    console = Console(width=width, color_system=None)
    with console.capture() as capture:
        console.print(score_table(report))
    return capture.get()


@pytest.mark.parametrize("width", [80, 100])
def test_score_table_has_the_papers_columns_and_fits_the_width(report: pb.Report, width: int) -> None:
    lines = rendered(report, width).splitlines()
    table = "\n".join(lines)
    assert "…" not in table
    assert "vl on val_seen, hi, 2 episodes" in table
    heads = next(i for i, line in enumerate(lines) if "nDTW" in line)
    assert lines[heads - 1].split() == ["CTC"] * 4
    assert lines[heads].split() == ["nDTW", "k=0", "k=3", "k=5", "k=7", "rPOD", "PTC"]
    total = next(i for i, line in enumerate(lines) if line.split()[:1] == ["total"])
    assert lines[total].split() == ["total", "0.100", "0.200", "0.300", "0.400", "0.500", "0.600", "0.700"]
    assert lines[total + 1].split() == [
        ".000-.200", ".100-.300", ".200-.400", ".300-.500", ".400-.600", ".500-.700", ".600-.800",
    ]  # fmt: skip
    assert [line.split()[0:2] for line in lines if line.lstrip().startswith("turn")] == [["turn", "1"], ["turn", "2"]]


def test_the_widest_scores_fit_a_hundred_characters(report: pb.Report) -> None:
    for row in report.rows:
        for score in row.scores:
            score.mean = score.low = score.high = 1.0
    assert rendered(report, 100).count("1.000-1.000") == 21


def test_a_missing_score_is_a_dash(report: pb.Report) -> None:
    del report.rows[2].scores[:]
    total = next(line for line in rendered(report, 100).splitlines() if line.split()[:1] == ["total"])
    assert total.split() == ["total"] + ["-"] * 7


def test_results_file_holds_run_scores_and_failures(report: pb.Report, tmp_path: Path) -> None:
    failure = AgentFailure(("e1",), "act() raised ValueError: नहीं", "Traceback ...")
    path = write_results(report, [failure], tmp_path)
    assert path == tmp_path / f"{RUN}.json"
    assert [entry.name for entry in tmp_path.iterdir()] == [f"{RUN}.json"]
    content = json.loads(path.read_text(encoding="utf-8"))
    assert content["format"] == 1
    assert content["signature"] == "arramon 0.1.0 | val_seen | hi"
    assert (content["run"]["run_id"], content["run"]["steps"], content["run"]["state"]) == (
        RUN, 31, "RUN_STATE_COMPLETE",
    )  # fmt: skip
    assert content["table"][2] == {
        "row": "total", "nDTW": 0.1, "CTC-0": 0.2, "CTC-3": 0.3, "CTC-5": 0.4, "CTC-7": 0.5,
        "rPOD@CTC-3": 0.6, "PTC@CTC-3": 0.7,
    }  # fmt: skip
    assert content["metrics"]["turn 1"]["PTC"] == {"mean": 0.9, "low": 0.8, "high": 1.0}
    assert content["episodes"] == [
        {"episode_id": "e1", "cause": "STEP_LIMIT", "steps": 31, "turns": {"turn 1": {"nDTW": 0.5}}}
    ]
    assert content["agent_failures"] == [
        {"episodes": ["e1"], "message": "act() raised ValueError: नहीं", "details": "Traceback ..."}
    ]


def test_an_existing_file_is_replaced_atomically(report: pb.Report, tmp_path: Path) -> None:
    (tmp_path / f"{RUN}.json").write_text("x" * 100_000)
    json.loads(write_results(report, [], tmp_path).read_text())


def test_an_output_folder_is_created(tmp_path: Path) -> None:
    check_output(tmp_path / "a" / "b")
    assert list((tmp_path / "a" / "b").iterdir()) == []


@pytest.mark.parametrize("folder", ["file", "file/below", "/proc/arramon"])
def test_unwritable_output_folder_is_reported(tmp_path: Path, folder: str) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="results cannot be written to"):
        check_output(tmp_path / folder)


def reports(content: object) -> object:
    """An agent that reports this, or raises it."""

    class Agent:
        def run_report(self) -> object:
            if isinstance(content, Exception):
                raise content
            return content

    return Agent()


def test_the_agents_report_is_kept(report: pb.Report, tmp_path: Path) -> None:
    """Also if the run was over before, so that the agent has nothing to say."""
    path = write_results(report, (), tmp_path, {}, run_report(reports({"calls": 3})))
    assert json.loads(path.read_text())["agent_report"] == {"calls": 3}
    write_results(report, (), tmp_path, {}, run_report(object()))
    assert json.loads(path.read_text())["agent_report"] == {"calls": 3}
    path.unlink()
    assert "agent_report" not in json.loads(write_results(report, (), tmp_path).read_text())


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (["calls"], "run_report() returned list ['calls']; expected a mapping that JSON can hold"),
        ({"calls": {3}}, "run_report() returned dict"),
        ({"calls": float("nan")}, "expected a mapping that JSON can hold"),
        (KeyError("calls"), "run_report() raised KeyError: 'calls'"),
    ],
)
def test_a_report_that_cannot_be_kept(content: object, said: str) -> None:
    with pytest.raises(AgentError) as caught:
        run_report(reports(content))
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("content", "cost"),
    [
        ({"measured": {"tokens": {"total": 5}}, "declared": {"price_usd": 0.5}}, (5, 0.5)),
        ({"measured": {"tokens": {"total": None}}, "declared": {"price_usd": None}}, (None, None)),
        ({"measured": {"tokens": {"total": "5"}}, "declared": {"price_usd": -1}}, (None, None)),
        ({"measured": 3}, (None, None)),
    ],
)
def test_the_reported_cost(report: pb.Report, tmp_path: Path, content: dict[str, object], cost: object) -> None:
    path = write_results(report, (), tmp_path, {}, content)
    assert reported_cost(path, RUN) == cost
    with pytest.raises(UsageError, match="is not the results file of run other"):
        reported_cost(path, "other")
    path.write_text("{")
    with pytest.raises(UsageError, match="is not JSON, or was truncated"):
        reported_cost(path, RUN)
    with pytest.raises(UsageError, match="cannot be read: No such file"):
        reported_cost(tmp_path / "nowhere.json", RUN)
