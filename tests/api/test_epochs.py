"""Epochs, reproductions and actions over gRPC and by the client's commands, on a server that requires tokens."""

import json
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from pathlib import Path

import grpc
import pytest

from arramon.v1 import evaluation_pb2
from arramon.v1 import leaderboard_pb2 as pb
from arramon_client.cli import main
from arramon_client.results import COLUMNS
from arramon_server.episodes.epoch_statement import EpochStatement, secret_digest
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.epoch_store import EpochStore
from tests import tiny
from tests.api.people import Person, token_of
from tests.api.player import Player, create, played
from tests.api.test_runs import refused
from tests.serving import METADATA, Server

OLDER, NEWER = "test_unseen_e1", "test_unseen_e2"

CODE = evaluation_pb2.Code(url="https://example.org/walker", commit="c" * 40, image="sha256:" + "d" * 64)

WRONG = [3] * 4
"""Takes nothing, and puts it down at once."""


class Season:
    """A server with two epochs, the participants ann and bob, and somebody without a token."""

    def __init__(self, data: Path, stack: ExitStack) -> None:
        self.data = data
        with self.epochs() as epochs:
            for number, name in enumerate((OLDER, NEWER), start=1):
                split = tiny.write(data, name, 3, hidden=True)
                statement = EpochStatement(
                    split=name, base="test_unseen", sections=("1",), scale=0.1, episodes=3, tried=True, generator="9",
                    sources="5" * 64, data_hash=split.data_hash, secret_sha256=secret_digest(f"{number:064x}"),
                )  # fmt: skip
                epochs.open(name, statement.canonical_json())
        tiny.write(data)
        self.server = Server(data, "127.0.0.1:0", "--steps", "8", "--no-anonymous")
        tokens = {name: token_of(data, name) for name in ("ann", "bob")} | {"nobody": ""}
        people = {name: stack.enter_context(Person(self.server.address, token)) for name, token in tokens.items()}
        self.ann, self.bob, self.nobody = people["ann"], people["bob"], people["nobody"]
        self.token = data / "token"
        self.token.write_text(tokens["bob"])
        self.token.chmod(0o600)

    @property
    def _url(self) -> str:
        return f"sqlite:///{self.data / 'journal.db'}"

    def epochs(self) -> "_Opened":
        return _Opened(self._url)

    def plays(self, who: Person, actions: Sequence[int] = tiny.ACTIONS, **fields: object) -> str:
        """A run that is over."""
        return played(who.stub, actions, **{"split": NEWER, "code": CODE, **fields}).run_id

    def publishes(self, who: Person, run_id: str, reproduces: str | None = None) -> pb.Entry:
        return who.board.Publish(pb.PublishRequest(run_id=run_id, reproduces=reproduces), metadata=METADATA)

    def entry(self, run_id: str) -> pb.Entry:
        return self.nobody.board.GetEntry(pb.GetEntryRequest(run_id=run_id), metadata=METADATA)


class _Opened(closing["Database"]):
    """The epochs in a journal, as the host's command has them."""

    def __init__(self, url: str) -> None:
        super().__init__(Database(url))

    def __enter__(self) -> EpochStore:  # type: ignore[override]
        return EpochStore(super().__enter__())


@pytest.fixture
def season(tmp_path: Path) -> Iterator[Season]:
    with ExitStack() as stack:
        made = Season(tmp_path, stack)
        yield made
    assert made.server.stop() == 0


def test_a_run_is_reproduced_by_another_participant(season: Season, capsys: pytest.CaptureFixture[str]) -> None:
    original = season.plays(season.ann)
    assert season.ann.stub.GetRun(evaluation_pb2.GetRunRequest(run_id=original), metadata=METADATA).code == CODE
    season.publishes(season.ann, original)
    again, own = season.plays(season.bob, WRONG), season.plays(season.ann)
    code, said = refused(lambda: season.publishes(season.ann, own, reproduces=original))
    assert (code, "of the same account" in said) == (grpc.StatusCode.FAILED_PRECONDITION, True)
    code, _ = refused(lambda: season.publishes(season.bob, again, reproduces="0" * 32))
    assert code == grpc.StatusCode.NOT_FOUND
    remote = ("--server", season.server.address, "--token-file", str(season.token))
    assert main(["publish", again, "--reproduces", original, *remote]) == 0
    entry = season.entry(original)
    assert (entry.reproduced_by, [one.run.run_id for one in entry.reproductions]) == (1, [again])
    (found,) = entry.reproductions
    by_metric = {score.metric: score for score in found.differences}
    assert (found.run.participant, len(by_metric)) == ("bob", 7)
    apart = (season.entry(again).rows[2].scores, season.entry(original).rows[2].scores)
    ours, theirs = ({score.metric: score.mean for score in scores} for scores in apart)
    for metric, score in by_metric.items():  # those of the shown means, and of three episodes no interval
        assert score.mean == pytest.approx(ours[metric] - theirs[metric])
        assert (score.low, score.high) == (-1.0, 1.0)
    listed = season.nobody.board.List(pb.ListRequest(split=NEWER, language="en"), metadata=METADATA)
    assert [(line.reproduced_by, list(line.marks), line.rank) for line in listed.standings] == [
        (1, [], 1),
        (0, [pb.MARK_REPRODUCTION], 0),
    ]
    assert season.entry(again).reproduces == original
    capsys.readouterr()
    assert main(["leaderboard", "--reproductions", original, "--server", season.server.address]) == 0
    shown = capsys.readouterr().out
    assert "reproduced by 1" in shown
    assert shown.count("-1.000..") == len(COLUMNS)  # no column is cut off
    season.bob.board.Withdraw(pb.WithdrawRequest(run_id=again), metadata=METADATA)
    assert (season.entry(original).reproduced_by, len(season.entry(original).reproductions)) == (0, 0)


