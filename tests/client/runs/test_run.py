"""Runs played step by step against a scripted server: steps, repeated calls, plans, broken streams, resumption."""

import itertools
import threading
from collections.abc import Iterator
from itertools import islice
from typing import Any

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client import (
    Action,
    EpisodeLostError,
    RefusedError,
    Run,
    RunClosedError,
    RunEpisode,
    ServerUnreachableError,
    StepAheadError,
    StepSpentError,
    UsageError,
)
from tests.client.fake import METRICS, RUN, Recorder, Servicer, World, serving

BY_RULE = {f"e{i}": [(i + step) % 4 for step in range(5)] for i in range(4)}
LEFT, FORWARD = Action.LEFT, Action.FORWARD


@pytest.fixture
def address(world: World) -> Iterator[str]:
    with serving(Servicer(world)) as address:
        yield address


def created(address: str, **options: Any) -> Run:
    return Run.create(server=address, language="en", agent="mine", **options)


def first(run: Run) -> RunEpisode:
    return next(run.episodes())


def play_by_rule(episode: RunEpisode) -> list[int]:
    """Play an episode to its end; return the steps that were seen."""
    seen: list[int] = []
    while not episode.ended:
        observation = episode.look()
        if not seen or seen[-1] != observation.step:  # It ended meanwhile otherwise.
            seen.append(observation.step)
        episode.act(observation.step, Recorder.rule(episode.episode_id, observation.step))
    return seen


def test_a_loop_plays_all_episodes_in_order(address: str, world: World) -> None:
    with created(address, sensors=("rgb",), agent_arguments={"beam": 4}, code={"url": "https://e.org"}) as run:
        played = {}
        for episode in run.episodes():
            assert (episode.ended, episode.cause, episode.episode.language) == (False, "", "en")
            played[episode.episode_id] = play_by_rule(episode)
            assert (episode.ended, episode.cause) == (True, "AGENT_FINISHED")
            assert list(episode.actions) == BY_RULE[episode.episode_id]
        assert played == {episode_id: [0, 1, 2, 3, 4] for episode_id in BY_RULE}
        assert run.wait() == run.info
        assert (run.info.state, run.info.ended, run.run_id) == ("complete", 4, RUN)
        assert run.report()["run"]["run_id"] == RUN
        assert episode.scores() == {row: dict.fromkeys(METRICS, 0.25) for row in ("turn 1", "turn 2", "total")}
    assert world.actions == BY_RULE
    (request,) = world.requests
    assert (request.agent, request.split, list(request.sensors)) == ("mine", "val_seen", ["rgb"])
    assert [(each.name, each.value) for each in request.agent_arguments] == [("beam", "4")]
    assert request.code.url == "https://e.org"
    assert [opening.max_episodes for opening in world.opens] == [1]


def test_looking_is_read_only(address: str, world: World) -> None:
    with created(address) as run:
        episode = first(run)
        assert episode.look() is episode.look()
        assert episode.look().rgb is not None
    assert world.batches == []


def test_a_repeated_act_takes_no_step_and_returns_what_follows(address: str, world: World) -> None:
    with created(address) as run:
        episode = first(run)
        after = episode.act(0, LEFT)
        assert after is not None
        assert (after.step, episode.act(0, LEFT), episode.act(0, [LEFT])) == (1, after, after)
        assert episode.act(1, [1, 1]) == episode.act(1, [1, 1]) == episode.act(0, [1, 1, 1]) == episode.look()
        assert episode.look().step == 3
        assert episode.act(3, [1, 1]) is None
        assert episode.act(4, 1) is None
        assert episode.act(3, [1, 1]) is None
    assert world.actions["e0"] == [1, 1, 1, 1, 1]


def test_another_act_for_a_spent_step_names_the_present_one(address: str, world: World) -> None:
    with created(address) as run:
        episode = first(run)
        episode.act(0, [1, 1])
        with pytest.raises(StepSpentError) as caught:
            episode.act(1, 2)
        assert str(caught.value) == (
            "step 1 of episode e0 was answered with 1, which remains recorded; the present step is 2"
        )
        error = caught.value
        assert (error.episode_id, error.step, error.present, error.recorded) == ("e0", 1, 2, 1)
        with pytest.raises(StepSpentError):
            episode.act(0, [1, 2])
        with pytest.raises(StepAheadError, match="step 3 of episode e0 is ahead of the present step, 2"):
            episode.act(3, 1)
        episode.act(2, [1, 1, 1])
        with pytest.raises(StepSpentError, match="the episode has ended"):
            episode.act(4, 2)
    assert world.actions["e0"] == [1] * 5


def test_a_plan_stops_when_something_unexpected_happens(address: str, world: World) -> None:
    """All frames of the scripted server are identical, so that FORWARD is always blocked."""
    with created(address) as run:
        episode = first(run)
        after = episode.act(0, [1, 2, 0, 0, 0])
        assert (after and after.step, episode.stop_reason) == (3, "blocked")
        assert episode.act(0, [1, 2, 0, 0, 0]) == after
        after = episode.act(3, FORWARD)
        assert (after and after.step, episode.stop_reason) == (4, "")
        assert (episode.act(4, [1, 1]), episode.stop_reason) == (None, "episode over")
    assert world.actions["e0"] == [1, 2, 0, 0, 1]


