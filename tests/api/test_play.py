"""The Play stream, message by message."""

from typing import Any

import grpc
import numpy as np
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_client.transport.images import ImageDecoder
from arramon_server.sim.labels import LABELS
from tests import tiny
from tests.api.player import Player, create
from tests.api.test_runs import refused
from tests.serving import METADATA

F, L, R, P = 0, 1, 2, 3


def test_episode_is_played_from_start_to_end(stub: EvaluationStub) -> None:
    run = create(stub, episodes=1, sensors=["pose"])
    with Player(stub, run.run_id, 4) as player:
        events = player.play(tiny.ACTIONS)
    kinds = [event.WhichOneof("event") for event in events]
    assert kinds[:3] == ["opened", "episode_started", "observation"]
    assert kinds[-2:] == ["episode_ended", "run_ended"]
    seen = [event.observation for event in events if event.HasField("observation")]
    assert [o.step for o in seen] == list(range(13))
    assert [(o.turn, o.phase) for o in seen] == [(1, 1)] * 3 + [(1, 2)] * 2 + [(2, 1)] * 6 + [(2, 2)] * 2
    assert [o.phase_step for o in seen] == [0, 1, 2, 0, 1, 0, 1, 2, 3, 4, 5, 0, 1]
    assert [o.steps_left for o in seen] == [8 - o.phase_step for o in seen]
    assert {o.instruction for o in seen} == {"Go on to the striped red mug.", "Put it two steps ahead."}
    assert (seen[2].pose.x, seen[2].pose.z, seen[2].pose.heading) == (0.0, 2.0, 0.0)
    assert (seen[4].pose.x, seen[4].pose.z) == (2.0, 1.0)  # in the room: column and row
    phases = [event.phase_ended for event in events if event.HasField("phase_ended")]
    assert [(p.turn, p.phase, p.forced) for p in phases] == [(1, 1, False), (1, 2, False), (2, 1, False), (2, 2, False)]


def test_step_limit_forces_phases_to_end_and_is_the_cause(stub: EvaluationStub) -> None:
    run = create(stub, episodes=1)
    with Player(stub, run.run_id) as player:
        events = player.play([L])
    assert [event.phase_ended.forced for event in events if event.HasField("phase_ended")] == [True] * 4
    assert events[-2].episode_ended.cause == types_pb2.CAUSE_STEP_LIMIT
    assert events[-1].run_ended.run.steps == 4 * 8


def test_instructions_are_in_the_runs_language(stub: EvaluationStub) -> None:
    run = create(stub, language="hi", episodes=1)
    with Player(stub, run.run_id) as player:
        assert player.observation().instruction == "धारीदार लाल मग तक चलें।"


