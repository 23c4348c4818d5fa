"""Runs over gRPC: what this server adds to the contract that `tests/conformance` checks, and messages of refusals."""

import hashlib
import json
from typing import Any

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import leaderboard_pb2 as lb
from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon.v1.leaderboard_pb2_grpc import LeaderboardStub
from arramon_server import __version__
from arramon_server.api.error_guard import truncate_status
from arramon_server.process.lifecycle import COMPILING
from tests import tiny
from tests.api.player import Player, create
from tests.serving import METADATA, Server


def refused(call: Any) -> tuple[grpc.StatusCode, str]:
    with pytest.raises(grpc.RpcError) as caught:
        call()
    return caught.value.code(), caught.value.details() or ""


def arguments(**values: str) -> list[pb.AgentArgument]:
    return [pb.AgentArgument(name=name, value=value) for name, value in values.items()]


def test_server_info_lists_splits_sensors_and_encodings(stub: EvaluationStub) -> None:
    info = stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA)
    assert (info.version, info.protocol, info.limits.steps_per_phase) == (__version__, 1, 8)
    assert [split.name for split in info.splits] == ["secret", "tiny"]
    assert dict(info.splits[1].episodes) == {"en": 6, "hi": 4}
    assert list(info.splits[1].sensors) == ["rgb", "depth", "segmentation", "pose", "oracle"]
    assert list(info.splits[0].sensors) == ["rgb", "depth"]
    assert list(info.encodings) == [types_pb2.ENCODING_RAW, types_pb2.ENCODING_ZSTD, types_pb2.ENCODING_JPEG]


def test_server_prints_its_splits_and_address_at_start(server: Server) -> None:
    # The first server on a machine also says that it compiles the camera.
    said = [line for line in server.said if line != COMPILING]
    assert said[1].startswith("split tiny (open): 6 in en, 4 in hi; 1 section; data ")
    assert said[2:] == [f"listening on {server.address}"]


def test_new_run_holds_its_creation_settings(stub: EvaluationStub) -> None:
    run = create(stub, language="hi", sensors=["depth", "rgb"], episodes=3, participant="lab")
    assert (run.split, run.language, run.episodes, run.participant) == ("tiny", "hi", 3, "lab")
    assert list(run.sensors) == ["rgb", "depth"]
    assert run.state == pb.RUN_STATE_RUNNING
    assert run == stub.GetRun(pb.GetRunRequest(run_id=run.run_id), metadata=METADATA)


def test_only_chosen_episodes_are_played_in_the_given_order(stub: EvaluationStub) -> None:
    run = create(stub, episode_ids=["5", "2"])
    assert run.episodes == 2
    assert ended(stub, run) == ["5", "2"]
    report = stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    chosen = hashlib.sha256(b"2\n5").hexdigest()[:12]
    assert "|episodes:2|" in report.signature
    assert report.signature.endswith(f"|chosen:{chosen}")


def test_first_episodes_by_count_or_by_id_have_one_signature(stub: EvaluationStub) -> None:
    first = create(stub, episodes=2)
    names = ended(stub, first)
    named = create(stub, episode_ids=names[::-1])
    assert ended(stub, named) == names[::-1]
    signatures = {
        stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA).signature for run in (first, named)
    }
    assert len(signatures) == 1
    assert "chosen:" not in signatures.pop()


def test_agent_arguments_are_recorded_verbatim(stub: EvaluationStub) -> None:
    run = create(stub, episodes=1, agent_arguments=arguments(checkpoint="my w.pt", beam="04", none=""))
    assert list(run.agent_arguments) == arguments(beam="04", checkpoint="my w.pt", none="")
    assert run == stub.GetRun(pb.GetRunRequest(run_id=run.run_id), metadata=METADATA)
    ended(stub, run)
    report = stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    assert report.run.agent_arguments == run.agent_arguments
    assert report.signature.endswith("|args:beam=04+checkpoint=my%20w.pt+none=")
    receipt = stub.GetReceipt(pb.GetReceiptRequest(run_id=run.run_id), metadata=METADATA)
    content = json.loads(receipt.payload)
    assert content["run"]["agent_arguments"] == {"beam": "04", "checkpoint": "my w.pt", "none": ""}
    assert content["score_signature"] == report.signature