def test_a_season_from_opening_to_rescoring(season: Season, capsys: pytest.CaptureFixture[str]) -> None:
    over = season.plays(season.ann, split=OLDER)
    going = create(season.ann.stub, split=OLDER).run_id
    season.publishes(season.ann, over)
    actions = pb.GetActionsRequest(run_id=over)
    code, said = refused(lambda: season.nobody.board.GetActions(actions, metadata=METADATA))
    assert (code, "is hidden" in said) == (grpc.StatusCode.FAILED_PRECONDITION, True)

    with season.epochs() as epochs:  # as the host's commands do, while the server runs
        assert epochs.close(OLDER) == [going]
    code, said = refused(lambda: create(season.ann.stub, split=OLDER))
    assert (code, "no runs begin on it" in said) == (grpc.StatusCode.FAILED_PRECONDITION, True)
    with Player(season.ann.stub, going, 3) as player:  # what was begun may be played to its end
        player.play(tiny.ACTIONS)
    season.publishes(season.ann, going)
    with season.epochs() as epochs:
        epochs.reveal(OLDER, f"{1:064x}")

    listed = season.nobody.board.ListEpochs(pb.ListEpochsRequest(), metadata=METADATA).epochs
    assert [(epoch.split, epoch.state, epoch.secret) for epoch in listed] == [
        (NEWER, pb.EPOCH_STATE_OPEN, ""),
        (OLDER, pb.EPOCH_STATE_REVEALED, f"{1:064x}"),
    ]
    assert listed[1].command.endswith(f"--split {OLDER} --scale 0.1 --secret {1:064x}")
    found = season.nobody.board.GetActions(actions, metadata=METADATA)
    assert set(found.episodes.values()) == {bytes(tiny.ACTIONS)}
    receipt = season.nobody.stub.GetReceipt(evaluation_pb2.GetReceiptRequest(run_id=over), metadata=METADATA)
    assert json.loads(receipt.payload)["epoch"] == listed[1].commitment.hex()

    capsys.readouterr()
    assert main(["epochs", "--server", season.server.address, "--json"]) == 0
    (season.data / "epochs.json").write_text(capsys.readouterr().out)
    content = json.loads((season.data / "epochs.json").read_text())
    assert [epoch["commitment"] for epoch in content["epochs"]] == [epoch.commitment.hex() for epoch in listed]
    assert content["epochs"][0] | {"opened_at": ""} == {
        "split": NEWER, "state": "open", "statement": listed[0].statement.decode(), "opened_at": "",
        "commitment": listed[0].commitment.hex(), "closed_at": None, "revealed_at": None, "secret": None,
        "command": None,
    }  # fmt: skip
    assert main(["epochs", "--server", season.server.address]) == 0
    assert "revealed" in capsys.readouterr().out


def test_agents_on_two_epochs_are_compared(season: Season, capsys: pytest.CaptureFixture[str]) -> None:
    season.publishes(season.ann, season.plays(season.ann, split=OLDER))
    season.publishes(season.ann, season.plays(season.ann, WRONG))
    request = pb.CompareEpochsRequest(older=OLDER, newer=NEWER, language="en")
    found = season.nobody.board.CompareEpochs(request, metadata=METADATA)
    (line,) = found.agents
    assert line.same_code
    assert line.difference.mean == pytest.approx(line.newer_mean - line.older_mean)
    for run_id, mean in ((OLDER, line.older_mean), (NEWER, line.newer_mean)):  # those that lists show
        lists = season.nobody.board.List(pb.ListRequest(split=run_id, language="en"), metadata=METADATA).standings
        (row,) = (row for row in lists[-1].rows if row.name == "total")
        assert mean == next(score.mean for score in row.scores if score.metric == "PTC@CTC-3")
    assert not line.HasField("against_others")
    assert (found.mean.mean, found.sort) == (line.difference.mean, "PTC@CTC-3")
    assert not [standing.rows for standing in (line.older, line.newer) if standing.rows]
    words = ["epochs", "--server", season.server.address, "--compare", OLDER, NEWER]
    assert main([*words, "--lang", "en"]) == 0
    shown = capsys.readouterr().out
    assert "PTC on test_unseen_e2 against test_unseen_e1" in shown
    assert "-1.000" in shown
    assert "the same" in shown
    assert main(words) == 2
    assert "--compare needs the language" in capsys.readouterr().err
    wrong = pb.CompareEpochsRequest(older=NEWER, newer=OLDER, language="en")
    code, said = refused(lambda: season.nobody.board.CompareEpochs(wrong, metadata=METADATA))
    assert (code, "the older one first" in said) == (grpc.StatusCode.INVALID_ARGUMENT, True)
