"""Messages about hidden splits: no positions, no episode scores, and no content of files."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import grpc
from google.protobuf.message import Message

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_dataset.generation.command import generate
from arramon_dataset.generation.split_specs import SPLITS
from arramon_server.episodes.split_secrets import host_secret
from tests import tiny
from tests.api.player import Player, create
from tests.api.test_runs import refused
from tests.dataset.generation.small_section import make_plain_writer
from tests.serving import METADATA, Server

FORWARD, LEFT, INTERACT = 0, 1, 3


def leaves(message: Message) -> Iterator[Any]:
    """All scalars in a message, however deep."""
    for field, value in message.ListFields():
        values = value if field.is_repeated else [value]
        for one in values.values() if hasattr(values, "values") else values:
            if isinstance(one, Message):
                yield from leaves(one)
            else:
                yield one


def test_hidden_run_in_play_reveals_only_its_progress(stub: EvaluationStub) -> None:
    run = create(stub, split="secret")
    with Player(stub, run.run_id) as player:
        for _ in range(2):
            seen = player.observation()
            for step, action in enumerate(tiny.ACTIONS):
                player.act(seen.episode_id, step, action)
            while not (event := player.next()).HasField("episode_ended"):
                pass
            assert {field.name for field, _ in event.episode_ended.ListFields()} == {
                "episode_id",
                "cause",
                "episodes_ended",
            }
        half = stub.GetRun(pb.GetRunRequest(run_id=run.run_id), metadata=METADATA)
        request = pb.GetReportRequest(run_id=run.run_id)
        code, message = refused(lambda: stub.GetReport(request, metadata=METADATA))
        assert code == grpc.StatusCode.FAILED_PRECONDITION
        assert message == f"run {run.run_id!r} is still being played: 2 of 3 episodes have ended"
        receipt = pb.GetReceiptRequest(run_id=run.run_id)
        assert refused(lambda: stub.GetReceipt(receipt, metadata=METADATA))[0] == grpc.StatusCode.FAILED_PRECONDITION
        changed = {field.name for field, value in half.ListFields() if getattr(run, field.name) != value}
        assert changed == {"episodes_ended", "steps", "causes", "thinking_seconds", "timed_steps"}
        rest = player.play(tiny.ACTIONS)
    report = stub.GetReport(request, metadata=METADATA)
    assert [row.name for row in report.rows] == ["turn 1", "turn 2", "total"]
    assert not report.episodes
    scores = [score for row in report.rows for score in row.scores]  # three episodes are too few for an interval
    assert {(score.low, score.high) for score in scores} == {(0.0, 1.0)}
    for message_ in (half, *rest):
        assert not [leaf for leaf in leaves(message_) if isinstance(leaf, str) and ("CTC" in leaf or "nDTW" in leaf)]


def test_messages_reveal_nothing_of_a_generated_hidden_split(tmp_path: Path) -> None:
    (split,) = generate(
        tmp_path,
        [SPLITS["test_unseen"]],
        scale=2 / 1205,
        jobs=1,
        make_writer=make_plain_writer,
        on_progress=lambda _: None,
    )
    server = Server(tmp_path, "127.0.0.1:0", "--steps", "8")
    with grpc.insecure_channel(server.address) as channel:
        stub = EvaluationStub(channel)
        info = stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA)
        run = create(stub, split="test_unseen")
        with Player(stub, run.run_id, 2) as player:
            events = player.play([FORWARD, LEFT, INTERACT])
        report = stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    assert server.stop() == 0

    said = [leaf for message in (info, run, *events, report) for leaf in leaves(message)]
    assert sum(event.WhichOneof("event") == "observation" for event in events) > 20
    numbers = {round(float(leaf), 3) for leaf in said if isinstance(leaf, int | float)}
    secret = host_secret(tmp_path)
    secrets_in_texts = {
        text
        for episode in split.episodes.values()
        for texts in episode.instructions.values()
        for turn in texts
        for text in (turn.navigation, turn.assembly)
    }
    assert secrets_in_texts & set(said)
    words = " ".join(leaf for leaf in said if isinstance(leaf, str) and leaf not in secrets_in_texts)
    for episode in split.episodes.values():
        on_the_way = {round(value, 3) for turn in episode.turns for place in turn.path for value in place}
        lying = [(item.position.x, item.position.z) for turn in episode.turns for item in turn.street]
        assert not {value for value in on_the_way if value % 0.5} & numbers
        assert not [place for place in lying if numbers.issuperset(place)]
        assert not [item for turn in episode.turns for item in turn.street if str(item.type) in words]
    everything = b"".join(message.SerializeToString() for message in (info, run, *events, report))
    assert secret.encode() not in everything
    assert bytes.fromhex(secret) not in everything
    assert b"building" not in everything
