"""The trace: what a kill leaves is read again, a full disk stops paying, and one process at a time writes it."""

import asyncio
import errno
import json
import os
import stat
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from arramon_agents.vlm import make_agent
from arramon_agents.vlm.trace import CallTrace
from arramon_client.errors import StopRun
from benchmarks.agents.fake_endpoint import FakeEndpoint, Response, plan
from tests.agents.vlm import helpers
from tests.agents.vlm.conftest import MakeAgent


def test_records_come_back_and_an_incomplete_line_is_removed(tmp_path: Path) -> None:
    path = tmp_path / "r.vlm.jsonl"
    trace = CallTrace(path)
    assert trace.write({"kind": "call", "said": "मग\n"})
    trace.close()
    with path.open("ab") as file:
        file.write(b'{"kind": "ca')
    trace = CallTrace(path)
    assert trace.records == [{"kind": "call", "said": "मग\n"}]
    assert trace.write({"kind": "more"})
    trace.close()
    assert [json.loads(line)["kind"] for line in path.read_text().splitlines()] == ["call", "more"]


@pytest.mark.parametrize(
    ("content", "message"),
    [(b"{}\nhello\n{}\n", "line 2 is not JSON"), (b"[]\n", "line 1 is not an object")],
)
def test_another_file_is_left_as_it_is(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "r.vlm.jsonl"
    path.write_bytes(content)
    with pytest.raises(StopRun, match=message):
        CallTrace(path)
    assert path.read_bytes() == content


def test_others_cannot_read_a_new_trace(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        CallTrace(tmp_path / "r.vlm.jsonl").close()
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "r.vlm.jsonl").stat().st_mode) == 0o600


def test_two_processes_cannot_write_one_trace(tmp_path: Path) -> None:
    first = CallTrace(tmp_path / "r.vlm.jsonl")
    with pytest.raises(StopRun, match=r"another process plays this run and writes .*--agent-arg trace=DIR"):
        CallTrace(tmp_path / "r.vlm.jsonl")
    CallTrace(tmp_path / "other.vlm.jsonl").close()
    first.close()
    CallTrace(tmp_path / "r.vlm.jsonl").close()


def test_a_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "r.vlm.jsonl").mkdir()
    with pytest.raises(StopRun, match="cannot be written: Is a directory"):
        CallTrace(tmp_path / "r.vlm.jsonl")


def fill(monkeypatch: pytest.MonkeyPatch, after: int) -> None:
    """The disk is full after so many more bytes."""
    left = after
    write = os.write

    def full(file: int, data: bytes) -> int:
        nonlocal left
        if left <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        done = write(file, data[:left])
        left -= done
        return done

    monkeypatch.setattr("arramon_agents.vlm.trace.os.write", full)


def test_a_full_disk_uses_the_paid_answer_and_pays_no_further_one(
    made: MakeAgent, fake: FakeEndpoint, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake.behaviour = helpers.always("forward", "left")
    notes: list[Any] = []

    async def play() -> None:
        async with helpers.playing(made()) as agent:
            with monkeypatch.context() as patch:
                fill(patch, 100)
                notes.append(await helpers.note_of(agent, helpers.seen(0)))
                assert await agent.act(helpers.seen(1)) == 1
                with pytest.raises(StopRun, match=r"No space left on device\. No further call was made; make room"):
                    await agent.act(helpers.seen(2))
                assert len(fake.requests) == 1
            with pytest.raises(StopRun):  # It stays stopped until the run is resumed.
                await agent.act(helpers.seen(2))

    asyncio.run(play())
    lines = (tmp_path / "r.vlm.jsonl").read_text().splitlines()
    assert [json.loads(line)["kind"] for line in lines] == ["start"]

    async def resume() -> int:
        async with helpers.playing(made()) as agent:
            agent.replay(helpers.seen(0, taken=0, taken_note=json.dumps(notes[0])), 0)
            return await helpers.action_of(agent, helpers.seen(1))

    assert asyncio.run(resume()) == 1
    assert len(fake.requests) == 1


def test_a_line_that_is_lost_is_not_forgotten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A shorter line may fit on the disk after it."""
    trace = CallTrace(tmp_path / "r.vlm.jsonl")
    with monkeypatch.context() as patch:
        fill(patch, 10)
        assert not trace.write({"kind": "call", "answer": "x" * 100})
    assert trace.write({"kind": "end"})
    with pytest.raises(StopRun, match="No space left on device"):
        trace.check()
    trace.close()


@pytest.mark.parametrize("named", [True, False])
def test_the_folder_of_the_trace(
    named: bool, fake: FakeEndpoint, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The argument, or else the folder of the run's results, or else the default one."""
    monkeypatch.chdir(tmp_path)
    argument: dict[str, Any] = {"trace": "named"} if named else {}
    folders = []
    for output in (Path("results"), None):
        agent = make_agent(model="m", endpoint=fake.url, sight="skip", **argument)
        run: Any = SimpleNamespace(run_id="r", language="en", sensors=agent.sensors, output=output, steps=0)
        asyncio.run(agent.open(run))
        asyncio.run(agent.close())
        folders.append(str(Path(agent.run_report()["trace"]).parent))
        assert agent.run_summary() == (
            f"agents.vlm: 0 calls, 0 tokens read, 0 written, cost unknown: no prices; trace: {folders[-1]}/r.vlm.jsonl"
        )
    assert folders == (["named", "named"] if named else ["results", "arramon-results"])


def test_a_resumed_run_without_its_trace_is_reported(
    made: MakeAgent, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async def play(steps: int) -> None:
        async with helpers.playing(made(), steps=steps):
            pass

    asyncio.run(play(0))
    asyncio.run(play(5))
    assert not caplog.messages
    (tmp_path / "r.vlm.jsonl").unlink()
    asyncio.run(play(5))
    assert "r.vlm.jsonl has no calls of the run's 5 earlier steps: usage and limits count from here" in caplog.text


def test_what_the_trace_holds(made: MakeAgent, fake: FakeEndpoint, tmp_path: Path) -> None:
    async def play() -> None:
        async with helpers.playing(made()) as agent:
            await agent.act(helpers.seen(0))

    asyncio.run(play())
    start, call = map(json.loads, (tmp_path / "r.vlm.jsonl").read_text().splitlines())
    assert {"kind": "start", "run": "r", "language": "en", "model": "m", "seed": "none"}.items() <= start.items()
    expected = {"purpose": "act", "episode": "e", "step": 0, "finish": "stop", "unusable": "", "attempts": 1}
    assert expected.items() <= call.items()
    assert call["tokens"].keys() == {"prompt", "completion", "cached"}
    image = call["messages"][-1]["content"][1]["image_url"]
    assert image["frame"] == "e/0"
    assert len(image["sha256"]) == len(call["prompt"]) == 16
    assert "base64" not in json.dumps(call)


def test_an_answer_to_a_cancelled_call_is_kept(made: MakeAgent, fake: FakeEndpoint) -> None:
    """A client that stops in order loses nothing that it has asked for."""
    fake.behaviour = lambda request, _: Response(plan(request, ["left"]).body, delay=0.2)

    async def cancelled() -> None:
        async with helpers.playing(made()) as agent:
            call = asyncio.create_task(agent.act(helpers.seen(0)))
            while not fake.requests:
                await asyncio.sleep(0.01)
            call.cancel()

    async def resumed() -> int:
        async with helpers.playing(made()) as agent:
            return await helpers.action_of(agent, helpers.seen(0))

    asyncio.run(cancelled())
    assert asyncio.run(resumed()) == 1
    assert len(fake.requests) == 1
