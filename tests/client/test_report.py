"""The command `report` on a real server: open and hidden splits, published runs and others."""

import json
from collections.abc import Iterator
from contextlib import ExitStack, closing

import grpc
import numpy as np
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client.cli import main
from arramon_client.commands.report import plot
from arramon_server.runs.accounts.callers import HOST, Role
from arramon_server.scoring.disclosure import MIN_EPISODES
from tests import demanding
from tests.api.people import Person, token_of
from tests.api.test_runs import refused
from tests.board.leaderboard_backend import LeaderboardBackend
from tests.serving import METADATA, Server

OPEN, SECRET, PRIVATE, PLAIN, WITHDRAWN, NOBODYS, NOBODYS_WITHDRAWN = (letter * 32 for letter in "abcdef0")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    data = tmp_path_factory.mktemp("data")
    backend = LeaderboardBackend(data)
    with closing(backend.database):
        backend.splits["open"] = demanding.written(data, "open", 30)
        backend.splits["guarded"] = demanding.written(data, "guarded", 120, hidden=True)
        draw = np.random.default_rng(0)
        for run_id, split, number in ((OPEN, "open", 30), (SECRET, "guarded", 120)):
            backend.run(run_id, draw.integers(0, 2, number).astype(float).tolist(), split=split, agent="<walker>")
        backend.run(PLAIN, 0.5)
        backend.participant("bob")
        backend.run(PRIVATE, 1.0, split="guarded", account="bob", participant="bob")
        backend.run(WITHDRAWN, 1.0, split="guarded", account="bob", participant="bob")
        for run_id in (NOBODYS, NOBODYS_WITHDRAWN):
            backend.run(run_id, 1.0, split="open")
        for run_id in (OPEN, SECRET, PLAIN, WITHDRAWN, NOBODYS_WITHDRAWN):
            backend.publish(run_id)
        for run_id in (WITHDRAWN, NOBODYS_WITHDRAWN):
            backend.publisher.withdraw(HOST, run_id)
    server = Server(data, "127.0.0.1:0", "--no-anonymous")
    yield server
    assert server.stop() == 0


def test_a_run_by_what_the_turns_ask_for(server: Server, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", OPEN, "--server", server.address]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["moves", "forward", "on", "the", "right", "path"] in lines
    (first,) = (line for line in lines if line[:1] == ["first"])
    assert first[1] == "30"
    assert len(first) == 2 + 2 * 5  # five scores with their intervals
    assert any(line[:3] == ["turn", "at", "a"] for line in lines)


def test_runs_beside_each_other_with_a_plot(server: Server, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", OPEN, OPEN, "--metric", "nDTW", "--server", server.address]) == 0
    shown = capsys.readouterr().out
    (first,) = (line for line in shown.splitlines() if line.strip().startswith("first "))
    assert first.count("|") == 4
    assert first.count("o") == 2
    assert main(["report", OPEN, SECRET, "--server", server.address]) == 2
    assert "the runs are on different splits: guarded, open" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("score", "line"), [((0.5, 0.0, 1.0), "-" * 12 + "o" + "-" * 11), ((0.0, 0.0, 0.0), "o" + " " * 23)]
)
def test_plots_are_from_0_to_1(score: tuple[float, float, float], line: str) -> None:
    mean, low, high = score
    assert plot(pb.Score(mean=mean, low=low, high=high)) == f"|{line}|"


def test_hidden_split_shows_large_groups_with_rounded_scores(
    server: Server, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["report", SECRET, "--server", server.address]) == 0
    said = capsys.readouterr().out
    assert "scores are rounded, and no combination of groups is about fewer than 20 episodes" in said
    assert "groups are left out" in said
    assert main(["report", SECRET, "--json", "--server", server.address]) == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert (found["rounded"], found["reads"], found["run_id"]) == (True, True, SECRET)
    assert found["withheld"] > 10
    assert len(found["groups"]) > 5
    for group in found["groups"]:
        assert group["episodes"] >= MIN_EPISODES
        for score in group["scores"].values():
            assert score["mean"] * 100 == pytest.approx(round(score["mean"] * 100))


def test_missing_groups_are_explained(server: Server, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", PLAIN, "--server", server.address]) == 0
    assert "a host can run `arramon-server demands`" in capsys.readouterr().out


@pytest.fixture(scope="module")
def people(server: Server) -> Iterator[dict[str, Person]]:
    """Callers with a token, and one without, of the server that requires one; and one of a server that does not."""
    tokens = {name: token_of(server.data, name) for name in ("ann", "bob")}
    tokens |= {"chair": token_of(server.data, "chair", Role.HOST), "nobody": ""}
    anonymous = Server(server.data, "127.0.0.1:0", "--trust-proxy", "--anonymous")
    with ExitStack() as stack:
        found = {name: stack.enter_context(Person(server.address, token)) for name, token in tokens.items()}
        yield found | {"anybody": stack.enter_context(Person(anonymous.address))}
    assert anonymous.stop() == 0


READERS = {
    "published": (SECRET, {"ann", "bob", "chair", "nobody", "anybody"}),
    "somebody's": (PRIVATE, {"bob", "chair"}),
    "withdrawn": (WITHDRAWN, {"bob", "chair"}),
    "without an owner": (NOBODYS, {"chair", "anybody"}),
    "without an owner, withdrawn": (NOBODYS_WITHDRAWN, {"chair", "anybody"}),
}


@pytest.mark.parametrize("kind", READERS)
@pytest.mark.parametrize("who", ["ann", "bob", "chair", "nobody", "anybody"])
def test_published_runs_are_open_to_everyone_and_others_to_those_who_may_see_them(
    people: dict[str, Person], kind: str, who: str
) -> None:
    (run_id, readers), stub = READERS[kind], people[who].stub
    request = pb.GetBreakdownRequest(run_id=run_id)
    if who in readers:
        assert stub.GetBreakdown(request, metadata=METADATA).groups
        return
    assert refused(lambda: stub.GetBreakdown(request, metadata=METADATA)) == (
        grpc.StatusCode.NOT_FOUND,
        f"there is no run {run_id!r}",
    )
