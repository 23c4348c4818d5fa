"""Runs over gRPC: create, get, list, cancel, report, and every refusal."""

from typing import Any

import grpc
import pytest
from grpc_health.v1 import health_pb2, health_pb2_grpc
from grpc_reflection.v1alpha.proto_reflection_descriptor_database import ProtoReflectionDescriptorDatabase

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from server import __version__
from server.serving import COMPILING
from tests import tiny
from tests.api.player import Player, create
from tests.serving import METADATA, Server


def refused(call: Any) -> tuple[grpc.StatusCode, str]:
    with pytest.raises(grpc.RpcError) as caught:
        call()
    return caught.value.code(), caught.value.details() or ""


def test_server_information(stub: EvaluationStub) -> None:
    info = stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA)
    assert (info.version, info.protocol, info.limits.steps_per_phase) == (__version__, 1, 8)
    assert [split.name for split in info.splits] == ["secret", "tiny"]
    assert dict(info.splits[1].episodes) == {"en": 6, "hi": 4}
    assert list(info.splits[1].sensors) == ["rgb", "depth", "segmentation", "pose", "oracle"]
    assert list(info.splits[0].sensors) == ["rgb", "depth"]
    assert list(info.encodings) == [types_pb2.ENCODING_RAW, types_pb2.ENCODING_ZSTD, types_pb2.ENCODING_JPEG]


def test_what_the_server_says_when_it_starts(server: Server) -> None:
    # The first server on a machine also says that it compiles the camera.
    said = [line for line in server.said if line != COMPILING]
    assert said[1].startswith("split tiny (open): 6 in en, 4 in hi; 1 sections; data ")
    assert said[2:] == [f"listening on {server.address}"]


def test_health_and_reflection(server: Server) -> None:
    with grpc.insecure_channel(server.address) as channel:
        health = health_pb2_grpc.HealthStub(channel)
        for service in ("", "arramon.v1.Evaluation"):
            answer = health.Check(health_pb2.HealthCheckRequest(service=service))
            assert answer.status == health_pb2.HealthCheckResponse.SERVING
        assert "arramon.v1.Evaluation" in ProtoReflectionDescriptorDatabase(channel).get_services()


def test_a_new_run_holds_what_it_was_created_with(stub: EvaluationStub) -> None:
    run = create(stub, language="hi", sensors=["depth", "rgb"], episodes=3, participant="lab")
    assert (run.split, run.language, run.episodes, run.participant) == ("tiny", "hi", 3, "lab")
    assert list(run.sensors) == ["rgb", "depth"]
    assert run.state == pb.RUN_STATE_RUNNING
    assert run == stub.GetRun(pb.GetRunRequest(run_id=run.run_id), metadata=METADATA)


@pytest.mark.parametrize(
    ("fields", "code", "message"),
    [
        ({"split": "val_unseen"}, "NOT_FOUND", "there is no split 'val_unseen'; this server has secret, tiny"),
        ({"language": "fr"}, "NOT_FOUND", "split 'tiny' has no episodes in 'fr'; it has en, hi"),
        ({"agent": " "}, "INVALID_ARGUMENT", "the agent's name is ' ', expected a text that can be seen"),
        (
            {"agent": "a\x1b[2J"},
            "INVALID_ARGUMENT",
            "the agent's name is 'a\\x1b[2J', expected a text that can be seen",
        ),
        ({"agent": "x" * 201}, "INVALID_ARGUMENT", "the agent's name has 201 characters; at most 200 are allowed"),
        ({"episodes": 7}, "INVALID_ARGUMENT", "7 episodes were asked for; split 'tiny' has 6 in 'en'"),
        (
            {"split": "secret", "episodes": 2},
            "INVALID_ARGUMENT",
            "split 'secret' is hidden and played whole; 2 of its episodes were asked for",
        ),
        (
            {"sensors": ["radar"]},
            "INVALID_ARGUMENT",
            "split 'tiny' does not offer the sensor 'radar', but rgb, depth, segmentation, pose, oracle",
        ),
        (
            {"split": "secret", "sensors": ["oracle"]},
            "INVALID_ARGUMENT",
            "split 'secret' does not offer the sensor 'oracle', but rgb, depth",
        ),
        (
            {"split": "secret", "sensors": ["rgb", "segmentation"]},
            "INVALID_ARGUMENT",
            "split 'secret' does not offer the sensor 'segmentation', but rgb, depth",
        ),
    ],
)
def test_runs_that_cannot_be(stub: EvaluationStub, fields: dict[str, Any], code: str, message: str) -> None:
    assert refused(lambda: create(stub, **fields)) == (grpc.StatusCode[code], message)