def test_receipt_without_agent_arguments_omits_their_field(stub: EvaluationStub) -> None:
    run = create(stub, episodes=1)
    ended(stub, run)
    content = json.loads(stub.GetReceipt(pb.GetReceiptRequest(run_id=run.run_id), metadata=METADATA).payload)
    assert "agent_arguments" not in content["run"]
    assert "args:" not in content["score_signature"]


def ended(stub: EvaluationStub, run: pb.Run) -> list[str]:
    """Cancels the run; its episodes in playing order, as the receipt has them."""
    stub.CancelRun(pb.CancelRunRequest(run_id=run.run_id), metadata=METADATA)
    receipt = stub.GetReceipt(pb.GetReceiptRequest(run_id=run.run_id), metadata=METADATA)
    return [episode["episode_id"] for episode in json.loads(receipt.payload)["episodes"]]


@pytest.mark.parametrize(
    ("fields", "code", "message"),
    [
        ({"split": "val_unseen"}, "NOT_FOUND", "there is no split 'val_unseen'; this server has secret, tiny"),
        ({"language": "fr"}, "NOT_FOUND", "split 'tiny' has no episodes in 'fr'; it has en, hi"),
        ({"agent": " "}, "INVALID_ARGUMENT", "the agent's name is ' ', expected one line of visible text"),
        (
            {"agent": "a\x1b[2J"},
            "INVALID_ARGUMENT",
            "the agent's name is 'a\\x1b[2J', expected one line of visible text",
        ),
        ({"agent": "x" * 201}, "INVALID_ARGUMENT", "the agent's name has 201 characters; at most 200 are allowed"),
        ({"episodes": 7}, "INVALID_ARGUMENT", "7 episodes were requested; split 'tiny' has 6 in 'en'"),
        (
            {"split": "secret", "episodes": 2},
            "INVALID_ARGUMENT",
            "split 'secret' is hidden and can only be played whole; 2 of its episodes were requested",
        ),
        (
            {"episode_ids": ["1", "nowhere"]},
            "NOT_FOUND",
            "split 'tiny' has no episode 'nowhere' in 'en'",
        ),
        ({"episode_ids": ["3"], "language": "hi"}, "NOT_FOUND", "split 'tiny' has no episode '3' in 'hi'"),
        (
            {"episode_ids": ["x" * 5000]},
            "NOT_FOUND",
            f"split 'tiny' has no episode '{'x' * 100}...' in 'en'",
        ),
        (
            {"episode_ids": ["1", "1"]},
            "INVALID_ARGUMENT",
            "the episode '1' is given twice; a run plays each episode once",
        ),
        (
            {"episode_ids": ["1"], "episodes": 2},
            "INVALID_ARGUMENT",
            "both a number of episodes (2) and a list of 1 were given; expected one of them",
        ),
        (
            {"split": "secret", "episode_ids": ["0", "1", "2"]},
            "INVALID_ARGUMENT",
            "split 'secret' is hidden and can only be played whole; single episodes were requested",
        ),
        (
            {"split": "secret", "episode_ids": ["nowhere"]},
            "INVALID_ARGUMENT",
            "split 'secret' is hidden and can only be played whole; single episodes were requested",
        ),
        (
            {"agent_arguments": arguments(**{f"a{n}": "1" for n in range(17)})},
            "INVALID_ARGUMENT",
            "the agent has 17 arguments; at most 16 are allowed",
        ),
        (
            {"agent_arguments": arguments(**{f"a{n}": "x" * 199 for n in range(5)})},
            "INVALID_ARGUMENT",
            "the agent's arguments have 1005 characters; at most 1000 are allowed in total",
        ),
        (
            {"agent_arguments": arguments(beam="x" * 201)},
            "INVALID_ARGUMENT",
            "the agent's argument beam has 201 characters; at most 200 are allowed",
        ),
        (
            {"agent_arguments": arguments(**{"b" * 65: "1"})},
            "INVALID_ARGUMENT",
            "an agent's argument has a name of 65 characters; at most 64 are allowed",
        ),
        (
            {"agent_arguments": arguments(**{"a b": "1"})},
            "INVALID_ARGUMENT",
            "an agent's argument has the name 'a b', expected an ASCII identifier such as 'beam'",
        ),
        (
            {"agent_arguments": arguments(beam="4\n5")},
            "INVALID_ARGUMENT",
            "the agent's argument beam is '4\\n5', expected one line of visible text",
        ),
        (
            {"agent_arguments": [*arguments(beam="4"), *arguments(beam="5")]},
            "INVALID_ARGUMENT",
            "the agent's argument 'beam' is given twice",
        ),
        (
            {"sensors": ["radar"]},
            "INVALID_ARGUMENT",
            "split 'tiny' does not offer the sensor 'radar'; it offers rgb, depth, segmentation, pose, oracle",
        ),
        (
            {"split": "secret", "sensors": ["oracle"]},
            "INVALID_ARGUMENT",
            "split 'secret' does not offer the sensor 'oracle'; it offers rgb, depth",
        ),
        (
            {"split": "secret", "sensors": ["rgb", "segmentation"]},
            "INVALID_ARGUMENT",
            "split 'secret' does not offer the sensor 'segmentation'; it offers rgb, depth",
        ),
    ],
)
def test_invalid_run_requests_are_refused(
    stub: EvaluationStub, fields: dict[str, Any], code: str, message: str
) -> None:
    assert refused(lambda: create(stub, **fields)) == (grpc.StatusCode[code], message)