@pytest.mark.parametrize(
    ("act", "note", "message"),
    [
        (4, None, "the act has the action 4, expected an action from 0 to 3, or a sequence of 1 to 1000 actions"),
        (True, None, "the act is True"),
        ("1", None, "the act is '1'"),
        (1.0, None, r"the act has the action 1\.0"),
        ([], None, "the act has no actions"),
        (itertools.repeat(1), None, "the act has more than 1000 actions"),
        ({1, 2}, None, "the act is {1, 2}"),
        ([0, None], None, "the act has the action None"),
        (1, "x" * 2049, "a note has 2049 bytes in UTF-8, expected at most 2048"),
        (1, "ह" * 700, "a note has 2100 bytes"),
        (1, {"a": {1, 2}}, "the note cannot be written as JSON"),
        (1, 5, "the note is of type int, expected text or a mapping"),
        (1, "\ud800", "the note is not valid Unicode: surrogates not allowed at character 0"),
    ],
)
def test_bad_acts_take_no_step(address: str, world: World, act: Any, note: Any, message: str) -> None:
    with created(address) as run:
        episode = first(run)
        with pytest.raises(UsageError, match=message):
            episode.act(0, act, note)
        assert episode.look().step == 0
    assert world.batches == []


@pytest.mark.parametrize("step", [-1, "0", None, 0.0, True])
def test_a_step_is_a_whole_number(address: str, world: World, step: Any) -> None:
    with created(address) as run, pytest.raises(UsageError, match="expected a whole number from 0"):
        first(run).act(step, LEFT)
    assert world.batches == []


def test_notes_are_sent_with_the_first_step(address: str, world: World) -> None:
    with created(address) as run:
        episode = first(run)
        episode.act(0, [1, 1], note="at the corner")
        episode.act(2, 1, note={"goal": [1, 2], "शब्द": "मग"})
    assert world.notes == {("e0", 0): "at the corner", ("e0", 2): '{"goal":[1,2],"शब्द":"मग"}'}


@pytest.mark.parametrize("parallel", [1, 4])
@pytest.mark.parametrize("cut", [
    {1: "before"}, {1: "after"}, {7: "before"}, {20: "after"}, {2: "after", 3: "before", 9: "after", 14: "before"},
])  # fmt: skip
def test_cut_streams_do_not_change_the_actions(address: str, world: World, cut: dict[int, str], parallel: int) -> None:
    world.cut = cut
    notices: list[str] = []
    with created(address, parallel=parallel, notify=notices.append) as run:
        for episode in run.episodes():
            assert play_by_rule(episode) == [0, 1, 2, 3, 4]
        assert run.wait().state == "complete"
    assert world.actions == BY_RULE
    assert len({opening.player for opening in world.opens}) == 1
    assert "UNAVAILABLE: cut" in notices[0]


def test_the_end_of_an_episode_that_a_broken_stream_loses_is_unknown(address: str, world: World) -> None:
    world.cut = {5: "after"}
    with created(address) as run:
        episode = first(run)
        assert episode.act(0, [1] * 5) is None
        assert (episode.ended, episode.cause, world.causes["e0"]) == (True, "UNKNOWN", types_pb2.CAUSE_AGENT_FINISHED)


def test_episodes_are_played_at_their_own_pace_in_threads(address: str, world: World) -> None:
    """The first episode waits until all others have ended."""
    over = threading.Event()
    with created(address, parallel=4) as run:
        episodes = [*islice(run.episodes(), 4)]

        def play(episode: RunEpisode) -> None:
            if episode.episode_id == "e0":
                assert over.wait(60)
            play_by_rule(episode)

        threads = [threading.Thread(target=play, args=(episode,)) for episode in episodes]
        for thread in threads:
            thread.start()
        for thread in threads[1:]:
            thread.join(60)
        assert world.actions["e0"] == []
        over.set()
        run.wait()
    assert world.actions == BY_RULE


def test_threads_that_act_at_once_take_each_step_once(address: str, world: World) -> None:
    with created(address) as run:
        episode = first(run)
        found: list[Any] = []
        threads = [threading.Thread(target=lambda: found.append(episode.act(0, [1, 1, 1]))) for _ in range(5)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60)
        assert found == [episode.look()] * 5
    assert world.actions["e0"] == [1, 1, 1]


def half_played(world: World) -> None:
    world.create(pb.CreateRunRequest(agent="mine", split="val_seen", language="en"))
    world.actions = {"e0": [0, 1, 2]}
    world.players = {"e0": "another"}


def test_a_resumed_run_continues_with_its_present_observation(address: str, world: World) -> None:
    half_played(world)
    with Run.resume(RUN, server=address) as run:
        episode = first(run)
        assert (episode.look().step, episode.look().taken) == (3, None)
        assert episode.act(0, [0, 1, 2]) == episode.act(2, 2) == episode.look()
        with pytest.raises(StepSpentError, match="step 1 of episode e0 was answered with 1"):
            episode.act(1, 3)
        play_by_rule(episode)
        for other in run.episodes():
            play_by_rule(other)
    assert world.opens[0].adopt
    assert world.actions == BY_RULE