def test_runs_are_listed_page_by_page_latest_first(stub: EvaluationStub) -> None:
    made = [create(stub).run_id for _ in range(5)]
    first = stub.ListRuns(pb.ListRunsRequest(page_size=2), metadata=METADATA)
    second = stub.ListRuns(pb.ListRunsRequest(page_size=3, page_token=first.next_page_token), metadata=METADATA)
    assert [run.run_id for run in (*first.runs, *second.runs)] == made[::-1]


@pytest.mark.parametrize(
    ("request_", "code", "message"),
    [
        (pb.ListRunsRequest(page_size=5000), "INVALID_ARGUMENT", "page_size is 5000, expected 1 to 1000"),
        (pb.ListRunsRequest(page_token="nonsense"), "NOT_FOUND", "there is no run 'nonsense'"),
    ],
)
def test_pages_that_cannot_be(stub: EvaluationStub, request_: pb.ListRunsRequest, code: str, message: str) -> None:
    assert refused(lambda: stub.ListRuns(request_, metadata=METADATA)) == (grpc.StatusCode[code], message)


def test_an_unknown_run(stub: EvaluationStub) -> None:
    for call in (
        lambda: stub.GetRun(pb.GetRunRequest(run_id="x"), metadata=METADATA),
        lambda: stub.CancelRun(pb.CancelRunRequest(run_id="x"), metadata=METADATA),
        lambda: stub.GetReport(pb.GetReportRequest(run_id="x"), metadata=METADATA),
        lambda: list(Player(stub, "x").call),
    ):
        assert refused(call) == (grpc.StatusCode.NOT_FOUND, "there is no run 'x'")


def test_a_report_only_when_the_run_is_over(stub: EvaluationStub) -> None:
    run = create(stub, episodes=2)
    code, message = refused(lambda: stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA))
    assert code == grpc.StatusCode.FAILED_PRECONDITION
    assert message == f"run '{run.run_id}' is still being played: 0 of 2 episodes have ended"


def test_a_perfect_run_and_its_report(stub: EvaluationStub) -> None:
    run = create(stub, episodes=2)
    with Player(stub, run.run_id, 2) as player:
        last = player.play(tiny.ACTIONS)[-1].run_ended.run
    assert (last.state, dict(last.causes)) == (pb.RUN_STATE_COMPLETE, {"AGENT_FINISHED": 2})
    assert last.steps == 2 * len(tiny.ACTIONS)
    report = stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    assert [row.name for row in report.rows] == ["turn 1", "turn 2", "total"]
    assert {(score.mean, score.low, score.high) for row in report.rows for score in row.scores} == {(1.0, 1.0, 1.0)}
    assert report.signature.startswith("split:tiny|lang:en|episodes:2|steps:8|")
    assert {episode.cause for episode in report.episodes} == {types_pb2.CAUSE_AGENT_FINISHED}


def test_a_hidden_split_tells_no_scores_of_single_episodes(stub: EvaluationStub) -> None:
    run = create(stub, split="secret")
    with Player(stub, run.run_id, 3) as player:
        player.play(tiny.ACTIONS)
    report = stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    assert report.rows[2].scores[0].mean == 1.0
    assert not report.episodes


def test_a_cancelled_run_keeps_its_denominator(stub: EvaluationStub) -> None:
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
    assert again == (grpc.StatusCode.FAILED_PRECONDITION, f"run '{run.run_id}' is cancelled already")


@pytest.mark.parametrize("metadata", [(), (("arramon-protocol", "99"),)])
def test_another_protocol_is_turned_away(stub: EvaluationStub, metadata: tuple[tuple[str, str], ...]) -> None:
    spoken = dict(metadata).get("arramon-protocol", "none")
    for call in (
        lambda: stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=metadata),
        lambda: list(stub.Play(iter([pb.PlayRequest()]), metadata=metadata)),
    ):
        code, message = refused(call)
        assert code == grpc.StatusCode.FAILED_PRECONDITION
        assert f"speaks protocol 1, the client '{spoken}'" in message


def test_a_message_too_large_is_refused_and_others_go_on(stub: EvaluationStub) -> None:
    code, message = refused(lambda: create(stub, agent="x" * (2 << 20)))
    assert code == grpc.StatusCode.RESOURCE_EXHAUSTED
    assert "1048576" in message
    assert create(stub).episodes == 6


def test_a_report_says_in_which_form_images_travelled(stub: EvaluationStub) -> None:
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
