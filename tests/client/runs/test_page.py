"""The page docs/how-to/runs.md: its program runs, and its names exist."""

import re

import pytest

from arramon_client import AsyncRun, AsyncRunEpisode, Run, RunEpisode
from arramon_client.runs import live_episode
from tests import ROOT
from tests.client.fake import Servicer, World, serving

PAGE = (ROOT / "docs" / "how-to" / "runs.md").read_text(encoding="utf-8")


def test_its_program_plays_a_run(world: World, capsys: pytest.CaptureFixture[str]) -> None:
    program = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)[0]
    with serving(Servicer(world)) as address:
        exec(program.replace('language="en"', f'language="en", server="{address}"'), {})
    assert world.actions == {f"e{number}": [0] * 5 for number in range(4)}
    assert set(world.notes.values()) == {"nothing in the way"}
    assert capsys.readouterr().out.startswith("e0 AGENT_FINISHED\n")


def test_its_names_exist() -> None:
    table = PAGE.partition("`parallel` is 1")[0]
    for name in re.findall(r"`run\.(\w+)", table):
        assert hasattr(Run, name)
        assert hasattr(AsyncRun, name)
    for name in re.findall(r"`episode\.(\w+)", table):
        assert hasattr(RunEpisode, name)
        assert hasattr(AsyncRunEpisode, name)


def test_it_states_all_reasons_for_which_a_plan_stops() -> None:
    reasons = set(re.findall(r"^\| `([^`]+)` \|", PAGE.partition("## Plans")[2], re.MULTILINE))
    assert reasons == {
        live_episode.BLOCKED, live_episode.NO_PICK_UP, live_episode.PHASE_OVER, live_episode.EPISODE_OVER,
    }  # fmt: skip