@pytest.mark.parametrize(("cut", "acts"), [({}, 2), ({1: "before"}, 3), ({2: "after"}, 2)])
def test_a_resumed_run_shows_its_history_on_request(address: str, world: World, cut: dict[int, str], acts: int) -> None:
    half_played(world)
    world.cut = cut
    with Run.resume(RUN, server=address, history=True) as run:
        episode = first(run)
        assert (episode.look().step, episode.look().taken) == (0, 0)
        with pytest.raises(StepSpentError, match="step 0 of episode e0 was answered with 0"):
            episode.act(0, 3)
        after = episode.act(0, 0)
        assert (after and after.step, after and after.taken) == (1, 1)
        after = episode.act(1, [1, 2])
        assert (after and after.step, after and after.taken) == (3, None)
        play_by_rule(episode)
    assert world.actions["e0"] == BY_RULE["e0"]
    assert world.acts == acts


def test_an_episode_that_another_client_has_taken_over_is_lost(address: str, world: World) -> None:
    with created(address) as run:
        episode = first(run)
        episode.look()
        world.players["e0"] = "another"
        with pytest.raises(EpisodeLostError, match="another client or stream has taken over episode e0"):
            episode.act(0, 1)
        assert not episode.ended


def test_an_episode_can_be_given_up(address: str, world: World) -> None:
    with created(address) as run:
        episode = first(run)
        episode.act(0, 1)
        episode.give_up("no idea")
        episode.give_up("again")
        assert (episode.cause, world.reasons, episode.act(1, 1)) == ("FORFEITED", {"e0": "no idea"}, None)
        assert next(run.episodes()).episode_id == "e1"


def test_a_closed_run_is_resumable_and_its_calls_fail(address: str, world: World) -> None:
    with created(address) as run:
        episode = first(run)
        episode.act(0, 1)
    run.close()
    for call in (episode.look, lambda: episode.act(1, 1), lambda: next(run.episodes()), run.wait):
        with pytest.raises(RunClosedError, match=f"run {RUN} is closed in this program"):
            call()
    with Run.resume(RUN, server=address) as run:
        assert first(run).look().step == 1


def test_closing_ends_a_call_that_waits(address: str) -> None:
    errors: list[Exception] = []
    with created(address) as run:
        first(run)

        def wait() -> None:
            try:
                run.wait()
            except RunClosedError as error:
                errors.append(error)

        thread = threading.Thread(target=wait)
        thread.start()
    thread.join(60)
    assert len(errors) == 1


def test_a_server_that_stays_away_is_an_error_of_every_call(world: World) -> None:
    context = serving(Servicer(world))
    with created(context.__enter__(), patience=0.3) as run:
        episode = first(run)
        episode.look()
        context.__exit__(None, None, None)
        for call in (lambda: episode.act(0, 1), run.wait, episode.look):
            with pytest.raises(ServerUnreachableError, match=f"--resume {RUN}"):
                call()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"split": "none"}, "the server has no split 'none'"),
        ({"sensors": "rgb"}, "sensors is 'rgb', expected a sequence of names"),
        ({"sensors": ("oracle",)}, "does not offer the sensor oracle"),
        ({"encoding": "gif"}, "encoding is 'gif', expected one of shared, raw, zstd, jpeg"),
        ({"parallel": 99}, "the server allows at most 32 parallel episodes"),
        ({"code": {"repo": "x"}}, "expected a mapping with some of url, commit, image"),
        ({"data": "folder"}, "data applies to the embedded server"),
        ({"sensor": ()}, "unknown option sensor; expected some of agent_arguments, code, data,"),
    ],
)
def test_wrong_options_create_no_run(address: str, world: World, options: dict[str, Any], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        created(address, **options)
    assert world.requests == []


def test_runs_are_listed(address: str, world: World) -> None:
    half_played(world)
    (found,) = Run.list(server=address)
    assert (found.run_id, found.state, found.agent, found.episodes, found.is_over) == (RUN, "running", "mine", 4, False)


def test_only_runs_that_exist_are_resumed(address: str) -> None:
    with pytest.raises(UsageError, match="'7' is not the id of a run"):
        Run.resume("7", server=address)
    with pytest.raises(RefusedError, match="there is no run"):
        Run.resume("0" * 32, server=address)


def test_the_patience_holds_for_the_server_of_a_run_that_is_resumed() -> None:
    with pytest.raises(ServerUnreachableError, match=f"the server was unreachable .*resume {RUN}"):
        Run.resume(RUN, server="127.0.0.1:9", patience=0.1)


def test_scores_of_an_open_run_are_an_error(address: str) -> None:
    with created(address) as run:
        episode = first(run)
        for call in (run.report, run.receipt, episode.scores):
            with pytest.raises(UsageError, match="when it is over, but only 0 of its 4 episodes have ended"):
                call()