def test_oversized_page_of_runs_is_refused(stub: EvaluationStub) -> None:
    code, message = refused(lambda: stub.ListRuns(pb.ListRunsRequest(page_size=5000), metadata=METADATA))
    assert (code, message) == (grpc.StatusCode.INVALID_ARGUMENT, "page_size is 5000, expected 1 to 1000")


@pytest.mark.parametrize("letter", ["a", "\x01", "ह", "🧿", "%"])
def test_error_messages_truncate_long_texts(stub: EvaluationStub, board: LeaderboardStub, letter: str) -> None:
    long = letter * 20_000
    repeated = f"{letter * 100!r}... (20000 characters)"
    for code, call in (
        ("NOT_FOUND", lambda: stub.GetRun(pb.GetRunRequest(run_id=long), metadata=METADATA)),
        ("NOT_FOUND", lambda: stub.CancelRun(pb.CancelRunRequest(run_id=long), metadata=METADATA)),
        ("NOT_FOUND", lambda: stub.GetReport(pb.GetReportRequest(run_id=long), metadata=METADATA)),
        ("NOT_FOUND", lambda: stub.GetReceipt(pb.GetReceiptRequest(run_id=long), metadata=METADATA)),
        ("NOT_FOUND", lambda: stub.ListRuns(pb.ListRunsRequest(page_token=long), metadata=METADATA)),
        ("NOT_FOUND", lambda: list(Player(stub, long).call)),
        ("NOT_FOUND", lambda: create(stub, split=long)),
        ("NOT_FOUND", lambda: create(stub, language=long)),
        ("INVALID_ARGUMENT", lambda: create(stub, sensors=[long])),
        ("NOT_FOUND", lambda: board.Publish(lb.PublishRequest(run_id=long), metadata=METADATA)),
        ("NOT_FOUND", lambda: board.Withdraw(lb.WithdrawRequest(run_id=long), metadata=METADATA)),
        ("NOT_FOUND", lambda: board.GetEntry(lb.GetEntryRequest(run_id=long), metadata=METADATA)),
        ("NOT_FOUND", lambda: board.List(lb.ListRequest(split=long), metadata=METADATA)),
        ("NOT_FOUND", lambda: board.List(lb.ListRequest(split="tiny", language=long), metadata=METADATA)),
        (
            "INVALID_ARGUMENT",
            lambda: board.List(lb.ListRequest(split="tiny", language="en", sort=long), metadata=METADATA),
        ),
    ):
        status, message = refused(call)
        assert status == grpc.StatusCode[code]
        assert repeated in message


