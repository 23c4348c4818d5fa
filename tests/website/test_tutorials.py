"""The tutorials: their commands work, from the first to the last, and lead to what the page says."""

import json
from pathlib import Path

import pytest

from tests.website import tutorial

PAGES = sorted(path.stem for path in tutorial.TUTORIALS.glob("*.md") if path.stem != "index")


def followed(name: str, folder: Path) -> str:
    return tutorial.follow(tutorial.TUTORIALS / f"{name}.md", folder)


def test_every_tutorial_has_a_test_and_a_line_in_the_list() -> None:
    tests = {name.removeprefix("test_").replace("_", "-") for name in globals() if name.startswith("test_")}
    assert set(PAGES) <= tests
    listed = (tutorial.TUTORIALS / "index.md").read_text(encoding="utf-8")
    assert [name for name in PAGES if f"]({name}.md)" not in listed] == []


@pytest.mark.parametrize("name", PAGES)
def test_a_tutorial_has_commands_and_says_where_to_go_next(name: str) -> None:
    page = tutorial.TUTORIALS / f"{name}.md"
    assert [step.kind for step in tutorial.steps(page)].count("run") >= 3
    assert "\n## Next\n" in page.read_text(encoding="utf-8")


ACTIVATE = "```sh\n. .venv/bin/activate\n```\n"
SERVE = '```sh title="Terminal 1: leave it running"\necho listening on nothing\nsleep 600\n```\n'
USE = "```sh\narramon-client --help\n```\n"


def second(block: str) -> str:
    return block.replace("```sh", '```sh title="Terminal 2"', 1)


def follow_text(text: str, folder: Path) -> str:
    folder.mkdir(exist_ok=True)
    page = folder / "page.md"
    page.write_text(text)
    return tutorial.follow(page, folder)


def test_a_terminal_keeps_its_variables(tmp_path: Path) -> None:
    text = (
        ACTIVATE + "```sh\nsaid=hello\n```\n" + SERVE + second(ACTIVATE) + '```sh\necho "${said-nothing}"\n```\n' + USE
    )
    printed = follow_text(text, tmp_path)
    assert "\nnothing\n" in f"\n{printed}"
    assert "usage: arramon-client" in printed
    assert "hello\n" in follow_text("```sh\nsaid=hello\n```\n```sh\necho $said\n```\n", tmp_path / "other")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (USE, "arramon-client: command not found"),
        (ACTIVATE + SERVE + second(USE), "arramon-client: command not found"),
        (ACTIVATE + SERVE + USE, "terminal 1 is busy"),
        (ACTIVATE + "```sh\nfalse\n```\n" + USE, "false"),
        (SERVE.replace("sleep 600", "").replace("listening on nothing", "no"), "no"),
        (USE.replace("```sh", '```sh title="Window 1"'), "the title 'Window 1' names no terminal"),
    ],
)
def test_a_reader_who_cannot_go_on_is_noticed(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(AssertionError, match=said):
        follow_text(text, tmp_path)


@pytest.mark.slow
def test_play_an_agent(tmp_path: Path) -> None:
    pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")
    printed = followed("play-an-agent", tmp_path)
    assert "split sample (open): 24 in en, 24 in hi; 2 sections; data " in printed
    for title in ("random_walk on sample, en, 4 episodes", "vl on sample: gap between languages"):
        assert title in printed
    assert len(list((tmp_path / "arramon-results").glob("*.receipt.json"))) == 3


def _places(recording: Path) -> dict[tuple[str, int], int]:
    """Return the number of different places that a recorded run was at in the street, by episode and turn."""
    places: dict[tuple[str, int], set[tuple[float, float]]] = {}
    for file in recording.glob("*/steps.jsonl"):
        for line in file.read_text(encoding="utf-8").splitlines():
            step = json.loads(line)
            if step["phase"] == "navigation":
                x, z, _ = step["pose"]
                places.setdefault((file.parent.name, step["turn"]), set()).add((x, z))
    return {walk: len(its) for walk, its in places.items()}


@pytest.mark.slow
def test_write_an_agent(tmp_path: Path) -> None:
    printed = followed("write-an-agent", tmp_path)
    assert " begins, in en\n" in printed
    assert "my_agent on sample, hi, 2 episodes" in printed
    blind, *seeing = [
        _places(run) for name in ("first", "second") for run in (tmp_path / name).iterdir() if run.is_dir()
    ]
    assert len(seeing) == 2
    for run in seeing:
        assert run.keys() == blind.keys()
        assert all(run[walk] > max(60, 2 * blind[walk]) for walk in run), (blind, run)


@pytest.mark.slow
def test_language_model(tmp_path: Path) -> None:
    pytest.importorskip("openai", reason="the extra `vlm` is not installed: scripts/setup")
    printed = followed("language-model", tmp_path)
    assert "agents.vlm: " in printed
    (trace,) = (tmp_path / "arramon-results").glob("*.vlm.jsonl")
    assert len([json.loads(line) for line in trace.read_text(encoding="utf-8").splitlines()]) > 10


@pytest.mark.slow
def test_train_an_agent(tmp_path: Path) -> None:
    pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")
    with tutorial.reader(tmp_path / "reader") as folder:
        folder.mkdir()
        printed = followed("train-an-agent", folder)
        assert (folder / "arramon-weights" / "smoke" / "vl.safetensors").exists()
    assert "vl on val_seen, hi, 1 episode " in printed


@pytest.mark.slow
def test_host_a_leaderboard(tmp_path: Path) -> None:
    printed = followed("host-a-leaderboard", tmp_path)
    run = next((tmp_path / "arramon-results").glob("*.receipt.json")).name.partition(".")[0]
    assert f"run {run} of Lab One, complete\n" in printed
    assert "It was NOT checked that this is the host's key" not in printed