@pytest.mark.parametrize("size", [224, 128])
def test_images_are_the_same_in_every_lossless_encoding(stub: EvaluationStub, size: int) -> None:
    frames = {}
    for encoding in (types_pb2.ENCODING_RAW, types_pb2.ENCODING_ZSTD, types_pb2.ENCODING_JPEG):
        run = create(stub, episodes=1, sensors=["rgb", "depth"])
        with Player(stub, run.run_id, encoding=encoding, image_size=size) as player:
            seen = player.observation()
        frames[encoding] = ImageDecoder().rgb(seen.rgb), ImageDecoder().depth(seen.depth)
        assert frames[encoding][0].shape == (size, size, 3)
    raw, compressed, jpeg = frames.values()
    assert (raw[0] == compressed[0]).all()
    assert (raw[1] == compressed[1]).all()
    assert (raw[1] == jpeg[1]).all()
    assert 0 < np.abs(raw[0].astype(int) - jpeg[0]).mean() < 6
    middle = raw[1][size // 2, size // 2]
    assert middle == pytest.approx(11.0, abs=0.06)  # the brick wall, 11 units ahead


@pytest.mark.parametrize("encoding", [types_pb2.ENCODING_RAW, types_pb2.ENCODING_ZSTD, types_pb2.ENCODING_JPEG])
def test_segmentation_values_index_the_streams_labels(
    stub: EvaluationStub, encoding: types_pb2.Encoding.ValueType
) -> None:
    run = create(stub, episodes=1, sensors=["segmentation"])
    with Player(stub, run.run_id, encoding=encoding, image_size=128) as player:
        labels = [(label.kind, label.colour, label.look) for label in player.next().opened.labels]
        seen = player.observation()
        assert not seen.HasField("rgb")
        assert not seen.HasField("depth")
        city = ImageDecoder().segmentation(seen.segmentation)
        for step, action in enumerate(tiny.ACTIONS[:3]):
            player.act(seen.episode_id, step, action)
            room = ImageDecoder().segmentation(player.observation().segmentation)
    assert labels == [(label.kind, label.colour, label.look) for label in LABELS]
    assert labels[city[64, 64]] == ("building", "", "brick")
    assert labels[city[0, 0]] == ("nothing", "", "")
    assert {labels[place] for place in np.unique(city)} >= {("road", "", ""), ("mug", "red", "striped")}
    assert {labels[place] for place in np.unique(room)} >= {("floor", "", ""), ("wall", "", "brick")}


def test_labels_are_sent_only_with_segmentation(stub: EvaluationStub) -> None:
    run = create(stub, episodes=1, sensors=["rgb", "depth"])
    with Player(stub, run.run_id) as player:
        assert not player.next().opened.labels


def test_encoding_and_quality_in_use_are_announced(stub: EvaluationStub) -> None:
    run = create(stub, episodes=1, sensors=["rgb"])
    lengths = []
    for asked, in_force in ((0, 90), (30, 30)):
        with Player(stub, run.run_id, player="one", encoding=types_pb2.ENCODING_JPEG, jpeg_quality=asked) as player:
            opened = player.next().opened
            assert (opened.encoding, opened.jpeg_quality) == (types_pb2.ENCODING_JPEG, in_force)
            lengths.append(len(player.observation().rgb.data))
    assert lengths[0] > lengths[1]


def test_only_requested_sensors_are_sent(stub: EvaluationStub) -> None:
    run = create(stub, episodes=1)
    with Player(stub, run.run_id) as player:
        seen = player.observation()
    assert not any(seen.HasField(name) for name in ("rgb", "depth", "segmentation", "pose"))


def test_oracle_sensor_describes_start_targets_and_obstacles(stub: EvaluationStub) -> None:
    run = create(stub, episodes=1, sensors=["oracle"])
    with Player(stub, run.run_id) as player:
        player.next()
        oracle = player.next().episode_started.oracle
    assert (oracle.start.x, oracle.start.z, oracle.start.heading) == (0.0, 0.0, 0.0)
    assert [(t.position.x, t.position.z) for t in oracle.targets] == [(0.0, 3.5), (3.5, 2.0)]
    assert [(t.cell.column, t.cell.level, t.cell.row) for t in oracle.targets] == [(2, 1, 2), (2, 2, 2)]
    assert [(o.x, o.z, o.half_width, o.half_length) for o in oracle.obstacles] == [(0.0, 12.0, 5.0, 1.0)]


@pytest.mark.parametrize(
    ("act", "code", "message"),
    [
        (pb.Act(step=0), pb.Problem.CODE_BAD_ACTION, "the action is none, expected 0, 1, 2 or 3"),
        (pb.Act(step=0, action=4), pb.Problem.CODE_BAD_ACTION, "the action is 4, expected 0, 1, 2 or 3"),  # type: ignore[arg-type]
        (pb.Act(step=0, action=-1), pb.Problem.CODE_BAD_ACTION, "the action is -1, expected 0, 1, 2 or 3"),  # type: ignore[arg-type]
        (pb.Act(step=1, action=F), pb.Problem.CODE_STEP_AHEAD, "step 1 is ahead of its turn, expected 0"),  # type: ignore[arg-type]
        (
            pb.Act(episode_id="no such", action=F),  # type: ignore[arg-type]
            pb.Problem.CODE_NOT_YOUR_EPISODE,
            "this stream has no such open episode",
        ),
    ],
)
def test_invalid_actions_are_reported_and_the_stream_continues(
    stub: EvaluationStub, act: pb.Act, code: pb.Problem.Code.ValueType, message: str
) -> None:
    run = create(stub, episodes=1)
    with Player(stub, run.run_id) as player:
        episode_id = player.observation().episode_id
        act.episode_id = act.episode_id or episode_id
        player.send([act])
        problem = player.problem()
        assert (problem.code, problem.message) == (code, f"episode {act.episode_id!r}: {message}")
        player.act(episode_id, 0, F)
        assert player.observation().step == 1


def test_repeated_action_is_answered_again_and_applied_once(stub: EvaluationStub) -> None:
    run = create(stub, episodes=1, sensors=["pose"])
    with Player(stub, run.run_id) as player:
        episode_id = player.observation().episode_id
        player.act(episode_id, 0, F)
        player.act(episode_id, 0, F)
        first, again = player.observation(), player.observation()
        assert 0.0 < again.step_seconds_left <= first.step_seconds_left == 60.0
        for seen in (first, again):
            seen.ClearField("step_seconds_left")
        assert first == again
        assert (first.step, first.pose.z) == (1, 1.0)


def test_different_action_for_an_answered_step_is_a_problem(stub: EvaluationStub) -> None:
    run = create(stub, episodes=1, sensors=["pose"])
    with Player(stub, run.run_id) as player:
        episode_id = player.observation().episode_id
        player.act(episode_id, 0, F)
        assert player.observation().step == 1
        player.act(episode_id, 0, L)
        assert player.problem().code == pb.Problem.CODE_STEP_BEHIND
        assert player.observation().pose.heading == 0.0


def test_answers_to_ended_episodes_are_ignored(stub: EvaluationStub) -> None:
    run = create(stub, episodes=2)
    with Player(stub, run.run_id) as player:
        episode_id = player.observation().episode_id
        for step, action in enumerate(tiny.ACTIONS):
            player.act(episode_id, step, action)
        while not player.next().HasField("episode_ended"):
            pass
        other = player.observation().episode_id
        player.act(episode_id, len(tiny.ACTIONS) - 1, P)
        player.act(other, 0, F)
        assert player.next().observation.episode_id == other


def test_forfeited_episodes_are_counted_in_the_run(stub: EvaluationStub) -> None:
    run = create(stub, episodes=2)
    with Player(stub, run.run_id) as player:
        episode_id = player.observation().episode_id
        player.send([pb.Act(episode_id=episode_id, forfeit=pb.Forfeit(reason="the agent broke down"))])
        assert player.next().episode_ended.cause == types_pb2.CAUSE_FORFEITED
        last = player.play(tiny.ACTIONS)
        assert player.call.code() == grpc.StatusCode.OK
    ended = next(event.run_ended.run for event in last if event.HasField("run_ended"))
    assert dict(ended.causes) == {"FORFEITED": 1, "AGENT_FINISHED": 1}


def test_two_streams_of_a_run_never_share_an_episode(stub: EvaluationStub) -> None:
    run = create(stub)
    with Player(stub, run.run_id, 2, player="a") as one, Player(stub, run.run_id, 2, player="b") as other:
        mine = {one.observation().episode_id, one.observation().episode_id}
        theirs = {other.observation().episode_id, other.observation().episode_id}
        assert not mine & theirs
        other.act(next(iter(mine)), 0, F)
        assert other.problem().code == pb.Problem.CODE_NOT_YOUR_EPISODE


def test_acting_on_an_episode_of_another_run_is_a_problem(stub: EvaluationStub) -> None:
    first, second = create(stub, episodes=1), create(stub, language="hi", episodes=1)
    with Player(stub, first.run_id) as one, Player(stub, second.run_id) as other:
        theirs = other.observation().episode_id
        if one.observation().episode_id != theirs:
            one.act(theirs, 0, F)
            assert one.problem().code == pb.Problem.CODE_NOT_YOUR_EPISODE


def test_new_stream_of_the_same_player_resumes_its_episodes(stub: EvaluationStub) -> None:
    run = create(stub, episodes=3, sensors=["pose"])
    with Player(stub, run.run_id, 2, player="p") as player:
        episodes = {player.observation().episode_id, player.observation().episode_id}
        for episode_id in episodes:
            player.act(episode_id, 0, F)
        assert {player.observation().step, player.observation().step} == {1}
        with Player(stub, run.run_id, 2, player="p") as back:
            opened = back.next().opened
            assert set(opened.episode_ids) == episodes
            assert back.next().episode_started.step == 1
            assert back.observation().pose.z == 1.0
        code, message = refused(lambda: list(player.call))
        assert code == grpc.StatusCode.FAILED_PRECONDITION
        assert message == "replaced by a newer stream of the same player"


def test_history_replays_an_episode_from_its_first_observation(stub: EvaluationStub) -> None:
    run = create(stub, episodes=1, sensors=["pose", "rgb"])
    with Player(stub, run.run_id, player="p") as player:
        episode_id = player.observation().episode_id
        live = []
        for step, action in enumerate((F, R, F)):
            player.act(episode_id, step, action)
            live.append(player.observation())
    with Player(stub, run.run_id, player="another", history=True, adopt=True) as back:
        past = [back.observation() for _ in range(3)]
        now = back.observation()
    assert [o.taken for o in past] == [F, R, F]
    assert not any(shown.HasField("step_seconds_left") for shown in past)
    for shown in (*past, now, *live):
        for name in ("taken", "step_seconds_left", "bank_seconds_left"):
            shown.ClearField(name)
    assert [*past, now][1:] == live


def test_episodes_left_open_are_not_given_to_another_player_at_once(stub: EvaluationStub) -> None:
    run = create(stub, episodes=2)
    with Player(stub, run.run_id, player="gone") as player:
        left = player.observation().episode_id
    with Player(stub, run.run_id, 2, player="other") as other:
        assert not other.next().opened.episode_ids
        assert other.observation().episode_id != left


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"encoding": 9}, "encoding 9 is not offered; see ServerInfo.encodings"),
        ({"encoding": 3, "jpeg_quality": 101}, "jpeg_quality is 101, expected 1 to 100, or 0 for 90"),
        (
            {"encoding": 2, "jpeg_quality": 90},
            "jpeg_quality is 90, expected 0 with ENCODING_ZSTD: only ENCODING_JPEG has a quality",
        ),
        ({"image_size": 7}, "image_size is 7, expected one of 224, 128"),
        ({"player": "x" * 101}, "the player's name has 101 characters; at most 100 are allowed"),
    ],
)
def test_invalid_stream_settings_are_refused(stub: EvaluationStub, fields: dict[str, Any], message: str) -> None:
    run = create(stub)
    with Player(stub, run.run_id, 1, **fields) as player:
        assert refused(lambda: list(player.call)) == (grpc.StatusCode.INVALID_ARGUMENT, message)


@pytest.mark.parametrize("episodes", [0, 1025])
def test_out_of_range_max_episodes_is_refused(stub: EvaluationStub, episodes: int) -> None:
    run = create(stub)
    with Player(stub, run.run_id, episodes) as player:
        expected = f"max_episodes is {episodes}, expected 1 to 1024"
        assert refused(lambda: list(player.call)) == (grpc.StatusCode.INVALID_ARGUMENT, expected)


def test_open_is_required_first_and_refused_later(stub: EvaluationStub) -> None:
    first = [pb.PlayRequest(actions=pb.ActionBatch())]
    assert refused(lambda: list(stub.Play(iter(first), metadata=METADATA)))[1] == "a stream's first message is `open`"
    run = create(stub)
    with Player(stub, run.run_id) as player:
        player.observation()
        player.raw(pb.PlayRequest(open=pb.Open(run_id=run.run_id)))
        code, message = refused(lambda: list(player.call))
        assert (code, message[:32]) == (grpc.StatusCode.INVALID_ARGUMENT, "a stream's first message is `ope")