def test_problems_truncate_long_episode_ids(stub: EvaluationStub) -> None:
    with Player(stub, create(stub).run_id) as player:
        assert player.observation().step == 0
        player.act("x" * 20_000, 0, 1)
        problem = player.problem()
    assert problem.episode_id == "x" * 100
    assert len(problem.message) < 300


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a" * 4096, "a" * 4096),
        ("a" * 4097, "a" * 4096 + "..."),
        ("ह" * 500, "ह" * 455 + "..."),
        ("%" * 1366, "%" * 1365 + "..."),
    ],
)
def test_refusals_are_truncated_by_their_encoded_size(text: str, expected: str) -> None:
    assert truncate_status(text) == expected


def test_perfect_run_scores_one_in_its_report(stub: EvaluationStub) -> None:
    run = create(stub, episodes=2)
    with Player(stub, run.run_id, 2) as player:
        last = player.play(tiny.ACTIONS)[-1].run_ended.run
    assert (last.state, dict(last.causes)) == (pb.RUN_STATE_COMPLETE, {"AGENT_FINISHED": 2})
    assert last.steps == 2 * len(tiny.ACTIONS)
    report = stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    assert [row.name for row in report.rows] == ["turn 1", "turn 2", "total"]
    scores = [score for row in report.rows for score in row.scores]
    assert {(score.mean, score.high) for score in scores} == {(1.0, 1.0)}
    assert all(0.0 < score.low < 0.1 for score in scores)  # two episodes say little
    assert report.signature.startswith("split:tiny|lang:en|episodes:2|steps:8|")
    assert {episode.cause for episode in report.episodes} == {types_pb2.CAUSE_AGENT_FINISHED}


def test_cancelled_run_is_scored_over_all_its_episodes(stub: EvaluationStub) -> None:
    run = create(stub, episodes=4)
    with Player(stub, run.run_id) as player:
        episode = player.observation().episode_id
        for step, action in enumerate(tiny.ACTIONS[:5]):  # the whole first turn
            player.act(episode, step, action)
        while player.observation().step < 5:
            pass
        cancelled = stub.CancelRun(pb.CancelRunRequest(run_id=run.run_id), metadata=METADATA)
        assert player.next().run_ended.run == cancelled
    assert (cancelled.state, dict(cancelled.causes)) == (pb.RUN_STATE_CANCELLED, {"FORFEITED": 4})
    report = stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    means = {row.name: {score.metric: score.mean for score in row.scores} for row in report.rows}
    assert (means["turn 1"]["PTC"], means["turn 2"]["PTC"], means["total"]["PTC"]) == (0.25, 0.0, 0.125)
    again = refused(lambda: stub.CancelRun(pb.CancelRunRequest(run_id=run.run_id), metadata=METADATA))
    assert again == (grpc.StatusCode.FAILED_PRECONDITION, f"run '{run.run_id}' is already cancelled")


@pytest.mark.parametrize("metadata", [(), (("arramon-protocol", "99"),)])
def test_other_protocol_versions_are_refused(stub: EvaluationStub, metadata: tuple[tuple[str, str], ...]) -> None:
    spoken = dict(metadata).get("arramon-protocol", "none")
    for call in (
        lambda: stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=metadata),
        lambda: list(stub.Play(iter([pb.PlayRequest()]), metadata=metadata)),
    ):
        code, message = refused(call)
        assert code == grpc.StatusCode.FAILED_PRECONDITION
        assert f"speaks protocol 1, the client '{spoken}'" in message


def test_report_names_the_image_encodings_used(stub: EvaluationStub) -> None:
    seen, blind = create(stub, episodes=2, sensors=["rgb"]), create(stub, episodes=1)
    with Player(stub, seen.run_id, encoding=types_pb2.ENCODING_JPEG, jpeg_quality=70) as player:
        player.observation()
    for run_id in (seen.run_id, blind.run_id):
        with Player(stub, run_id, adopt=True, image_size=128) as player:
            player.play(tiny.ACTIONS)
    for run_id, images, signed in ((seen.run_id, ["jpeg70-224", "lossless-128"], "jpeg70-224+lossless-128"),
                                   (blind.run_id, [], "none")):  # fmt: skip
        report = stub.GetReport(pb.GetReportRequest(run_id=run_id), metadata=METADATA)
        assert list(report.run.images) == images
        assert f"|images:{signed}|" in report.signature
